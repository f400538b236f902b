"""A branch and its fold moved to a changed problem: each state from its old self plus the change of those beside it."""

from dataclasses import dataclass

import numpy as np

from ..continuation.interpolation import combine, lagrange
from .branch import Branch, Fold, NotFollowed


@dataclass(frozen=True)
class Limits:
    """Of following; a "unit" is the problem's `unit`."""

    arc: float = 0.05  # units between the first two points about a fold
    sharpness: float = 3e-6  # units, error of the load of a fold as predicted from the points before
    farthest: float = 0.5  # units from the fold's predicted place on its arc
    points: int = 8  # about a fold, at most
    near: int = 4  # known changes, from which that of a state is interpolated
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
    v, active = solving.at(old.v[0] + change, old.active[0], start, f"the beginning of {what}")
    known = {0: (v, active)}
    fold = None
    if old.fold:
        fold = followed_fold(solving, old.fold, v - old.v[0], f"the end of {what}")
        end, known[n] = fold.load, (fold.v, fold.active)
    if not end > start:
        raise NotFollowed(f"{what} has no states left")
    loads = Branch(start, end, old.v, old.active, fold).loads
    for i in _by_halves(n):
        if i in known:
            continue
        guess = old.v[i] + _change(old, known, i)
        known[i] = v, active = solving.at(guess, old.active[i], loads[i], f"a state of {what}")
        if len(known) > LIMITS.near and np.abs(v - guess).max() > LIMITS.surprise * solving.problem.unit:
            raise NotFollowed(f"a state of {what} lies on another branch")
    v, active = (np.array([known[i][part] for i in range(n + 1)]) for part in (0, 1))
    return Branch(start, end, v, active, fold)


def _change(old, known, i):
    """Of state i, interpolated from those known nearest."""
    near = sorted(known, key=lambda j: abs(j - i))[: LIMITS.near]
    return combine(lagrange(near, i), [known[j][0] - old.v[j] for j in near])


def _by_halves(n):
    """0 .. n, so that most lie between others."""
    order, step = [0, n], n
    while step > 1:
        step = (step + 1) // 2
        order += [i for i in range(step, n, step) if i not in order]
    return order + [i for i in range(n) if i not in order]
