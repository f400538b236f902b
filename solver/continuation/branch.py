"""Following a branch: in steps of the load while that is easy, in steps of arc length near its end, which is located.

At a fold the state moves without bound per unit of load, but smoothly per unit of arc length. So the arc length
<chord, v> is prescribed and the load solved for; the chord picks the unknown that moves most. A fold is the maximum of
the load over the arc. Where a mode starts to grow before (as NP1 has no potential, an oscillation may), the branch ends
there. Source: Keller 1977, Numerical solution of bifurcation and nonlinear eigenvalue problems; one unknown as the arc:
Rheinboldt & Burkardt 1983, doi:10.1145/357456.357460.
"""

from dataclasses import dataclass, replace

import numpy as np

from .anderson import dot
from .fold import Fold, fold_near
from .interpolation import combine, lagrange
from .state import MOVED, LimitPoint, State


@dataclass(frozen=True)
class Limits:
    """Of the continuation; a "unit" is the problem's `unit`, distances of states are the largest of any unknown."""

    order: int = 3  # of the polynomial that extrapolates in the load; with 2 to 6 evaluations change by 3 %
    # units from the extrapolation; farther off likewise, as a short slip may lie in between; and the arc's first step
    short: float = 0.1
    long: float = 0.3  # units, longest step
    shortest: float = 1e-4  # units, shortest step; where even that fails, the branch is lost
    growth: float = 3.0  # times the step before, at most: extrapolation over more means nothing; and times the step, a
    # point farther off lies on another branch
    points: int = 400  # of one increment on the arc, at most
    # of the last step: a point so much farther on tells whether the load falls there; a state at the load asked for may
    # lie beyond the newest point by that
    beyond: float = 0.1
    sharpness: float = 1e-9  # units, error of the load at the end of a branch
    # of the load per arc, below which a state is followed by arc length and a fold is looked for a step ahead: the arc
    # must be finer than the hidden part of the branch, which is about a tenth of a unit where that matters
    steep: float = 0.3
    folds: int = 4  # searches for a fold from guesses ever nearer to it; one does, but for soft layers
    start: float = 0.05  # units from the end of the branch, where the motion starts; from farther, soft layers
    # reach other rests


LIMITS = Limits()


def continue_branch(corrector, judge, state, target):
    """The State at load `target`, nm, on the branch of `state`, or the LimitPoint that comes before it."""
    found = _by_load(corrector, judge, state, target) or _Arc(corrector, judge, state, target).followed()
    settled = np.zeros(state.active.size, bool)
    while isinstance(found, LimitPoint) and found.located:
        # if nodes have crossed the edge of the window on the way here, the end is sought again with these let in or out
        active = corrector.problem.active(found.v, found.load, found.active, settled)
        if active is found.active:
            break
        settled |= active != found.active
        state = _with_nodes(corrector, state, active)
        if not state:
            return replace(found, kind="lost")  # not the end of a branch of the nodes that interact there
        found = _Arc(corrector, judge, state, target).followed()
    return found


def _with_nodes(corrector, state, active):
    """The State, and those before it, solved again with these nodes active; None if that fails."""
    past = []
    corrector.begin(state)  # not with the inverse at hand: the tangent at an end is singular
    for load, v in state.past[:3]:
        v = v.copy()
        if not corrector.solve(v, active, load, state.secants):
            break
        past.append((load, v))
    return past and State(state.load, past[0][1], active, past, state.secants, corrector.sharp, state.mode)


def on_branch(corrector, state, target, v, active, mode):
    """The State v (size,) at load `target`, nm, that follows `state` on its branch."""
    older = [p for p in state.past if p[0] != target]
    past = [(target, v), *older[: LIMITS.order + 1]]
    return State(target, v, active, past, state.secants, corrector.sharp, mode, residual=corrector.worst)


def _by_load(corrector, judge, state, target):
    """The state at `target` by extrapolation in the load and Anderson steps, or None if arc length is called for."""
    farthest = MOVED * corrector.problem.unit  # increments that lead farther are followed by arc length
    past = state.past[: LIMITS.order + 1]
    v = combine(lagrange([load for load, _ in past], target), [u for _, u in past])
    if np.abs(v - state.v).max() > farthest:
        return None
    guess = v.copy()
    active = corrector.settle(v, corrector.problem.active(v, target, state.active), target, state.secants)
    if active is None or np.abs(v - state.v).max() > farthest:
        return None
    if len(past) > 1 and np.abs(v - guess).max() > LIMITS.short * corrector.problem.unit:
        return None
    if target - state.load < LIMITS.steep * np.abs(v - state.v).max():
        return None
    mode = judge.accept(corrector.problem, v, active, state.mode, corrector.inverse)
    return on_branch(corrector, state, target, v, active, mode) if mode.rests else None


