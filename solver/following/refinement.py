"""How many states a branch needs: its interpolation error, estimated by leaving out every second state."""

from dataclasses import replace

import numpy as np

from ..scene import Scene
from .branch import DEGREE, Branch
from .moved import SURPRISE, Solver
from .skeleton import tractions

ERROR = 2e-4  # of the largest force, between states: a fifth of what followed runs promise
# without every second state errors are larger by that, at least, on the uneven states of the slider box; and 2^6 in the
# limit of even ones. With 16, 2 % of 149 moves were off by more than 1e-3
HALF, LIMIT = 8.0, 64.0
FINEST = 300  # intervals: smooth sliding close to stick-slip takes 150, where it jerks
FEWEST = 12  # intervals, below which no states are left out


def refined(scene: Scene, first: int, solver: Solver, branch: Branch, number: int) -> Branch:
    """The Branch with as many states as its forces need: more are solved for, or some left out."""
    while branch.intervals < FINEST:
        every = [_errors(scene, first, branch, begin) for begin in (1, 2)]
        poor = np.concatenate([out[errors > HALF * ERROR] for out, errors in every])
        if not poor.size:
            break
        branch = divided(solver, branch, np.union1d(poor - 1, poor), number)
    return thinned(scene, first, branch)


def thinned(scene: Scene, first: int, branch: Branch) -> Branch:
    """The Branch without states whose neighbours describe the forces well enough."""
    while branch.intervals >= 2 * FEWEST:
        out, errors = _errors(scene, first, branch, 1)
        out = out[errors < HALF / LIMIT * ERROR]  # with a larger error, the others would have to be divided again
        if not out.size:
            break
        branch = branch.without(out)
    return branch


def divided(solver: Solver, branch: Branch, where: np.ndarray, number: int) -> Branch:
    """The same Branch with one more state in the middle of each of the intervals `where`."""
    amid = 0.5 * (branch.t[where] + branch.t[where + 1])
    loads = branch.load_at(amid)
    v, active = branch.states(loads, solver.moving), branch.active[where].copy()
    for i, (load, k) in enumerate(zip(loads, where, strict=True)):
        gap = np.abs(branch.v[k + 1] - branch.v[k]).max() / solver.problem.unit  # within it, a state may be anywhere
        v[i], active[i] = solver.state(v[i], active[i], load, f"a state of branch {number}", max(gap, SURPRISE))
    old, new = (branch.t, branch.v, branch.active), (amid, v, active)
    t, v, active = (np.insert(rows, where + 1, more, 0) for rows, more in zip(old, new, strict=True))
    return replace(branch, t=t, v=v, active=active)


def forces_of(scene: Scene, first: int, v: np.ndarray, minor: float = 1e-2) -> tuple[np.ndarray, np.ndarray]:
    """(sums of T_x and T_z over the patch, (k, 2) GPa, of unknowns v (k, size); the scales of their errors, (2,)).

    A scale is the largest sum, or `minor` times the larger of both: a flat may carry no normal load at all.
    """
    sums = tractions(scene, first, v).sum(axis=2)
    largest = np.abs(sums).max(axis=0, initial=1e-300)
    return sums, np.maximum(largest, minor * largest.max())


def _errors(scene, first, branch, begin):
    """(every second state from `begin` on, errors of their forces interpolated from the others, over the largest)."""
    out = np.arange(begin, branch.intervals, 2)
    if branch.intervals // 2 < DEGREE:
        return out, np.zeros(out.size)
    between = branch.without(out).states(branch.loads[out], branch.v.shape[1] // 2)
    exact, largest = forces_of(scene, first, branch.v)
    return out, (np.abs(forces_of(scene, first, between)[0] - exact[out]) / largest).max(axis=1)
