"""The methods that are compared, by name, and one way to run them all: the two of `load_path` and two variants."""

from ..run.loadpath import METHODS, load_path
from .fire import Fire, MassWeighted

SERIES = {
    "fast": "fast: secant steps on a branch, the damped motion between branches",
    "gfmd": "gfmd: damped motion of modes of one mass",
    "gfmd mass-weighted": "gfmd mass-weighted: each mode's mass is its stiffness",
    "FIRE": "FIRE: mass-weighted, stopped where F.v < 0",
}
VARIANTS = {"gfmd mass-weighted": MassWeighted, "FIRE": Fire}


def frames(scene, series):
    """The Frames of a scene by one of SERIES, or by any class under the contract of `Gfmd`; raises NotConverged."""
    return load_path(scene, series if series in METHODS else VARIANTS.get(series, series))