class Stride:
    """Step control on the arc, in units of the problem: answers how long the next step is, and whether to go on."""

    def __init__(self, unit):
        self.length, self._unit = LIMITS.short * unit, unit

    def next(self, last):
        """The length of the next step after one of length `last`, nm."""
        self.length = min(self.length, LIMITS.growth * last)
        return self.length

    def accepts(self, before, v):
        """Whether a point v may follow the one `before`; a longer step comes next, or a shorter one in its place."""
        near = v is not None and np.abs(v - before).max() <= LIMITS.growth * self.length
        self.length = min(2.0 * self.length, LIMITS.long * self._unit) if near else 0.5 * self.length
        return near

    @property
    def too_short(self):
        return self.length < LIMITS.shortest * self._unit


class _Arc:
    """One increment followed by arc length."""

    def __init__(self, corrector, judge, state, target):
        self.corrector, self.problem, self.judge = corrector, corrector.problem, judge
        self.state, self.target, self.unit = state, target, corrector.problem.unit
        self.mode = state.mode

    def followed(self):
        """The State at the target, or the LimitPoint before it."""
        points, stride = self._two_points(), Stride(self.unit)
        for _ in range(LIMITS.points):
            length = np.abs(points[0][1] - points[1][1]).max()
            if length == 0.0 or stride.too_short:  # a node at the edge of the window, or no interaction yet
                return self._lost()
            chord, here = _on_chord(points)
            ahead = here[0][0] + (here[0][0] - here[1][0]) * stride.next(length) / length
            found = self._point_at(chord, ahead, here)
            if not stride.accepts(here[0][2], found and found[1]):
                continue
            points = [found, *points[:3]]
            if found[0] < points[1][0]:
                return self._fold(points)
            if found[0] < self.target and (end := self._ended(points)):
                return end
            if end := self._fold_ahead(points):
                return end
            if found[0] >= self.target:
                return self._arrived(points)
        return self._lost()

    def _fold_ahead(self, points):
        """The LimitPoint, or the State at `target`, by a fold a step ahead; None if there is none.

        Near the onset of stick-slip the load falls over less than a step: two points show no fold between them.
        """
        if len(points) < 3:
            return None
        (load, v), (load1, v1), (load2, v2) = points[:3]
        way, before = np.abs(v - v1).max(), np.abs(v1 - v2).max()
        slope, last = (load - load1) / way, (load1 - load2) / max(before, 1e-300)
        if not slope < min(LIMITS.steep, last):
            return None
        bend = (last - slope) / (0.5 * (way + before))
        top = max(slope / bend - 0.5 * way, 0.0)  # units of arc to where the slope is zero
        if top > LIMITS.long * self.unit or load + 0.5 * bend * top**2 > self.target:
            return None
        guess = Fold.of(load + 0.5 * bend * top**2, v + (v - v1) * (top / way), self.state.active, v - v1)
        fold = fold_near(self.problem, guess)
        if fold is None or not load <= fold.load:
            return None
        ahead = (fold.v - v) @ (v - v1)
        if ahead < 0.0 or np.abs(fold.v - v).max() > LIMITS.long * self.unit:
            return None
        return self._at_fold(fold, points)

    def _at_fold(self, fold, points):
        """The LimitPoint at a fold, or the State at `target` if that is below it; points: before it, newest first."""
        if fold.load >= self.target:
            return self._arrived([(fold.load, fold.v), *points], fold.load)
        return LimitPoint(fold.load, fold.v, self.state.active, fold.phi * (LIMITS.start * self.unit), "fold")

    def _point_at(self, chord, arc, here):
        """The point (load, v) with <chord, v> = arc, or None; extrapolated from `here`, points (arc, load, v)."""
        arcs = [point[0] for point in here]
        if np.abs(np.diff(sorted(arcs))).min() <= 1e-12 * max(map(abs, arcs)):  # two points are one, to round-off
            return None
        weights = lagrange(arcs, arc)
        load = sum(weight * point[1] for weight, point in zip(weights, here, strict=True))
        v = combine(weights, [point[2] for point in here])
        load = self.corrector.solve_on_arc(v, self.state.active, load, self.state.secants, chord, arc)
        return None if load is None else (load, v)

    def _two_points(self):
        """The last points [(load, v)], newest first, at least two: the second may be a step back along the tangent."""
        state = self.state
        if len(state.past) >= 2:
            return state.past[:3]
        along = self.corrector.direction(state)
        back = LIMITS.short * self.unit / max(np.abs(along).max(), 1.0)
        return [state.past[0], (state.load - back, state.v - back * along)]

    def _lost(self):
        """The LimitPoint "lost": the motion shall start from the state at hand, under the load asked for."""
        state = self.state
        return LimitPoint(max(self.target, state.load), state.v, state.active, np.zeros_like(state.v), "lost")

    def _arrived(self, points, fold=None):
        """The State at `target`, between the last two points: solved at fixed load once the arc has come near enough.

        fold: its load, if the newest point is one. Else, if the state does not rest, a fold may lie between the points
        (or just beyond), and is looked for.
        """
        state, target = self.state, self.target
        for _ in range(6):
            (load1, v1), (load0, v0) = points[:2]
            part = (target - load0) / (load1 - load0)
            if load1 == fold:  # there the load goes with the square of the distance
                part = 1.0 - np.sqrt(1.0 - part)
            v = v0 + part * (v1 - v0)
            active = self.corrector.settle(v, state.active, target, state.secants)
            chord, here = _on_chord(points)
            # beyond the newest point it may be a state past the fold, on the branch that does not rest
            if active is not None and dot(chord, v) <= here[0][0] + LIMITS.beyond * (here[0][0] - here[1][0]):
                break
            found = self._point_at(chord, here[1][0] + part * (here[0][0] - here[1][0]), here)
            if found is None:
                return self._lost()
            points = [points[0], found, *points[1:3]] if found[0] < target else [found, *points[1:3]]
        else:
            return self._lost()
        return self._judged(points, v, active, fold)

    def _judged(self, points, v, active, fold):
        """The State v at the target, or the end of the branch before it; other arguments as of `_arrived`."""
        state, target = self.state, self.target
        mode = self.judge.rightmost(self.problem, v, active, state.mode, self.corrector.inverse)
        if not mode.rests:
            return self._end(points, (target, v), mode, fold)
        found = on_branch(self.corrector, state, target, v, active, mode)
        return replace(found, past=[(target, v), *[p for p in points if p[0] < target][:3]])

    def _ended(self, points):
        """The LimitPoint between the last two points, if the newest does not rest; else None."""
        v, active = points[0][1], self.state.active
        self.mode = self.judge.accept(self.problem, v, active, self.mode, self.corrector.inverse)
        return None if self.mode.rests else self._end(points, points[0], self.mode)

    def _end(self, points, after, mode, fold=None):
        """The end before `after`, (load, v), whose `mode` grows: a fold if there is one, or what `_located` finds."""
        before = [p for p in points if p[0] < after[0] and p[1] is not after[1]]
        if fold is None and mode.kind != "flutter" and not mode.hidden and before:
            ahead = self._just_beyond(points)
            if ahead is not None and ahead[0] < points[0][0]:
                return self._fold([ahead, *points])
            # the branch may have turned round twice as far as the arc can tell: a real mode grows beyond a fold
            if found := self._fold_between(before[0], after):
                return self._at_fold(found, before)
        return self._located([p for p in points[1:] if p[0] >= self.state.load], after, mode)

    def _fold_between(self, before, after):
        """The Fold between two points (load, v) of a branch, the first of them stable and the second not; or None."""
        way = after[1] - before[1]
        for part in (0.5, 1.0, 0.0):
            load, v = (a + part * (b - a) for a, b in zip(before, after, strict=True))
            fold = fold_near(self.problem, Fold.of(load, v, self.state.active, way))
            if fold is not None and fold.load >= before[0] and 0.0 <= (fold.v - before[1]) @ way <= way @ way:
                return fold
        return None

    def _just_beyond(self, points):
        """The point (load, v) a little farther on the arc than the newest, or None. Past a fold, its load is lower."""
        chord, here = _on_chord(points)
        return self._point_at(chord, here[0][0] + LIMITS.beyond * (here[0][0] - here[1][0]), here)

    def _located(self, older, after, mode):
        """The LimitPoint before `after`, (load, v), that does not rest: where the growth of its mode is zero.

        older: points before it, newest first; not all of them have been judged.
        """
        state, inverse, high, last = self.state, self.corrector.inverse, after, None
        hidden = mode.hidden  # where its growth is zero, a mode no longer shows it
        for low in older:
            found = self.judge.rightmost(self.problem, low[1], state.active, mode, inverse)
            if found.growth < 0.0:
                break
            high, mode = low, found
        else:
            return replace(self._lost(), load=after[0])
        ends, growth = [low, high], [found.growth, mode.growth]  # of the point that rests, and the one that does not
        for _ in range(60):  # regula falsi
            low, high = ends
            if high[0] - low[0] <= LIMITS.sharpness * self.unit or growth[0] == growth[1]:
                break
            part = min(max(growth[0] / (growth[0] - growth[1]), 1e-3), 1.0 - 1e-3)
            load, v = low[0] + part * (high[0] - low[0]), low[1] + part * (high[1] - low[1])
            if not self.corrector.solve(v, state.active, load, state.secants):
                break
            found = self.judge.rightmost(self.problem, v, state.active, mode, inverse)
            side = int(found.growth >= 0.0)
            ends[side], growth[side], mode = (load, v), found.growth, found if side else mode
            if last == side:
                growth[1 - side] *= 0.5  # Illinois: an end that stays twice counts half
            last = side
        away = mode.x * np.copysign(1.0, dot(mode.x, after[1] - older[0][1]))  # the way the state moves
        away *= LIMITS.start * self.unit / max(np.abs(away).max(), 1e-300)
        return LimitPoint(*ends[1], state.active, away, mode.kind, hidden)

    def _fold(self, points):
        """The LimitPoint at the maximum of the load between the points; the State at `target` if that is below."""
        chord, here = _on_chord(points)
        active = self.state.active
        for _ in range(LIMITS.folds):
            arc, guess = _top(here, active)
            fold = fold_near(self.problem, guess)
            if fold is not None and here[-1][0] < dot(chord, fold.v) < here[0][0]:
                break
            found = self._point_at(chord, arc, here)  # nearer to the top
            if found is None:
                return self._lost()
            here = _around_highest([*here, (arc, *found)])
        else:
            return self._lost()
        return self._at_fold(fold, [p for p in points[1:] if dot(chord, p[1]) < dot(chord, fold.v)])


