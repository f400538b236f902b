"""Whether the states of a branch tell what lies between them, from how well every second of them tells the others."""

import numpy as np

from .branch import STENCIL
from .moving import refined
from .skeleton import tractions

TOLD = 2e-4  # of the largest force
HALF = 16.0  # times larger errors with every second state only, at least; in the limit 2 to the power of STENCIL
FINEST = 100  # intervals, from which on a branch is not divided any more
FEWEST = 12  # intervals, below which no states are left out


def resolved(scene, first, solving, branch, what):
    """The Branch with as many states as it takes: more are solved for, or every second is left out."""
    while branch.intervals < FINEST and _error(scene, first, branch) > HALF * TOLD:
        branch = refined(solving, branch, what)
    while branch.intervals % 2 == 0 and branch.intervals >= 2 * FEWEST and _error(scene, first, branch) < 0.5 * TOLD:
        branch = branch.thinned()
    return branch


def forces_between(scene, first, v):
    """(sums of T_x and T_z (k, 2) over the patch, GPa, of unknowns v (k, size); what they are compared with)."""
    sums = tractions(scene, first, v).sum(axis=2)
    largest = np.abs(sums).max(axis=0, initial=1e-300)
    return sums, np.maximum(largest, 1e-2 * largest.max())  # a flat may carry no normal load at all


def _error(scene, first, branch):
    """The largest error of forces at every second state, as the others tell them."""
    if branch.intervals % 2 or branch.intervals // 2 + 1 < STENCIL:
        return 0.0
    told = branch.thinned().states(branch.loads[1::2], branch.v.shape[1] // 2)
    known, largest = forces_between(scene, first, branch.v)
    return float((np.abs(forces_between(scene, first, told)[0] - known[1::2]) / largest).max())
