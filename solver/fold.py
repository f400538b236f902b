"""Following a branch by its arc length: to the load asked for, or to the fold where the branch ends.

Near its end the state moves without bound per unit of load, but smoothly per unit of arc length s = <t, u>, t the chord
of the last two states. So s is prescribed and the load solved for: the fold is the maximum of the load over s.
"""

from dataclasses import dataclass

import numpy as np

from .interpolation import combine, lagrange
from .secants import advance, dot

SHORT, LONG = 0.1, 0.3  # of min(delta_n, delta_t): first and longest step of the fastest node
SHORTEST = 1e-4
GROWTH = 3.0  # of one step over the one before: farther, the extrapolation means nothing
ASTRAY = 3.0  # a point farther off than this many steps lies on another branch
MOST_STEPS = 40  # secant steps of one point of the arc
MOST_POINTS = 400
SHARPNESS = 1e-9  # of min(delta_n, delta_t): accuracy of the load at the fold


@dataclass(frozen=True)
class Fold:
    """The end of a branch: load (nm), displacement and traction there (2, m), and a state just beyond to leave from."""

    load: float
    u: np.ndarray
    traction: np.ndarray
    beyond: np.ndarray
    certain: bool = (
        True  # False: the branch could not be followed; whether it ends here is seen from where the flow leads
    )


def follow(method, state, loading, target):
    """The State at load `target` on the branch of `state`, or the Fold that comes before it."""
    points = _two_points(method, state, loading, target)
    if points is None:
        return _unstable_from(method, state, target)
    step = SHORT * method.unit
    for _ in range(MOST_POINTS):
        chord = points[0][1] - points[1][1]
        length = np.abs(chord).max()
        if length == 0.0:  # an edge in the way of the nodes, or nothing acts yet
            return _unstable_from(method, state, target)
        chord /= np.sqrt(dot(chord.ravel(), chord.ravel()))
        here = [(dot(chord.ravel(), u.ravel()), load, u) for load, u in points[:3]]
        step = min(step, GROWTH * length)
        ahead = here[0][0] + (here[0][0] - here[1][0]) * step / length
        found = _at_arc(method, state, loading, chord, ahead, here)
        if found is None or np.abs(found[1] - here[0][2]).max() > ASTRAY * step:
            step *= 0.5
            if step < SHORTEST * method.unit:
                return _unstable_from(method, state, target)
            continue
        points = [found, *points[:3]]
        if found[0] < points[1][0]:
            return _fold_or_target(method, state, loading, target, points)
        if found[0] >= target:
            return _arrive(method, state, loading, target, points)
        step = min(2.0 * step, LONG * method.unit)
    return _unstable_from(method, state, target)


def _unstable_from(method, state, target):
    """No branch to follow: let the flow decide from the state at hand, at the load asked for."""
    u = state.u.copy()
    load = max(target, state.load)
    method.contact.residual(u, state.active, (0.0, 0.0), method._r)
    return Fold(load, u, method.contact.traction(), u, certain=False)


def _two_points(method, state, loading, target):
    """The last two states [(load, u)], newest first; a second one is made by a short step if there is none."""
    if len(state.past) >= 2:
        return state.past[:3]
    part = 0.1
    while part > 1e-3:
        load = state.load + part * (target - state.load)
        u = state.u.copy()
        solved = load != state.load and method.solve(u, state.active, loading.at(load), state.secants, MOST_STEPS)
        if solved and np.abs(u - state.u).max() < 0.5 * method.unit:
            return [(load, u), state.past[0]]
        part *= 0.2
    return None