def _on_chord(points):
    """(chord, [(arc, load, v)]) of the last three points [(load, v)], newest first: arc = <chord, v>.

    The chord is the direction of the unknown that moved most in the last step. That of all unknowns together would not
    do where one node jumps: far more of them move with the load, and so back beyond the fold.
    """
    step = points[0][1] - points[1][1]
    chord, most = np.zeros_like(step), int(np.abs(step).argmax())
    chord[most] = np.sign(step[most])
    return chord, [(dot(chord, v), load, v) for load, v in points[:3]]


def _around_highest(points):
    """The highest of points (arc, load, v) with its neighbours in arc, newest (the largest arc) first."""
    points = sorted(points, key=lambda p: p[0])
    highest = max(range(1, len(points) - 1), key=lambda i: points[i][1])
    return points[highest - 1 : highest + 2][::-1]


def _top(points, active):
    """(arc, Fold) at the maximum of the parabola through three points (arc, load, v), newest first: a guess."""
    arcs = np.array([p[0] for p in points])
    bend, slope, _ = np.polyfit(arcs - arcs[1], [p[1] for p in points], 2)
    arc = float(np.clip(arcs[1] - 0.5 * slope / bend, arcs[2], arcs[0])) if bend < 0.0 else float(arcs[1])
    v, ahead = (combine(lagrange(arcs, at), [p[2] for p in points]) for at in (arc, arc + 1e-3 * (arcs[0] - arcs[2])))
    load = sum(weight * p[1] for weight, p in zip(lagrange(arcs, arc), points, strict=True))
    return arc, Fold.of(load, v, active, ahead - v)
