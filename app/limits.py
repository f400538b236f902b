"""Limits of a run in the app, and the default preset."""

from solver import Scene
from solver.presets import presets
from solver.run.load_steps import load_steps_of

INCREMENTS, NUMBERS = 5000, 2_500_000  # increments of a run; increments times nodes, which a browser draws easily
FLAT = 160  # nodes sent to a browser of a flat surface, where all are alike
MOST = {"nodes": 4096, "u_x_max": 1000.0}  # in the app; `python -m solver run` allows the solver's own limits
DEFAULT = next(iter(presets()))  # the name of a preset


def increments_of(scene: Scene) -> int:
    """Return the expected number of increments of a run of the scene."""
    return sum(step.increments + 1 for step in load_steps_of(scene))
