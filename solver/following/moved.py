"""A branch moved to a changed problem: its fold first, then the states before it, one by one."""

from dataclasses import replace

import numpy as np

from ..continuation.fold import Fold
from ..continuation.interpolation import lagrange
from .branch import Branch, NotFollowed
from .solver import SURPRISE, Solver

NEAR = 3  # changes of states from which that of the next one is extrapolated; 2 and 4 take as many evaluations
FIRST = 1.5  # units that the first state of a branch without a fold may move: farther off, it is on another branch


def moved_folds(solver: Solver, old: tuple[Branch, ...]) -> list[Fold | None]:
    """The Folds of the new branches from those of the old; each is expected to move as the one before."""
    folds: list[Fold | None] = []
    change = np.zeros(old[0].v.shape[1])
    for k, branch in enumerate(old, 1):
        fold = branch.fold
        if fold is not None:
            new = solver.fold(replace(fold, v=fold.v + change, psi=None), f"the end of branch {k}")
            change, fold = new.v - fold.v, new
        folds.append(fold)
    return folds


def moved_branch(
    solver: Solver, old: Branch, start: float, end: float, fold: Fold | None, number: int, near: int = NEAR
) -> Branch:
    """The Branch `old` moved to the solver's problem, from load `start` to `end`, nm, where its Fold is, or None.

    near: changes of states from which that of the next one is extrapolated; 0: no change is expected.
    """
    what = f"a state of branch {number}"
    if not end > start:
        raise NotFollowed(f"branch {number} has no states left", nearer=True)
    new = replace(old, start=start, end=end, v=old.v.copy(), active=old.active.copy(), fold=fold)
    if fold is None:
        order = range(old.intervals + 1)
        first = solver.state(old.v[0], old.active[0], start, what, FIRST)
    else:
        order, first = range(old.intervals, -1, -1), (fold.v, fold.active)
    new.v[order[0]], new.active[order[0]] = first
    _solve(solver, new, old, order, what, near)
    return new


def _solve(solver, new, old, order, what, most):
    """Solve for the states of a new Branch in that order, from extrapolated changes; the first one is solved for."""
    loads, changes = new.loads, [new.v[order[0]] - old.v[order[0]]]
    for i in order[1:]:
        near = changes[-most:] if most else [np.zeros(new.v.shape[1])]
        change = np.asarray(lagrange(range(-len(near), 0), 0)) @ np.asarray(near)
        gap = 0.0 if new.fold else np.abs(np.diff(old.v[max(i - 1, 0) : i + 2], axis=0)).max() / solver.problem.unit
        surprise = max(SURPRISE, gap)  # smooth sliding may jerk, between other states than before
        new.v[i], new.active[i] = solver.state(old.v[i] + change, old.active[i], loads[i], what, surprise)
        changes.append(new.v[i] - old.v[i])
