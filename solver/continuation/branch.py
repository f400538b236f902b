"""Continuing a branch of equilibria: by steps of the load where that is easy, by steps of arc length near its end.

At a fold the state moves without bound per unit of load, but smoothly per unit of arc length. So the arc length
<chord, v> is prescribed and the load solved for; the chord is the unknown that moves most. A branch ends at a fold, the
maximum of the load along it, or before that where a mode begins to grow: NP1 has no potential, so an oscillation may.
Source: Keller 1977, Numerical solution of bifurcation and nonlinear eigenvalue problems; one unknown as the arc:
Rheinboldt & Burkardt 1983, doi:10.1145/357456.357460.
"""

from dataclasses import replace

import numpy as np

from .arc import GROWTH, LONG, NEAREST, SHORT, on_chord, point_at
from .fold import FoldOptions, fold_near
from .onset import mixed, onset
from .state import MOVED, PAST, TINY, End, Point, State
from .trace import lagrange
from .vectors import dot

# `tests/bench/constants.py --only SEARCH` shows what these save. With more products, searches that fail on very soft
# layers (E = 1) take longer. With rough null vectors of thousands of soft nodes, steps go to and fro
SEARCH = FoldOptions(accuracy=3e-3, products=100, sharper=1e-4)

# Of the last step, to a fold from its guess. Folds lie within one step of it; searches that went farther found none
REACH = 2.0

# Load per arc below which a state is continued by arc length and a fold is looked for a step ahead. At the onset of
# stick-slip the branch turns back within a tenth of a unit, and larger steps pass that.
STEEP = 0.3


def continue_branch(corrector, judge, state, target) -> State | End:
    """The State at load `target`, nm, on the branch of `state`, or the End that comes before it."""
    reached = _by_load(corrector, judge, state, target)
    return reached or _Arc(corrector, judge, state, target).to_target()


def _by_load(corrector, judge, state, target):
    """The State at `target` by extrapolation in the load and Anderson steps, or None if arc length is called for."""
    unit, past = corrector.problem.unit, state.past
    guess = mixed(lagrange([load for load, _ in past], target), past).v
    if np.abs(guess - state.v).max() > MOVED * unit:
        return None
    solution = corrector.solve(guess, target, state.secants)
    if solution is None:
        return None
    way = np.abs(solution.v - state.v).max()
    if way > MOVED * unit or target - state.load < STEEP * way:
        return None
    # without a prediction: nodes in contact move about as far as the load
    expected = SHORT * unit if len(past) > 1 else SHORT * unit + (target - state.load)
    if np.abs(solution.v - guess).max() > expected:
        return None
    mode = judge.accept(corrector.problem, solution.v, state.mode)
    return _on_branch(corrector, state, solution, mode, state.past) if mode.rests else None


def _on_branch(corrector, state, solution, mode, past):
    """The State of a Solution that follows `state` on its branch, after the points `past`, newest first."""
    v, load, residual = solution
    past = [Point(load, v), *[p for p in past if p[0] != load][: PAST - 1]]
    kept = {"residual": residual, "undecided": state.undecided}
    return State(load, v, past, state.secants, corrector.sharp, mode, **kept)


