"""Following a branch: by its load while that is easy, by its arc length near its end, to the place where it ends.

Near its end the state moves without bound per unit of load, but smoothly per unit of arc length <chord, v>, the chord
picking the unknown that moves most. So the arc is prescribed and the load solved for: a fold is the maximum of the load
over the arc. Where a mode starts to grow before (NP1 has no potential: oscillations can), the branch ends there.
Source: Keller 1977, Numerical solution of bifurcation and nonlinear eigenvalue problems; the one unknown: Rheinboldt &
Burkardt 1983, doi:10.1145/357456.357460.
"""

from dataclasses import dataclass, replace

import numpy as np

from .anderson import dot
from .interpolation import combine, lagrange
from .state import LimitPoint, State


@dataclass(frozen=True)
class Limits:
    """Of the continuation; lengths in units of the problem's `unit`, measured in the largest change of an unknown.

    order: of the extrapolation in the load. steps: Anderson steps of one increment, `first_steps` where there is but
    one state to go on from, `arc_steps` of one point by arc length. farthest, surprise: a change, and a distance from
    the extrapolation, from which on an increment is followed by arc length. short, long, shortest: first, longest and
    least step along the arc. growth: of one step over the one before; farther, the extrapolation means nothing.
    astray: a point so many steps off lies on another branch. beyond: part of a step, to see on which side of a fold a
    point lies. sharpness: of the load at a fold, or that at which another mode starts to grow. approaches: of the arc
    towards the load asked for. start: of the motion, from the end of the branch; from farther off, soft layers reach
    other rests.
    """

    order: int = 3
    steps: int = 60
    first_steps: int = 150
    arc_steps: int = 40
    farthest: float = 0.5
    surprise: float = 0.1
    short: float = 0.1
    long: float = 0.3
    start: float = 0.05
    shortest: float = 1e-4
    growth: float = 3.0
    astray: float = 3.0
    points: int = 400
    beyond: float = 0.1
    sharpness: float = 1e-9
    approaches: int = 6


LIMITS = Limits()


def continue_branch(corrector, watch, state, target):
    """The State at load `target` on the branch of `state`, or the LimitPoint that comes before it."""
    found = _by_load(corrector, watch, state, target) or _Arc(corrector, watch, state, target).followed()
    settled = np.zeros(state.active.size, bool)
    while isinstance(found, LimitPoint) and found.located:
        # nodes that crossed the edge of the window on the way belong to the branch that ends: it ends elsewhere
        active = corrector.problem.admitted(found.v, found.active, settled)
        if active is found.active:
            break
        settled |= active != found.active
        state = _with_nodes(corrector, state, active)
        again = state and _Arc(corrector, watch, state, target).followed()
        if not again or (isinstance(again, LimitPoint) and not again.located):
            break
        found = again
    return found


def _with_nodes(corrector, state, active):
    """The State, and those before it, had these nodes been within the window; None if it is none then."""
    past = []
    for load, v in state.past[:3]:
        v = v.copy()
        if not corrector.solve(v, active, load, state.secants, LIMITS.first_steps):
            break
        past.append((load, v))
    return past and State(state.load, past[0][1], active, past, state.secants, corrector.sharp, state.modes)


def on_branch(corrector, state, target, v, active, modes=None):
    """The State with unknowns v at load `target`, on the branch of `state`."""
    older = [p for p in state.past if p[0] != target]
    past = [(target, v), *older[: LIMITS.order + 1]]
    return State(target, v, active, past, state.secants, corrector.sharp, modes or state.modes)


def _by_load(corrector, watch, state, target):
    """The state at `target` by extrapolation in the load and Anderson steps, or None if that is not safe."""
    farthest = LIMITS.farthest * corrector.problem.unit
    past = state.past[: LIMITS.order + 1]
    v = combine(lagrange([load for load, _ in past], target), [u for _, u in past])
    if np.abs(v - state.v).max() > farthest:
        return None
    most = LIMITS.steps if len(past) > 1 else LIMITS.first_steps
    guess = v.copy()
    active = corrector.settle(v, corrector.problem.admitted(v, state.active), target, state.secants, most)
    if active is None or np.abs(v - state.v).max() > farthest:
        return None
    if len(past) > 1 and np.abs(v - guess).max() > LIMITS.surprise * corrector.problem.unit:
        return None  # a short slip may lie in between
    stability = watch.look(corrector.problem, v, active, target, state, corrector.inverse)
    return on_branch(corrector, state, target, v, active, stability.modes) if stability.rests else None


