"""The methods that are compared, by name, and one way to run them all: the two of `load_path` and two variants."""

from dataclasses import replace

import numpy as np

from .contact import patch, wider
from .fire import Fire
from .gfmd import MassWeighted
from .legs import legs_of
from .loadpath import BULGE, METHODS, _frame, _widened, load_path
from .state import Increment

SERIES = {
    "fast": "fast: secant steps on a branch, the overdamped flow between branches",
    "gfmd": "gfmd: damped motion of modes of one mass",
    "gfmd mass-weighted": "gfmd mass-weighted: each mode's mass is its stiffness",
    "FIRE": "FIRE: mass-weighted, stopped where F.v < 0",
}
VARIANTS = {"gfmd mass-weighted": MassWeighted, "FIRE": Fire}


def frames(scene, series):
    """The Frames of a scene by one of SERIES, or by any class under the contract of `Gfmd`; raises NotConverged."""
    if series in METHODS:
        return load_path(scene, series)
    return _path(scene, VARIANTS.get(series, series))


def _path(scene, variant):
    """As `load_path`, by a method that the command line does not offer."""
    first, size = patch(scene, BULGE)
    solver, state = variant(scene, first, size), None
    for leg in legs_of(scene):
        loading = leg.loading
        state = state and replace(state, load=leg.at(0))  # the end of the approach is the start of the shear
        for k, load in enumerate(map(leg.at, range(leg.increments + 1))):
            count = -solver.contact.evaluations
            done = _increment(solver, state, loading, load)
            while _too_narrow(solver.contact, done, loading.at(load)[1]):
                count += solver.contact.evaluations
                before, (first, size) = first, wider(scene, first, size)
                state = state and _widened(scene, leg, state, before, first, size)
                solver = variant(scene, first, size)
                done = _increment(solver, state, loading, load)
            state = done.state
            yield _frame(scene, leg, k, load, first, done, count + solver.contact.evaluations)


def _too_narrow(contact, done, height):
    """Whether nodes outside the patch may act, as in `load_path`."""
    return contact.crowded(done.state.active) or contact.overlooked(done.traction, height)


def _increment(solver, state, loading, load):
    """One increment; nothing to solve while no spring acts yet, as in `load_path`."""
    contact = solver.contact
    if loading.name == "delta" and contact.lowest - load > contact.window:
        rest = solver.undeformed(loading, load)
        return Increment(rest, np.zeros_like(rest.u), 0.0)
    return solver.increment(state or solver.undeformed(loading, load), loading, load)
