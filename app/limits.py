"""How large a run in the app may be, and with which preset it begins."""

from solver.presets import presets
from solver.run.load_steps import load_steps_of

INCREMENTS, NUMBERS = 5000, 2_500_000  # of one run, and times nodes: what a browser holds and draws with ease
MOST = {"nodes": 4096, "u_x_max": 1000.0}  # in the app; `python -m solver run` goes up to the solver's own limits
DEFAULT = next(iter(presets()))  # the name of a preset


def increments_of(scene):
    """How many increments a run of the scene takes, as far as is known before."""
    return sum(step.increments + 1 for step in load_steps_of(scene))
