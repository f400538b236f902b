"""Points along the arc of a branch: the largest change of an unknown is prescribed, and the load solved for.

Source: Keller 1977, Numerical solution of bifurcation and nonlinear eigenvalue problems; one unknown as the arc:
Rheinboldt & Burkardt 1983, doi:10.1145/357456.357460.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from .onset import mixed
from .state import Point
from .trace import lagrange
from .vectors import dot

# A "unit" is the problem's `unit`; distances of states are the largest of any unknown.
# Units: a corrected state farther than this from its prediction may have skipped a short slip, so the increment is
# repeated by arc length; also the first step of the arc.
SHORT = 0.1
LONG = 0.3  # units, longest step of the arc: from longer ones folds of the slider box were passed unseen
# Largest ratio of a step to the last one. A point farther than this many steps away is rejected: it lies on another
# branch.
GROWTH = 3.0
# Of a step of a walk: a point farther from its extrapolation lies on another branch, to which steps twice as long led.
# With 0.3 a third more points are needed
OFF = 0.5
FASTER = 1.4  # factor from one step of a walk to the next: with 2, half of the steps are taken again
# units: a point nearer than this to the State at the target is none of its past. From two such points no arc goes on;
# steps of the arc become no shorter than a tenth of this
NEAREST = 1e-3
TANGENT = 1e-5  # accuracy of a tangent; at 1e-3 a front that glides through the contact, a soft mode, was missed


def on_chord(points: Sequence[Point]) -> tuple[np.ndarray, list[float]]:
    """(chord (size,), arcs) of the last three Points, newest first: arc = <chord, v>.

    The chord is the direction of the unknown that moved most in the last step. The direction of all unknowns would not
    do where one node jumps: far more of them move with the load, and so back beyond the fold.
    """
    step = points[0].v - points[1].v
    chord, most = np.zeros_like(step), int(np.abs(step).argmax())
    chord[most] = np.sign(step[most])
    return chord, [dot(chord, v) for _, v in points[:3]]


def point_at(corrector, secants, chord, arc, points: Sequence[Point], off=np.inf) -> Point | None:
    """The Point with <chord, v> = arc, extrapolated from the last three; None where that fails.

    off: nm, from which distance to its extrapolation a point counts as one of another branch.
    """
    points = points[:3]
    arcs = [dot(chord, v) for _, v in points]
    if np.abs(np.diff(sorted(arcs))).min() <= 1e-12 * max(map(abs, arcs)):  # to round-off, two points are one
        return None
    guess = mixed(lagrange(arcs, arc), points)
    solution = corrector.solve(guess.v, guess.load, secants, chord, arc)
    if solution is None or np.abs(solution.v - guess.v).max() > off:
        return None
    return Point(solution.load, solution.v)


def walk_arc(corrector, points: Sequence[Point]) -> Iterator[Point]:
    """Yields Points farther and farther along a branch, through its folds, from two or more, newest first.

    It ends where the arc cannot be continued. Their stability is not judged.
    """
    points, unit, secants = list(points), corrector.problem.unit, corrector.secants()
    step, turned = np.abs(points[0].v - points[1].v).max(), False
    while step > NEAREST * unit:
        step = min(step, GROWTH * np.abs(points[0].v - points[1].v).max(), LONG * unit)
        chord, arcs = on_chord(points)
        point = point_at(corrector, secants, chord, arcs[0] + step, points, OFF * step)
        if point is not None and np.abs(point.v - points[0].v).max() <= GROWTH * step:
            points, step, turned = [point, *points[:2]], FASTER * step, False
            yield point
        elif turned:
            step *= 0.5
        else:  # the branch turned beyond what the last points foretell
            step *= 0.5
            points, turned = [points[0], _before(corrector, points[0], points[1], step)], True


def _before(corrector, point, last, step):
    """The Point a step before another one, nm, along the tangent there; last: an earlier one."""
    along = corrector.direction(point, TANGENT)
    back = np.copysign(step / np.abs(along).max(), dot(along, point.v - last.v))
    return Point(point.load - back, point.v - back * along)
