"""A branch and its fold moved to a changed problem: each state from its old self plus the change of those beside it."""

from dataclasses import dataclass

import numpy as np

from ..continuation.interpolation import combine, lagrange
from .branch import Branch, Fold, NotFollowed, weights_near


@dataclass(frozen=True)
class Limits:
    """Of following; a "unit" is the problem's `unit`."""

    arc: float = 0.05  # units between the first two points about a fold
    sharpness: float = 3e-6  # units, error of the load of a fold as predicted from the points before
    farthest: float = 0.5  # units from the fold's predicted place on its arc
    points: int = 8  # about a fold, at most
    near: int = 3  # changes of states before, from which that of a state is extrapolated
    rough: float = 1e-3  # units, of the residual where the load of a fold is but estimated
    surprise: float = 0.25  # units from there, beyond which a state lies on another branch


LIMITS = Limits()


def followed_fold(solving, old, change, what):
    """The Fold of the problem that `old` (Fold) becomes; change (size,): a guess of how it moves."""
    unit, index, bend = solving.problem.unit, old.index, old.bend
    v, active, load = old.v + change, old.active, old.load
    begin = arc = v[index]
    points = []  # (arc, load, v)
    predicted = np.inf
    for _ in range(LIMITS.points):
        load, v, active = solving.on_arc(v, active, load, index, arc, what)
        points.append((arc, load, v))
        if abs(load - predicted) < LIMITS.sharpness * unit:
            break
        if len(points) == 1:
            arc, v = arc + LIMITS.arc * unit, v + LIMITS.arc * unit * old.along
            continue
        bend, arc, predicted = _vertex(points, bend)
        if not bend < 0.0 or abs(arc - begin) > LIMITS.farthest * unit:
            raise NotFollowed(f"{what} is no longer a fold, or has moved too far")
        near = sorted(points, key=lambda p: abs(p[0] - arc))[:3]
        weights = lagrange([p[0] for p in near], arc)
        v, load = combine(weights, [p[2] for p in near]), predicted
    else:
        raise NotFollowed(f"{what} is not found in {LIMITS.points} points")
    far = max(points, key=lambda p: abs(p[0] - arc))
    bend = 2.0 * (far[1] - load) / (far[0] - arc) ** 2
    return Fold.of(load, v, active, (far[2] - v) / (far[0] - arc), bend)


def _vertex(points, bend):
    """(bend, arc, load) at the top of the parabola through the last points (arc, load, v), with that bend if only two."""
    (a, fa, _), (b, fb, _) = points[0], points[1]
    slope = (fb - fa) / (b - a)
    if len(points) > 2:
        c, fc, _ = points[-1]
        if min(abs(c - a), abs(c - b)) > 0.1 * abs(b - a):
            bend = 2.0 * ((fc - fb) / (c - b) - slope) / (c - a)
        a, fa, slope = c, fc, (fc - fa) / (c - a) if abs(c - a) > abs(c - b) else (fc - fb) / (c - b)
        b = points[0][0] if abs(c - points[0][0]) > abs(c - points[1][0]) else points[1][0]
    here = slope - 0.5 * bend * (b - a)  # at a
    top = a - here / bend
    return bend, top, fa - 0.5 * here**2 / bend


def followed_branch(solving, old, start, end, change, what):
    """The Branch that `old` becomes from load `start` on; change (size,): of its first state, a guess.

    end: where it ends if not in a fold, else None.
    """
    n = old.intervals
    found = [solving.at(old.v[0] + change, old.active[0], start, f"the beginning of {what}")]
    if old.fold:
        end = _nearly(solving, old.fold, found[0][0] - old.v[0], f"the end of {what}")
    if not end > start:
        raise NotFollowed(f"{what} has no states left")
    loads = Branch(start, end, old.v, old.active, old.fold).loads
    changes = [found[0][0] - old.v[0]]
    for i in range(1, n if old.fold else n + 1):
        guess = old.v[i] + _extrapolated(changes, i)
        v, active = solving.at(guess, old.active[i], loads[i], f"a state of {what}")
        if i >= LIMITS.near and np.abs(v - guess).max() > LIMITS.surprise * solving.problem.unit:
            raise NotFollowed(f"a state of {what} lies on another branch")
        found.append((v, active))
        changes.append(v - old.v[i])
    if not old.fold:
        return Branch(start, end, *_stacked(found))
    fold = followed_fold(solving, old.fold, _extrapolated(changes, n), f"the end of {what}")
    if not fold.load > loads[n - 1]:
        raise NotFollowed(f"{what} ends earlier than its states")
    found.append((fold.v, fold.active))
    v, active = _stacked(found)
    return _evenly(start, fold, np.append(loads[:n], fold.load), v, active)


def _nearly(solving, fold, change, what):
    """A load close to, but below, that of the fold that `fold` becomes."""
    v = fold.v + change
    with solving.roughly(LIMITS.rough * solving.problem.unit):
        return solving.on_arc(v, fold.active, fold.load, fold.index, v[fold.index], what)[0]


def _extrapolated(changes, i):
    """The change of state i from those of the states before it."""
    near = range(max(0, len(changes) - LIMITS.near), len(changes))
    return combine(lagrange(near, i), [changes[j] for j in near])


def _stacked(found):
    return tuple(np.array([one[part] for one in found]) for part in (0, 1))


def _evenly(start, fold, loads, v, active):
    """The Branch to a fold from states at loads (n + 1,) that are not quite those of even t."""
    branch = Branch(start, fold.load, v, active, fold)
    t = branch.t_at(loads)
    even = [weights_near(t, at) for at in np.linspace(0.0, 1.0, t.size)[1:-1]]
    between = [combine(weights, v[near]) for near, weights in even]
    return Branch(start, fold.load, np.array([v[0], *between, v[-1]]), active, fold)
