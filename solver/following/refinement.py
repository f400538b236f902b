"""How many states a branch needs: its interpolation error, estimated by leaving out every second state."""

from dataclasses import replace

import numpy as np

from .branch import DEGREE, Branch
from .skeleton import tractions
from .solver import SURPRISE, Solver

ERROR = 2e-4  # of the largest force, between states: a fifth of what followed runs promise
# an error with every second state only is so many times larger, as measured; in the limit, 2 to the power of 6
HALF, LIMIT = 16.0, 64.0
FINEST = 300  # intervals: smooth sliding close to stick-slip takes 150, where it jerks
FEWEST = 12  # intervals, below which no states are left out


def refined(scene, first: int, solver: Solver, branch: Branch, number: int) -> Branch:
    """The Branch with as many states as its forces need: more are solved for, or some are left out."""
    while branch.intervals < FINEST:
        out, errors = _errors(scene, first, branch)
        poor = out[errors > HALF * ERROR]
        if not poor.size:
            break
        branch = divided(solver, branch, np.union1d(poor - 1, poor), number)
    if branch.intervals < 2 * FEWEST:
        return branch
    out, errors = _errors(scene, first, branch)
    return branch.without(out[errors < HALF / LIMIT * ERROR])  # else the others would have to be divided again


def divided(solver: Solver, branch: Branch, where, number: int) -> Branch:
    """The same Branch with a state solved for amid each of the intervals `where`."""
    amid = 0.5 * (branch.t[where] + branch.t[where + 1])
    loads = branch.load_at(amid)
    v, active = branch.states(loads, solver.moving), branch.active[where].copy()
    for i, (load, k) in enumerate(zip(loads, where, strict=True)):
        gap = np.abs(branch.v[k + 1] - branch.v[k]).max() / solver.problem.unit  # between states, one may be anywhere
        v[i], active[i] = solver.state(v[i], active[i], load, f"a state of branch {number}", max(gap, SURPRISE))
    t = None if where.size == branch.intervals and branch.uneven is None else np.insert(branch.t, where + 1, amid)
    v, active = np.insert(branch.v, where + 1, v, 0), np.insert(branch.active, where + 1, active, 0)
    return replace(branch, v=v, active=active, uneven=t)


def forces_of(scene, first, v, minor=1e-2):
    """(sums of T_x and T_z (k, 2) over the patch, GPa, of unknowns v (k, size); what they are compared with (2,)).

    That is the largest of each, or the share `minor` of the larger one: a flat may carry no normal load at all.
    """
    sums = tractions(scene, first, v).sum(axis=2)
    largest = np.abs(sums).max(axis=0, initial=1e-300)
    return sums, np.maximum(largest, minor * largest.max())


def _errors(scene, first, branch):
    """(every second of the states, what their forces are off by if interpolated from the others, over the largest)."""
    out = np.arange(1, branch.intervals, 2)
    if branch.intervals // 2 < DEGREE:
        return out, np.zeros(out.size)
    between = branch.without(out).states(branch.loads[out], branch.v.shape[1] // 2)
    exact, largest = forces_of(scene, first, branch.v)
    return out, (np.abs(forces_of(scene, first, between)[0] - exact[out]) / largest).max(axis=1)
