"""Whether the states of a branch tell what lies between them."""

import numpy as np

from .branch import STENCIL
from .skeleton import tractions

TOLD = 2e-4  # of the largest force
HALF = 32.0  # times larger errors with every second state only; in the limit 2 to the power of STENCIL


def sums(scene, first, v):
    """Sums of T_x and T_z (k, 2) over the patch, GPa, of unknowns v (k, size)."""
    return tractions(scene, first, v).sum(axis=2)


def not_told(scene, first, branch):
    """Whether forces between the states of a Branch may be wrong by more than TOLD: from every second state."""
    n = branch.intervals
    if n % 2 or n // 2 + 1 < STENCIL:
        return False
    half, odd = branch.thinned(), branch.loads[1::2]
    found = sums(scene, first, half.states(odd, branch.v.shape[1] // 2))
    known = sums(scene, first, branch.v)
    return bool((np.abs(found - known[1::2]).max(axis=0) > HALF * TOLD * np.abs(known).max(axis=0)).any())
