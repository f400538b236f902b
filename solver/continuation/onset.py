"""Where a mode begins to grow: the end of a branch that is no fold, a bifurcation or the onset of flutter."""

import numpy as np

from .state import SHARP, TINY, End, Point, State
from .vectors import dot


def onset(corrector, judge, state, older, after, mode) -> End | None:
    """The End before the unstable Point `after`, where the growth of its `mode` is zero; None if not found.

    older: Points of the branch of `state` before it, newest first; not all of them have been judged.
    """

    def judged(point, mode):
        return State.at_rest(*point, mode=judge.rightmost(corrector.problem, point.v, mode))

    unstable = State.at_rest(*after, mode=mode)
    for point in older:
        stable = judged(point, unstable.mode)
        if stable.mode.growth < 0.0:
            break
        unstable = stable
    else:
        return None
    end = _narrowed(corrector, judged, state, stable, unstable)
    x, way = end.mode.x, after.v - older[0].v
    along = float(dot(x, way) / max(dot(x, x) * dot(way, way), TINY) ** 0.5)
    # the mode and the way are orthogonal; round-off of symmetric problems makes 1e-5, and an inaccurate mode 2e-3
    symmetric = end.mode.kind == "bifurcation" and abs(along) < 1e-2 and not corrector.problem.alike(end.v)
    # the surface leaves the way that the state moves; where both ways are equal, as the rule of `Linearised.seen` says
    phi = x * np.copysign(1.0 / max(np.abs(x).max(), TINY), 1.0 if symmetric else along)
    return End(end.load, end.v, phi, end.mode.kind, sensitive=symmetric)


def _narrowed(corrector, judged, state, stable, unstable):
    """The unstable State at the end, SHARP beyond it, by regula falsi in its Illinois variant."""
    low, high, last = stable.mode.growth, unstable.mode.growth, None  # an end that stays twice counts half
    for _ in range(60):  # halving a step of 0.3 units down to SHARP takes 28
        width = unstable.load - stable.load
        if width <= SHARP * corrector.problem.unit or low == high:
            break
        part = min(max(low / (low - high), 1e-3), 1.0 - 1e-3)  # so that both sides move
        guess = mixed((part, 1.0 - part), (unstable, stable))
        solution = corrector.solve(guess.v, guess.load, state.secants)
        if solution is None:
            break
        side = judged(Point(guess.load, solution.v), unstable.mode)
        grows = side.mode.growth >= 0.0
        if grows:
            unstable, high, low = side, side.mode.growth, 0.5 * low if last is grows else low
        else:
            stable, low, high = side, side.mode.growth, 0.5 * high if last is grows else high
        last = grows
    return unstable


def mixed(weights, points) -> Point:
    """The combination of Points or States with these weights: a guess, not a solution."""
    weights = np.asarray(weights)
    return Point(float(weights @ [load for load, *_ in points]), weights @ np.array([v for _, v, *_ in points]))