class _Arc:
    """One increment followed by arc length."""

    def __init__(self, corrector, watch, state, target):
        self.corrector, self.problem, self.watch = corrector, corrector.problem, watch
        self.state, self.target, self.unit = state, target, corrector.problem.unit
        self.modes = state.modes

    def followed(self):
        """The State at the target, or the LimitPoint before it."""
        points = self._two_points()
        step = LIMITS.short * self.unit
        for _ in range(LIMITS.points):
            length = np.abs(points[0][1] - points[1][1]).max()
            if length == 0.0:  # an edge of the window in the way, or nothing acts yet
                return self._lost()
            chord = _chord(points[0][1] - points[1][1])
            here = [(dot(chord, v), load, v) for load, v in points[:3]]
            step = min(step, LIMITS.growth * length)
            ahead = here[0][0] + (here[0][0] - here[1][0]) * step / length
            found = self._at(chord, ahead, here)
            if found is None or np.abs(found[1] - here[0][2]).max() > LIMITS.astray * step:
                step *= 0.5
                if step < LIMITS.shortest * self.unit:
                    return self._lost()
                continue
            points = [found, *points[:3]]
            if found[0] < points[1][0]:
                return self._fold(points)
            if found[0] >= self.target:
                return self._arrived(points)
            ended = self._ended(points, chord)
            if ended:
                return ended
            step = min(2.0 * step, LIMITS.long * self.unit)
        return self._lost()

    def _at(self, chord, arc, here):
        """The point (load, v) of the branch with <chord, v> = arc, or None; predicted through here [(arc, load, v)]."""
        arcs = [point[0] for point in here]
        if np.abs(np.diff(sorted(arcs))).min() <= 1e-12 * max(map(abs, arcs)):  # states that are one, to round-off
            return None
        weights = lagrange(arcs, arc)
        load = sum(weight * point[1] for weight, point in zip(weights, here, strict=True))
        v = combine(weights, [point[2] for point in here])
        load = self.corrector.solve_on_arc(v, self.state.active, load, self.state.secants, LIMITS.arc_steps, chord, arc)
        return None if load is None else (load, v)

    def _two_points(self):
        """The last states [(load, v)], newest first; a second one, on the tangent to the branch, if there is none."""
        state = self.state
        if len(state.past) >= 2:
            return state.past[:3]
        along = self.corrector.direction(state)
        back = LIMITS.short * self.unit / max(np.abs(along).max(), 1.0)
        return [state.past[0], (state.load - back, state.v - back * along)]

    def _lost(self):
        """No branch to follow: the motion decides, from the state at hand, under the load asked for."""
        state = self.state
        return LimitPoint(max(self.target, state.load), state.v, state.active, np.zeros_like(state.v), "lost")

    def _arrived(self, points, again=True):
        """The state at `target`, between the last two points: along the arc until it is near, then at fixed load.

        again: the newest point may lie beyond a fold.
        """
        state, target = self.state, self.target
        for _ in range(LIMITS.approaches):
            (load1, v1), (load0, v0) = points[:2]
            part = (target - load0) / (load1 - load0)
            v = v0 + part * (v1 - v0)
            active = self.corrector.settle(v, state.active, target, state.secants, LIMITS.arc_steps)
            if active is not None:
                break
            chord = _chord(v1 - v0)
            here = [(dot(chord, u), load, u) for load, u in points[:3]]
            found = self._at(chord, here[1][0] + part * (here[0][0] - here[1][0]), here)
            if found is None:
                return self._lost()
            points = [points[0], found, *points[1:3]] if found[0] < target else [found, *points[1:3]]
        else:
            return self._lost()
        stability = self.watch.sure(self.problem, v, active, target, state.modes, None, self.corrector.inverse)
        if not stability.rests:
            ahead = self._just_beyond(points) if again and stability.kind != "flutter" else None
            if ahead is not None and ahead[0] < points[0][0]:
                return self._fold([ahead, *points])
            return self._located(points[1], (target, v), stability)
        found = on_branch(self.corrector, state, target, v, active, stability.modes)
        return replace(found, past=[(target, v), *[p for p in points if p[0] < target][:3]])

    def _ended(self, points, chord):
        """The LimitPoint between the last two points if the newest does not rest, else None."""
        load, v = points[0]
        modes = replace(self.state, modes=self.modes)
        stability = self.watch.look(self.problem, v, self.state.active, load, modes, self.corrector.inverse)
        self.modes = stability.modes
        if stability.rests:
            return None
        if stability.kind == "flutter":
            return self._located(points[1], points[0], stability)
        ahead = self._just_beyond(points)
        if ahead is None:
            return None
        if ahead[0] < points[0][0]:
            return self._fold([ahead, *points])
        return self._located(points[1], points[0], stability)

    def _just_beyond(self, points):
        """The point (load, v) a little farther along the arc than the newest, or None; the lower past a fold."""
        chord = _chord(points[0][1] - points[1][1])
        here = [(dot(chord, v), load, v) for load, v in points[:3]]
        return self._at(chord, here[0][0] + LIMITS.beyond * (here[0][0] - here[1][0]), here)

    def _located(self, before, after, stability):
        """The LimitPoint between a state that rests and one that does not, [(load, v)], by the growth of its mode."""
        state, watch = self.state, self.watch
        modes, secants = stability.modes, state.secants
        load, v = before
        inverse = self.corrector.inverse
        low = (load, v, watch.sure(self.problem, v, state.active, load, modes, secants, inverse).growth)
        if not low[2] < 0.0:
            return replace(self._lost(), load=after[0])
        high, rise, fall, last = (*after, stability), stability.growth, low[2], 0
        for _ in range(60):
            if high[0] - low[0] <= LIMITS.sharpness * self.unit or rise - fall == 0.0:
                break
            part = min(max(-fall / (rise - fall), 1e-3), 1.0 - 1e-3)
            load, v = low[0] + part * (high[0] - low[0]), low[1] + part * (high[1] - low[1])
            if not self.corrector.solve(v, state.active, load, secants, LIMITS.first_steps):
                break
            found = watch.sure(self.problem, v, state.active, load, modes, secants, inverse)
            modes = found.modes
            side = -1 if found.growth < 0.0 else 1
            if side < 0:
                low, fall = (load, v, found.growth), found.growth
                rise *= 0.5 if last == side else 1.0  # Illinois: an end that stays twice counts half
            else:
                high, rise = (load, v, found), found.growth
                fall *= 0.5 if last == side else 1.0
            last = side
        mode = high[2].mode * np.copysign(1.0, dot(high[2].mode, after[1] - before[1]))  # the way the surface moves
        away = mode * (LIMITS.start * self.unit / max(np.abs(mode).max(), 1e-300))
        return LimitPoint(high[0], high[1], state.active, away, high[2].kind)

    def _fold(self, points):
        """The load has passed its maximum: find it between the last points; if it lies beyond the target, arrive."""
        beyond = points[0][1]
        chord = _chord(beyond - points[1][1])
        bracket = sorted(((dot(chord, v), load, v) for load, v in points[:3]), key=lambda p: p[0])
        sharp = 0  # predictions that were right, in a row: one may be so by chance
        for _ in range(20):
            arc, top = _parabola_top(bracket)
            found = self._at(chord, arc, bracket)
            if found is None:
                break
            bracket = _narrowed(bracket, (arc, *found))
            sharp = sharp + 1 if abs(found[0] - top) < LIMITS.sharpness * self.unit else 0
            if sharp == 2:
                break
        _, load, v = max(bracket, key=lambda p: p[1])
        if load >= self.target:
            return self._arrived([(load, v), *[p for p in points[1:] if p[0] < load]], False)
        return LimitPoint(load, v, self.state.active, self._away(chord, bracket, (load, v), beyond), "fold")

    def _away(self, chord, bracket, fold, beyond):
        """The way from the fold to a state `start` beyond it, on the unstable branch, along which the motion leaves."""
        load, v = fold
        away, wanted = beyond - v, LIMITS.start * self.unit
        distance = np.abs(away).max()
        arc = dot(chord, v) + dot(chord, away) * min(LIMITS.growth, wanted / max(distance, 1e-12))
        found = self._at(chord, arc, bracket)
        if found is not None and found[0] < load and np.abs(found[1] - v).max() < 2.0 * wanted:
            away = found[1] - v
        return away * (wanted / max(np.abs(away).max(), 1e-300))


