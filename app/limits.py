"""How much a run in the app may be, how coarse one that follows a hand, and with which preset it begins."""

from solver.presets import presets
from solver.run.load_steps import load_steps_of

INCREMENTS, NUMBERS = 5000, 2_500_000  # of one run, and times nodes: what a browser holds and draws with ease
MOST = {"nodes": 4096, "u_x_max": 1000.0}  # in the app; `python -m solver run` goes up to the solver's own limits
STEP = 0.5  # delta_t, delta_n: of the increments while a slider is held; slips are located all the same
SHORTEST = 40  # such increments at least
LOOSE = 1e-6  # nm, tolerance of such a run
DEFAULT = next(iter(presets()))  # the name of a preset


def increments_of(scene):
    """How many increments a run of the scene takes, as far as is known before."""
    return sum(step.increments + 1 for step in load_steps_of(scene))


def coarse(scene):
    """The scene with larger increments, where a held slider is not followed; a flat's are too near to its period."""
    if scene.surface == "flat":
        return scene
    step = max(scene.du_x, min(STEP, scene.u_x_max / (SHORTEST * scene.delta_t)))
    return scene.changed(du_x=step, du_z=max(scene.du_z, STEP), tolerance=max(scene.tolerance, LOOSE))
