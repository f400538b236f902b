"""Where a mode begins to grow: the end of a branch that is no fold, a bifurcation or the onset of flutter."""

import numpy as np
from scipy.optimize import brentq

from .anderson import dot
from .state import SHARP, TINY, End, Point, State


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
    """The State at the end, to SHARP, between a stable one and an unstable one; the last one found where that fails."""
    found = {0.0: stable, 1.0: unstable}

    def growth(part):
        if part not in found:
            low, high = max(p for p in found if p < part), min(p for p in found if p > part)
            share = (part - low) / (high - low)
            guess = mixed((1.0 - share, share), (found[low], found[high]))
            solution = corrector.solve(guess.v, guess.load, state.secants)
            if solution is None:
                raise ArithmeticError
            found[part] = judged(Point(guess.load, solution.v), found[high].mode)
        return found[part].mode.growth

    least = SHARP * corrector.problem.unit / max(unstable.load - stable.load, TINY)
    try:
        return found[brentq(growth, 0.0, 1.0, xtol=min(least, 1.0))]
    except ArithmeticError:
        return found[min(part for part in found if found[part].mode.growth >= 0.0)]


def mixed(weights, points) -> Point:
    """The combination of Points or States with these weights: a guess, not a solution."""
    weights = np.asarray(weights)
    return Point(float(weights @ [load for load, *_ in points]), weights @ np.array([v for _, v, *_ in points]))
