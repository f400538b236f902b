"""How many states a branch needs: its interpolation error, estimated by leaving out every second state."""

from dataclasses import replace

import numpy as np

from ..continuation.state import TINY, Point
from ..continuation.trace import FEWEST_STATES, STENCIL, Branch
from ..scene import Scene
from .moved import SURPRISE, Solver
from .skeleton import tractions

ERROR = 2e-4  # of the largest force, between states: a fifth of what followed runs promise
# power of an interval's length with which errors grow, at least, on the uneven states of the slider box; 6 in the limit
# of even ones. With 4, 2 % of 149 moves were off by more than 1e-3
ORDER, LIMIT = 3, 6
FINEST = 300  # intervals: smooth sliding close to stick-slip takes 150, where it jerks


def refined(scene: Scene, first: int, solver: Solver, branch: Branch, number: int, error: float = ERROR) -> Branch:
    """The Branch with as many states as its forces need: more are solved for, or some left out.

    error: of the forces between states, over the largest.
    """
    while branch.slip is not None and len(branch.states) < FEWEST_STATES:  # others that are short are nearly straight
        branch = divided(solver, branch, np.arange(len(branch.states) - 1), number)
    while len(branch.states) <= FINEST:
        poor = np.unique(np.concatenate([_poor(scene, first, branch, begin, error) for begin in (1, 2)]))
        if not poor.size:
            break
        branch = divided(solver, branch, poor, number)
    return thinned(scene, first, branch, error)


def thinned(scene: Scene, first: int, branch: Branch, error: float = ERROR) -> Branch:
    """The Branch without states whose neighbours describe the forces well enough."""
    while len(branch.states) > 2 * FEWEST_STATES:
        out, errors = _errors(scene, first, branch, 1)
        out = out[errors < 2.0 ** (ORDER - LIMIT) * error]  # with a larger error, the others would be divided again
        if not out.size:
            break
        branch = branch.without(out)
    return branch


def _poor(scene, first, branch, begin, error):
    """Indices of intervals whose interpolated forces have a larger error, estimated over pairs of intervals."""
    out, errors = _errors(scene, first, branch, begin)
    length = np.diff(_position(branch))
    both = length[out - 1] + length[out]
    return np.concatenate([k[errors * (length[k] / both) ** ORDER > error] for k in (out - 1, out)])


def _position(branch):
    """t of the states; of a period, the last one is at 1."""
    t = branch.position(branch.loads)
    t[-1] = 1.0
    return t


def divided(solver: Solver, branch: Branch, where: np.ndarray, number: int) -> Branch:
    """The same Branch with one more state in the middle of each of the intervals `where`."""
    t = _position(branch)
    loads = branch.load_at(0.5 * (t[where] + t[where + 1]))
    states, what = [], f"a state of branch {number}"
    for guess, load, k in zip(branch.unknowns(loads), loads.tolist(), where, strict=True):
        before, after = branch.states[k : k + 2]
        gap = np.abs(after.v - before.v).max() / solver.problem.unit  # within it, a state may be anywhere
        states.append(Point(load, solver.state(guess, load, what, max(gap, SURPRISE))))
    return replace(branch, states=tuple(sorted((*branch.states, *states), key=lambda state: state.load)))


def forces_of(scene: Scene, first: int, v: np.ndarray, minor: float = 1e-2) -> tuple[np.ndarray, np.ndarray]:
    """(sums of T_x and T_z over the patch, (k, 2) GPa, of unknowns v (k, size); the scales of their errors, (2,)).

    A scale is the largest sum, or `minor` times the larger of both: a flat may carry no normal load at all.
    """
    sums = tractions(scene, first, v).sum(axis=2)
    largest = np.abs(sums).max(axis=0, initial=TINY)
    return sums, np.maximum(largest, minor * largest.max())


def _errors(scene, first, branch, begin):
    """(every second state from `begin` on, errors of their forces interpolated from the others, over the largest)."""
    out = np.arange(begin, len(branch.states) - 1, 2)
    if len(branch.states) // 2 < STENCIL:
        return out, np.zeros(out.size)
    v = branch.v
    between = branch.without(out).unknowns(branch.loads[out])
    exact, largest = forces_of(scene, first, v)
    return out, (np.abs(forces_of(scene, first, between)[0] - exact[out]) / largest).max(axis=1)
