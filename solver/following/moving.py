"""A branch and its fold moved to a changed problem: each state from its old self plus the change of those beside it."""

from dataclasses import dataclass, replace

import numpy as np

from ..continuation.interpolation import lagrange
from .branch import Branch, Fold, NotFollowed, place, weights_near


@dataclass(frozen=True)
class Limits:
    """Of following; a "unit" is the problem's `unit`."""

    arc: float = 0.05  # units between the first two points about a fold
    same: float = 1e-7  # nm of arc, within which two points about a fold are one
    sharpness: float = 1e-5  # units from the highest point found to the top of the curve through those nearest
    farthest: float = 1.5  # units from the fold's predicted place on its arc
    near_by: float = 0.15  # units from its guess, within which a fold is told from the states before it
    alike: float = 2.0  # how far its bend may then differ, as a factor
    above: float = 0.02  # units above where it should, at which a branch to itself begins at first: below it may end
    points: int = 12  # about a fold, at most
    near: int = 3  # changes of states before, from which that of a state is extrapolated
    fine: float = 1e-6  # units, of the residual where the load of a fold is told
    nearly: float = 0.05  # units from the load of a fold to what it was estimated to be, beyond which states between
    # are solved for again once it is known
    stride: float = 0.3  # units of arc from one point about a fold to the next, at most
    rough: float = 1e-2  # units, of the residual where the load of a fold is but estimated
    first: float = 1.5  # units from where it was, beyond which the first state of a branch lies on another one
    surprise: float = 0.3  # the same of the others, from where they are expected


LIMITS = Limits()


def followed_fold(solving, old, change, what, before=()):
    """The Fold of the problem that `old` (Fold) becomes.

    change (size,): a guess of how it moves; before: states (load, v) on the way to it, if known.
    """
    unit, index, chord = solving.problem.unit, old.index, np.zeros(old.v.size)
    chord[index] = 1.0
    v, active, load, points = old.v + change, old.active, old.load, []  # (arc, load, v)
    begin = v[index]
    for _ in range(LIMITS.points):
        with solving.within(LIMITS.fine * unit):
            load, v, active = solving.on_arc(v, active, load, chord, what)
        points = [p for p in points if abs(p[0] - v[index]) > LIMITS.same] + [(v[index], load, v)]
        if len(points) == 1:
            points = [*_telling([(v[index], load, v) for load, v in before], points[0], old, unit), *points]
        if len(points) == 1:
            v = v + LIMITS.arc * unit * old.along
            continue
        arc, top, bend = _top(points, old.bend)
        if not bend < 0.0 or abs(arc - begin) > LIMITS.farthest * unit:
            raise NotFollowed(f"{what} is no longer a fold, or has moved too far", nearer=True)
        here = points[-1][0]
        arc = min(max(arc, here - LIMITS.stride * unit), here + LIMITS.stride * unit)
        near = _nearest(points, arc, 4)
        v = _mixed(lagrange([p[0] for p in near], arc), [p[2] for p in near])
        sure = len(near) < 4 or abs(top - _top(near[2::-1], old.bend)[1]) < LIMITS.sharpness * unit
        if sure and abs(load - top) < LIMITS.sharpness * unit:
            far = max(near, key=lambda p: abs(p[0] - arc))
            return Fold.of(top, v, active, (far[2] - v) / (far[0] - arc), bend)
        load = top
    raise NotFollowed(f"{what} is not found in {LIMITS.points} points", nearer=True)


def _telling(before, point, old, unit):
    """The points `before`, if with a point about the fold they tell one close by and bent as it was; else none."""
    if not before:
        return []
    arc, _, bend = _top([*before, point], old.bend)
    close = abs(arc - point[0]) < LIMITS.near_by * unit
    return before if close and 1.0 / LIMITS.alike < bend / old.bend < LIMITS.alike else []


def _nearest(points, arc, count):
    return sorted(points, key=lambda p: abs(p[0] - arc))[:count]


def _top(points, bend):
    """(arc, load, second derivative) at the maximum of the load near the newest of points (arc, load, v), the last.

    From that and the three others nearest. bend: that derivative as it was, used where there are but two points.
    """
    arc = points[-1][0]
    near = _nearest(points, arc, 4)
    x, y = (np.array([p[part] - points[-1][part] for p in near]) for part in (0, 1))
    if len(near) == 2:
        slope = (y[1] - y[0]) / (x[1] - x[0]) - 0.5 * bend * (x[1] + x[0])  # at the newest
        return arc - slope / bend, points[-1][1] - 0.5 * slope**2 / bend, bend
    c = np.zeros(4)
    c[: len(near)] = np.linalg.solve(np.vander(x, increasing=True), y)
    top = -0.5 * c[1] / c[2]
    for _ in range(3):  # Newton's, as the curve is of the third degree
        top -= (c[1] + top * (2.0 * c[2] + top * 3.0 * c[3])) / (2.0 * c[2] + top * 6.0 * c[3])
    height = c[0] + top * (c[1] + top * (c[2] + top * c[3]))
    return arc + top, points[-1][1] + height, 2.0 * c[2] + top * 6.0 * c[3]


