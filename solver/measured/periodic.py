"""Points of a measured profile made periodic: its part, its filter, its mean line, its ends; slopes are to be small."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene import LIMITS
from ..surfaces import EVEN, FEWEST_POINTS, LENGTHS, STEEPEST, DataError, Profile, averaged
from ..text import counted
from .smoothing import least_cut_off, smoothed

LONG = 20_000.0  # nm: a longer profile has nodes too far apart at any number of nodes that is computed soon
PART = 2_000.0  # nm
LOWEST = 0.01  # nm, rms of heights: no instrument measures less
SAME = 1e-6  # of peak to valley: ends that differ by less are one point, printed twice
SMOOTH = 0.2  # of peak to valley: largest second difference of a profile whose period shows; 15 points a wave have 0.09
MOST_POINTS = int(LIMITS["nodes"].high)  # kept; there are never more nodes
REACH = 0.05  # of the length, at each end, over which a step between the ends is spread


class Points(NamedTuple):
    """Points of a profile, (n,) each: the number of their line in the file, x and z in nm."""

    line: NDArray[np.int64]
    x: NDArray[np.float64]
    z: NDArray[np.float64]

    @property
    def last(self) -> int | None:
        """The line of the last point; None without any."""
        return int(self.line[-1]) if self.line.size else None

    @property
    def length(self) -> float:
        """From the first point to the last, nm."""
        return float(self.x[-1] - self.x[0])

    @property
    def apart(self) -> float:
        """Mean distance of two points, nm."""
        return self.length / (self.x.size - 1)

    @property
    def centred(self) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """(x, z) less their means, and the slope of the line of least squares."""
        x, z = self.x - self.x.mean(), self.z - self.z.mean()
        return x, z, float(x @ z / (x @ x))


class SteepError(DataError):
    """Slopes that are not small; cut_off: a wavelength, nm, of a filter that suffices, or None for none."""

    cut_off: float | None = None


def made_periodic(
    points: Points,
    periodic: bool | None,
    width: float | None,
    part: tuple[float, float] | None,
    cut_off: float | None,
    notes: list[str],
) -> Profile:
    """The Profile of Points; arguments as of `read_profile`. notes: what was done before.

    Raises DataError; a SteepError names a cut-off with which the profile is read to its end.
    """
    reject_few(points)
    points, cut = _cut(points, width, part)
    try:
        return _made(points, periodic, width, cut_off, [*notes, *cut])
    except SteepError as error:
        raise _with_cut_off(error, points, periodic, width) from None


def _made(points, periodic, width, cut_off, notes):
    """The Profile of Points; raises DataError."""
    reject_few(points)
    period = _period(points, periodic)
    length = period or (points.length if width is None else float(width))
    _reject_unlikely(points, length)
    points, done = _one_period(points, period, cut_off)
    z, resampled = _at_equal_distances(points)
    start = int(np.argmin(z))
    shift = f"Shifted by {start * length / z.size:.4g} nm: the deepest valley lies at the ends of the cell"
    shift += f"; with fewer nodes than {z.size} each shows the mean over the node spacing."
    return Profile(length, np.roll(z, -start), (*notes, *done, *resampled, shift))


def _one_period(points, period, cut_off):
    """(Points filtered, and of one period: as they are, or levelled and with their ends joined; [notes])."""
    if period:
        points = _closed(points, period)
    points, notes = (points, []) if cut_off is None else _filtered(points, cut_off, bool(period))
    if period:
        _reject_steep(points)
        return points, [*notes, f"The ends meet: read as one period of {period:.6g} nm; nothing was removed or joined."]
    points, tilt = _levelled(points)
    points, step = _joined(points)
    return points, [*notes, tilt, step]


def _with_cut_off(error, points, periodic, width):
    """The SteepError with the least cut-off, to two digits, with which the profile is read to its end."""
    period = _period(points, periodic)
    spacing, z = _even(_closed(points, period) if period else points)
    most = float(f"{0.499 * points.length:.4g}")
    cut_off, last = least_cut_off(z[:-1] if period else z, spacing, STEEPEST, bool(period)) or most, None
    while cut_off != last:
        last, cut_off = cut_off, min(float(f"{1.1 * cut_off:.2g}"), most)
        with suppress(DataError):
            _made(points, periodic, width, cut_off, [])
            error.cut_off, error.call = cut_off, {"cut_off": cut_off}
            error.reason += f"; a cut-off of {cut_off:g} nm makes it flat enough, or rescale it"
            return error
    error.reason += "; no cut-off makes it flat enough: rescale it, or cut it where its ends are of one height"
    return error


def reject_few(points: Points) -> None:
    """Raises DataError for fewer than FEWEST_POINTS."""
    if points.x.size < FEWEST_POINTS:
        raise DataError(f"only {counted(points.x.size, 'point')}, at least {FEWEST_POINTS} are needed", points.last)


def _reject_unlikely(points, length):
    """Raises DataError for a length, nm, and for heights without their tilt, that a wrong unit makes."""
    low, high = LENGTHS
    if not low <= length <= high:
        reason = f"the profile is {length:.4g} nm long, allowed: {low:g} .. {high:g} nm"
        raise DataError(reason, points.last)
    x, z, tilt = points.centred
    rms, most = float((z - tilt * x).std()), 0.1 * points.length
    if not LOWEST <= rms <= most:
        allowed = f"allowed: {LOWEST:g} .. {most:.4g} nm, a tenth of the length"
        raise DataError(f"the heights have an rms of {rms:.3g} nm, {allowed}; check the units of x and z", points.last)


def _cut(points, width, part):
    """(the part of the Points that is used, [note])."""
    if part is not None:
        start, end = map(float, part)
        if width is not None or not 0.0 <= start < end <= points.length * (1.0 + EVEN):
            reason = f"part = {part}: allowed: from 0 to {points.length:.6g} nm, ascending, without width"
            raise DataError(f"{reason}; give such a part")
        return _between(points, start, end), [f"Of {points.length:.6g} nm those from {start:g} to {end:g} nm are used."]
    if width is not None:
        return _middle(points, float(width))
    start, end = proposed(points)
    if end - start >= points.length:
        return points, []
    if end - start > LONG:
        raise _too_far_apart(points, (round(start), int(end)))
    spacing = points.length / MOST_POINTS
    why = f"all of it would give nodes at least {spacing:.3g} nm apart, which is the lattice period"
    used = f"Of {points.length:.6g} nm the {end - start:g} nm in the middle are used"
    return _between(points, start, end), [f"{used}: {why}; choose another by part."]


def proposed(points: Points) -> tuple[float, float]:
    """The part that is proposed, nm from the first point: all, or of a long profile the middle with enough points."""
    size = points.length
    if size > LONG:
        size = min(size, max(PART, 2 * FEWEST_POINTS * points.apart))
    return 0.5 * (points.length - size), 0.5 * (points.length + size)


def _too_far_apart(points, part):
    """The DataError for points of which LONG has too few; it names a part that has enough."""
    with suppress(SteepError):  # which names a cut-off once the part is given
        _made(_between(points, *part), None, None, None, [])
    why = f"its points are {points.apart:.4g} nm apart: {LONG:g} nm, the most that is taken by itself, hold too few"
    remedy = "give a part, but the nodes are then as far apart, which is the lattice period"
    return DataError(f"{why}; {remedy}", call={"part": part})


def _middle(points, width):
    """(the middle part of that width, its ends interpolated; [note]), or all where it is no longer."""
    spare = points.length - width
    if not (width > 0.0 and spare >= -EVEN * points.length):  # nan fails it too
        reason = f"the profile is {points.length:.6g} nm long, the width asked for is {width:g} nm"
        raise DataError(f"{reason}; allowed: above 0 to that length; set such a width", points.last)
    if spare <= EVEN * points.length:
        return points, []
    note = f"Of {points.length:.6g} nm the {width:g} nm in the middle are used."
    return _between(points, 0.5 * spare, points.length - 0.5 * spare), [note]


def _between(points, start, end):
    """The Points from start to end, nm from the first one; the ends are interpolated."""
    line, x, z = points
    ends = x[0] + start, min(x[0] + end, x[-1])
    part = slice(np.searchsorted(x, ends[0], "right") - 1, np.searchsorted(x, ends[1]) + 1)
    within, heights = x[part].copy(), z[part].copy()
    within[[0, -1]], heights[[0, -1]] = ends, np.interp(ends, x, z)
    return Points(line[part], within, heights)


def _is_even(x):
    """Whether points are at equal distances."""
    gaps = np.diff(x)
    return bool(np.ptp(gaps) <= EVEN * gaps.mean())


def _period(points, periodic):
    """The length of the period that the points are, nm; None where they are none."""
    _, x, z = points
    even, height = _is_even(x), float(np.ptp(z))
    step = abs(float(z[-1] - z[0]))
    repeats = step <= SAME * height
    if periodic and not (repeats or even):
        reason = f"its ends differ by {step:.4g} nm, and its points are not at equal distances"
        raise DataError(f"{reason}; a period needs one of both; repeat the first point, or use periodic=False")
    if periodic is None and even and height:
        around = np.append(z[:-1], z[:2]) if repeats else np.append(z, z[:2])
        bends = np.abs(np.diff(around, 2))
        smooth = bends.max() <= SMOOTH * height  # else ends that differ may meet by chance
        periodic = (repeats or smooth) and bends[-2:].max() <= 2.0 * bends[:-2].max()
    return points.length + (0.0 if repeats else points.apart) if periodic else None


def _closed(points, period):
    """Points of one period, whose last one repeats the first."""
    line, x, z = points
    if period > points.length:
        return Points(np.append(line, line[-1]), np.append(x, x[0] + period), np.append(z, z[0]))
    return points


def _levelled(points):
    """(Points with heights above the mean line of least squares, note); rejects slopes that are not small."""
    x, z, tilt = points.centred
    if abs(tilt) > STEEPEST:
        reason = f"the profile as a whole is tilted by {tilt:.3g}, allowed: up to {STEEPEST:g}; level it first"
        raise DataError(reason, points.last)
    levelled = points._replace(z=z - tilt * x)
    _reject_steep(levelled)
    return levelled, f"A tilt of {tilt:.3g} was removed (line of least squares)."


def _even(points):
    """(spacing, z (n,)) of Points at equal distances: themselves, or interpolated linearly."""
    return points.apart, np.interp(np.arange(points.x.size) * points.apart, points.x - points.x[0], points.z)


def _filtered(points, cut_off, periodic):
    """(Points without wavelengths below the cut-off, nm, [note])."""
    spacing, z = _even(points)
    if not 2.0 * spacing <= cut_off <= 0.5 * points.length:
        allowed = f"{2.0 * spacing:.4g} .. {0.5 * points.length:.4g} nm, two spacings to half of the length"
        raise DataError(f"cut_off = {cut_off:g}: allowed: {allowed}; give a number in that range")
    found = smoothed(z[:-1] if periodic else z, spacing, cut_off, periodic)
    found = np.append(found, found[0]) if periodic else found
    note = f"A Gaussian filter with a cut-off of {cut_off:g} nm changed the rms of heights from {z.std():.4g} to"
    x = points.x[0] + np.arange(z.size) * spacing
    return Points(points.line, x, found), [f"{note} {found.std():.4g} nm."]


def _reject_steep(points, why=""):
    """Raises SteepError at the first slope beyond STEEPEST; why: what made it."""
    slopes = np.abs(np.diff(points.z) / np.diff(points.x))
    if slopes.max() > STEEPEST:
        k = int(np.argmax(slopes > STEEPEST))
        reason = f"{why}slope {slopes[k]:.3g} from the point before, allowed: up to {STEEPEST:g}"
        raise SteepError(reason, int(points.line[k + 1]))


def _joined(points):
    """(Points with ends of one height, note): the step is spread over REACH at each end, as a cosine."""
    _, x, z = points
    step, reach = float(z[-1] - z[0]), REACH * points.length
    start, end = (np.clip(distance / reach, 0.0, 1.0) for distance in (x - x[0], x[-1] - x))
    joined = points._replace(z=z + 0.25 * step * (np.cos(np.pi * start) - np.cos(np.pi * end)))
    apart, over = f"{abs(step):.4g} nm apart", f"joined over {reach:.4g} nm at each end"
    _reject_steep(joined, why=f"its ends, {apart}, {over}: ")
    return joined, f"The ends, {apart}, were {over} (a cosine)."


def _at_equal_distances(points):
    """(heights (m,) of one period at equal distances, [note]), without the last point, the first of the next period."""
    _, x, z = points
    gaps, even = np.diff(x), _is_even(x)
    count = gaps.size if even else 4 * gaps.size  # so the corners of the linear pieces stay
    if even and count <= MOST_POINTS:
        return z[:-1], []
    count = min(count, MOST_POINTS)
    resampled = f"{x.size} points were resampled to {count} at equal distances"
    if gaps.min() < points.length / count:
        return averaged(x, z, count), [f"{resampled}: means over the new spacing, where they lay closer."]
    return np.interp(np.arange(count) * points.length / count, x - x[0], z), [f"{resampled}, linearly."]