class _Arc:
    """One increment continued by arc length."""

    def __init__(self, corrector, judge, state, target):
        self.corrector, self.problem, self.judge = corrector, corrector.problem, judge
        self.state, self.target, self.unit = state, target, corrector.problem.unit
        self.mode = state.mode

    def to_target(self):
        """The State at the target, or the End before it."""
        points, unit = self._two_points(), self.unit
        step = SHORT * unit
        if fold := self._fold_ahead(points):  # the first step might pass it
            return self._at_fold(fold, points)
        for _ in range(400):  # the longest increment of the slider box takes some 60 points
            last = np.abs(points[0].v - points[1].v).max()
            if last == 0.0 or step < 1e-4 * unit:
                return self._lost()
            chord, arcs = on_chord(points)
            step = min(step, GROWTH * last)
            point = self._point_at(chord, arcs[0] + (arcs[0] - arcs[1]) * step / last, points)
            if point is None or not np.abs(point.v - points[0].v).max() <= GROWTH * step:
                step *= 0.5
                continue
            if reached := self._classify([point, *points[:3]]):
                return reached
            if point.load < points[0].load:  # the fold between was not found: approach it by a shorter step
                step *= 0.5
            else:
                step, points = min(2.0 * step, LONG * unit), [point, *points[:3]]
        return self._lost()

    def _classify(self, points):
        """What the newest Point shows: the State at the target, the End before it, or None: the branch goes on."""
        after, before = points[:2]
        if after.load < before.load:
            return self._at_fold(self._fold_between(points), points)
        if after.load < self.target:
            self.mode = self.judge.accept(self.problem, after.v, self.mode)
            if not self.mode.rests:
                return self._end(points, after, self.mode)
        if fold := self._fold_ahead(points):
            return self._at_fold(fold, points)
        return self._at_target(points) if after.load >= self.target else None

    def _two_points(self):
        """The last Points, newest first, at least two: the second may be a step back along the tangent."""
        state = self.state
        if len(state.past) >= 2:
            return [Point(*p) for p in state.past[:3]]
        along = self.corrector.direction(state)
        back = SHORT * self.unit / max(np.abs(along).max(), 1.0)
        return [Point(*state.past[0]), Point(state.load - back, state.v - back * along)]

    def _point_at(self, chord, arc, points):
        return point_at(self.corrector, self.state.secants, chord, arc, points)

    def _lost(self):
        """The End "lost": the motion shall start from the state at hand, under the load asked for."""
        state = self.state
        return End(max(self.target, state.load), state.v, np.zeros_like(state.v), "lost")

    # the target

    def _at_target(self, points, fold=None):
        """The State at `target`, between the last two points: solved at fixed load once a point is near enough.

        fold: the load of the newest point, if that is a fold. Near a fold, two states have almost the same load. Only
        the one before the fold counts; from a linear guess, round-off decides to which of both the solution comes.
        """
        target, top = self.target, points[0].v
        for _ in range(6):  # more points on the arc change no run
            last, before = points[:2]
            part = (target - before.load) / (last.load - before.load)
            if last.load == fold:  # the distance from a fold grows as the root of that in load
                part = 1.0 - (1.0 - part) ** 0.5
            solution = self.corrector.solve(before.v + part * (last.v - before.v), target, self.state.secants)
            chord, arcs = on_chord(points)
            # more than a tenth of the step beyond the newest point it may be past a fold, on the unstable branch
            furthest = arcs[0] + 0.1 * (arcs[0] - arcs[1]) if fold is None else dot(chord, top)
            if solution and dot(chord, solution.v) <= furthest:
                break
            point = self._point_at(chord, arcs[1] + part * (arcs[0] - arcs[1]), points)
            if point is None:
                return self._lost()
            points = [points[0], point, *points[1:3]] if point.load < target else [point, *points[1:3]]
        else:
            return self._lost()
        mode = self.judge.rightmost(self.problem, solution.v, self.state.mode)
        if not mode.rests:
            return self._end(points, Point(target, solution.v), mode, fold)
        below = [p for p in points if p.load < target and np.abs(p.v - solution.v).max() > NEAREST * self.unit]
        return _on_branch(self.corrector, self.state, solution, mode, below)

    # ends

    def _at_fold(self, fold, points):
        """The End at a fold, or the State at `target` if that is below it; None without a fold.

        points: newest first; those beyond the fold do not count.
        """
        if fold is None or fold.load < self.target:
            return fold
        chord, _ = on_chord(points)
        before = [p for p in points if dot(chord, p.v) < dot(chord, fold.v)]
        return self._at_target([Point(fold.load, fold.v), *before], fold.load)

    def _end(self, points, after, mode, fold=None):
        """The end before the Point `after`, whose `mode` grows: a fold if there is one, else where it sets in."""
        older = [p for p in points if p.load < after.load and p.v is not after.v]
        # a real mode grows beyond a fold, and the arc may have passed that to a point of higher load
        if fold is None and older and mode.kind != "flutter":
            passed = self._fold_between([after, *older])
            if passed is not None:
                return self._at_fold(passed, [after, *older])
        older = [p for p in points[1:] if p.load >= self.state.load]
        end = onset(self.corrector, self.judge, self.state, older, after, mode)
        return end or self._lost()._replace(load=after.load)

    def _fold_between(self, points):
        """The fold between the last two or three of the Points, newest first; None if there is none."""
        last, before = points[:2]
        chord, arcs = on_chord(points)
        guesses = [_top(arcs, points)] if len(arcs) == 3 else []
        for load, v in [*guesses, mixed((0.5, 0.5), (last, before))]:
            fold = self._fold_near(load, v, last.v - before.v)
            if fold is None or not arcs[-1] < dot(chord, fold.v) < arcs[0]:
                continue
            if fold.load >= before.load - self.problem.tolerance:  # a point at the fold has an error of its own
                return fold
        return None

    def _fold_near(self, load, v, step):
        """The fold next to a guess (load, v), not farther than REACH times the last step, or None."""
        return fold_near(
            self.problem, End(load, v, step), replace(SEARCH, reach=REACH * np.abs(step).max() / self.unit)
        )

    def _fold_ahead(self, points):
        """The fold less than a step ahead of the newest Point, or None.

        Near the onset of stick-slip the load falls over less than a step: no two points show the fold between them.
        """
        if len(points) < 3:
            return None
        last, before, first = points[:3]
        way, way_before = np.abs(last.v - before.v).max(), max(np.abs(before.v - first.v).max(), TINY)
        slope, slope_before = (last.load - before.load) / way, (before.load - first.load) / way_before
        if not slope < min(STEEP, slope_before):
            return None
        bend = (slope_before - slope) / (0.5 * (way + way_before))
        top = max(slope / bend - 0.5 * way, 0.0)  # nm of arc to where the slope is zero
        longest = LONG * self.unit
        load, step = last.load + 0.5 * bend * top**2, last.v - before.v
        if top > longest or load > self.target:
            return None
        fold = self._fold_near(load, last.v + step * (top / way), step)
        if fold is None or fold.load < last.load or (fold.v - last.v) @ step < 0.0:
            return None
        return fold if np.abs(fold.v - last.v).max() <= longest else None


def _top(arcs, points):
    """(load, v) at the maximum of the parabola through three Points at these arcs, newest first."""
    bend, slope, _ = np.polyfit(np.subtract(arcs, arcs[1]), [p.load for p in points[:3]], 2)
    top = float(np.clip(arcs[1] - 0.5 * slope / bend, arcs[2], arcs[0])) if bend < 0.0 else arcs[1]
    return mixed(lagrange(arcs, top), points[:3])