def _chord(step):
    """The direction along which the arc is measured: the unknown that moved most in the last step.

    All unknowns together would not do where one node jumps: far more of them move with the load, and back after it.
    """
    chord, most = np.zeros_like(step), int(np.abs(step).argmax())
    chord[most] = np.sign(step[most])
    return chord


def _narrowed(bracket, point):
    """The highest of four points (arc, load, v) with its neighbours in arc."""
    points = sorted([*bracket, point], key=lambda p: p[0])
    highest = max(range(4), key=lambda i: points[i][1])
    first = min(max(highest - 1, 0), 1)
    return points[first : first + 3]


def _parabola_top(bracket):
    """(arc, load) of the maximum of the parabola through (arc, load, v) in order of arc, the middle one highest.

    Kept off the middle by a hundredth of the bracket, so that every point narrows it.
    """
    (a, fa), (b, fb), (c, fc) = [(p[0], p[1]) for p in bracket]
    slope, slope2 = (fb - fa) / (b - a), (fc - fb) / (c - b)
    bend = (slope2 - slope) / (c - a)
    top = 0.5 * (a + b) - slope / (2.0 * bend) if bend < 0.0 else b
    least = 0.01 * min(b - a, c - b)
    if abs(top - b) < least:
        top = b + (least if c - b > b - a else -least)
    top = min(max(top, a + least), c - least)
    return top, fa + slope * (top - a) + bend * (top - a) * (top - b)