def _mixed(weights, rows):
    """sum of weights[i] * rows[i]."""
    return np.asarray(weights) @ np.asarray(rows)


def followed_branch(solving, old, start, end, change, reach, what):
    """The Branch that `old` becomes from load `start` on; change (size,): of its first state, a guess.

    end: where it ends if not in a fold, else None. reach: of a branch to itself, the period of its slips, else None:
    the states in which they land belong to it, at loads below zero as well.
    """
    n, unit = old.intervals, solving.problem.unit
    first = solving.at(old.v[0] + change, old.active[0], start, f"the beginning of {what}")
    _refuse_far(solving, first[0], old.v[0] + change, LIMITS.first, f"the beginning of {what}")
    if old.fold:
        end = _nearly(solving, old.fold, first[0] - old.v[0], f"the end of {what}")
        if reach:
            start, first = _begun(solving, old, start, min(0.0, end - reach + LIMITS.above * unit), first, what)
    if not end > start:
        raise NotFollowed(f"{what} has no states left", nearer=True)
    loads = replace(old, start=start, end=end).loads
    found, changes = [first], [first[0] - old.v[0]]
    for i in range(1, n if old.fold else n + 1):
        guess = old.v[i] + _extrapolated(changes, i)
        v, active = solving.at(guess, old.active[i], loads[i], f"a state of {what}")
        _refuse_far(solving, v, guess, LIMITS.surprise, f"a state of {what}")
        found.append((v, active))
        changes.append(v - old.v[i])
    if not old.fold:
        return Branch(start, end, *_stacked(found), None, old.periodic)
    before = [(load, v) for load, (v, _) in zip(loads[n - 3 : n], found[n - 3 :], strict=True)]
    fold = followed_fold(solving, old.fold, _extrapolated(changes, n), f"the end of {what}", before)
    if not fold.load > loads[n - 1]:
        raise NotFollowed(f"{what} ends earlier than its states", nearer=True)
    loads[n] = fold.load
    found.append((fold.v, fold.active))
    if reach and fold.load - reach < start:
        loads, found = _reaching(solving, loads, found, fold.load - reach, what)
    branch = _evenly(fold, loads, found, n)
    return branch if fold.load - end < LIMITS.nearly * unit else _settled(solving, branch, range(1, n), what)


def _begun(solving, old, start, wanted, first, what):
    """(load, (v, active)) of the first state at load `wanted`, from that at `start`."""
    if wanted == start:
        return start, first
    speed = (old.v[1] - old.v[0]) / (old.loads[1] - old.loads[0])
    return wanted, solving.at(first[0] + (wanted - start) * speed, first[1], wanted, f"the beginning of {what}")


def _reaching(solving, loads, found, start, what):
    """(loads, states) with one more before the first, at load `start`."""
    t = place(start, loads[-1], loads[:4])
    guess = _mixed(lagrange(t, 0.0), [v for v, _ in found[:4]])
    first = solving.at(guess, found[0][1], start, f"the state in which a slip lands on {what}")
    return np.append(start, loads), [first, *found]


def refined(solving, branch, what):
    """The same Branch with twice the states."""
    half = np.linspace(0.0, 1.0, 2 * branch.intervals + 1)
    v = branch.states(branch.load_at(half), solving.moving)
    active = np.repeat(branch.active, 2, axis=0)[:-1]
    return _settled(solving, replace(branch, v=v, active=active), range(1, 2 * branch.intervals, 2), what)


def _settled(solving, branch, places, what):
    """The same Branch, its states at these places solved for."""
    v, active = branch.v.copy(), branch.active.copy()
    for i in places:
        v[i], active[i] = solving.at(v[i], active[i], branch.loads[i], f"a state of {what}")
        _refuse_far(solving, v[i], branch.v[i], LIMITS.surprise, f"a state of {what}")
    return replace(branch, v=v, active=active)


def _refuse_far(solving, v, guess, most, what):
    if np.abs(v - guess).max() > most * solving.problem.unit:
        raise NotFollowed(f"{what} lies on another branch", nearer=True)


def _nearly(solving, fold, change, what):
    """A load close to that of the fold that `fold` becomes, but below it."""
    chord = fold.along / (fold.along @ fold.along)
    with solving.apart(), solving.within(LIMITS.rough * solving.problem.unit):
        return solving.on_arc(fold.v + change, fold.active, fold.load, chord, what)[0]


def _extrapolated(changes, i):
    """The change of state i from those of the states before it."""
    near = range(max(0, len(changes) - LIMITS.near), len(changes))
    return _mixed(lagrange(near, i), [changes[j] for j in near])


def _stacked(found):
    return tuple(np.array([one[part] for one in found]) for part in (0, 1))


def _evenly(fold, loads, found, n):
    """The Branch of n intervals to a fold, from states (v, active) at loads that are not quite those of even t."""
    (v, active), even = _stacked(found), np.linspace(0.0, 1.0, n + 1)
    t = place(loads[0], fold.load, loads)
    between = [weights_near(t, at) for at in even[1:-1]]
    v = np.array([v[0], *(_mixed(weights, v[near]) for near, weights in between), v[-1]])
    return Branch(loads[0], fold.load, v, active[np.searchsorted(t, even - 1e-9)], fold)