def _at_arc(method, state, loading, chord, arc, here):
    """The point (load, u) of the branch with <chord, u> = arc, or None; predicted through here = [(arc, load, u)]."""
    weights = lagrange([point[0] for point in here], arc)
    load = sum(weight * point[1] for weight, point in zip(weights, here, strict=True))
    u = combine(weights, [point[2] for point in here])
    direction = np.empty_like(u)
    direction[0], direction[1] = loading.direction
    contact, secants, r = method.contact, state.secants, method._r
    bound = 0.15 * method.unit
    worst = contact.residual(u, state.active, loading.at(load), r)
    for _ in range(MOST_STEPS):
        if worst <= method.tolerance:
            return load, u
        if not worst < 1e3 * method.unit:
            return None
        u_before, r_before = u.copy(), r.copy()
        correction, response = secants.move(r.ravel(), method.smooth), secants.move(direction.ravel(), method.smooth)
        slack = arc - dot(chord.ravel(), u.ravel()) - dot(chord.ravel(), correction)
        slope = dot(chord.ravel(), response)
        change = slack / slope if slope != 0.0 else 0.0
        change *= advance(u.ravel(), correction + change * response, bound)
        contact.residual(u, state.active, loading.at(load), r)
        secants.push(u.ravel(), r.ravel(), u_before.ravel(), r_before.ravel())
        load += change
        r += change * direction
        worst = np.abs(r).max()
    return None


def _arrive(method, state, loading, target, points):
    """The state at `target`, between the last two points."""
    (load1, u1), (load0, u0) = points[:2]
    u = u0 + (target - load0) / (load1 - load0) * (u1 - u0)
    active = method.settle(u, state.active, loading.at(target), state.secants, MOST_STEPS)
    if active is None or not method.stable(u, active, loading.at(target)):
        return _unstable_from(method, state, target)
    found = method.reached(state, target, u, active)
    found.past = [(target, u), *[p for p in points if p[0] < target][:3]]
    return found


def _fold_or_target(method, state, loading, target, points):
    """The load has passed its maximum: find it between the last points; if it lies beyond `target`, arrive there."""
    beyond = points[0][1]
    chord = beyond - points[1][1]
    chord /= np.sqrt(dot(chord.ravel(), chord.ravel()))
    bracket = sorted(((dot(chord.ravel(), u.ravel()), load, u) for load, u in points[:3]), key=lambda p: p[0])
    for _ in range(10):
        arc, top = _parabola_top(bracket)
        found = _at_arc(method, state, loading, chord, arc, bracket)
        if found is None:
            break
        bracket = _narrowed(bracket, (arc, *found))
        if abs(found[0] - top) < SHARPNESS * method.unit:
            break
    _, load, u = max(bracket, key=lambda p: p[1])
    if load >= target:
        return _arrive(method, state, loading, target, [(load, u), *[p for p in points[1:] if p[0] < load]])
    beyond = _farther(method, state, loading, chord, bracket, (load, u), beyond)
    method.contact.residual(u, state.active, loading.at(load), method._r)
    return Fold(load, u, method.contact.traction(), beyond)


def _farther(method, state, loading, chord, bracket, fold, beyond):
    """A state LONG beyond the fold, on the unstable branch, if `beyond` is nearer: the flow leaves it sooner."""
    load, u = fold
    distance = np.abs(beyond - u).max()
    if distance > 0.8 * LONG * method.unit:
        return beyond
    start, end = dot(chord.ravel(), u.ravel()), dot(chord.ravel(), beyond.ravel())
    arc = start + (end - start) * min(GROWTH, LONG * method.unit / max(distance, 1e-12))
    found = _at_arc(method, state, loading, chord, arc, bracket)
    if found is None or found[0] >= load or np.abs(found[1] - u).max() > 2.0 * LONG * method.unit:
        return beyond
    return found[1]


def _narrowed(bracket, point):
    """The highest of four points (arc, load, u) with its neighbours in arc."""
    points = sorted([*bracket, point], key=lambda p: p[0])
    highest = max(range(4), key=lambda i: points[i][1])
    first = min(max(highest - 1, 0), 1)
    return points[first : first + 3]


def _parabola_top(bracket):
    """(arc, load) of the maximum of the parabola through (arc, load, u) in order of arc, the middle one highest.

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
