"""Points of a measured profile made periodic: its part, its filter, its mean line, its ends; slopes are to be small.

The filter is the Gaussian one. Its weight at a distance x is exp(-pi (x / (alpha c))^2), with alpha^2 = ln 2 / pi and
the cut-off c: a wave of that length keeps half of its amplitude. At the ends the weights within it are normalised.
Source: ISO 16610-21:2011, Geometrical product specifications, Filtration, Linear profile filters: Gaussian filters.
"""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene import LIMITS
from ..surfaces import EVEN, FEWEST_POINTS, LENGTHS, STEEPEST, DataError, Profile, averaged
from ..text import counted

Floats = NDArray[np.float64]
LONG = 20_000.0  # nm: a longer profile has nodes too far apart at any number of nodes that is computed soon
PART = 2_000.0  # nm
LOWEST = 0.01  # nm, rms of heights: no instrument measures less
SAME = 1e-6  # of peak to valley: ends that differ by less are one point, printed twice
SMOOTH = 0.2  # of peak to valley: largest second difference of a profile whose period shows; 15 points a wave have 0.09
MOST_POINTS = int(LIMITS["nodes"].high)  # kept; there are never more nodes
REACH = 0.05  # of the length, at each end, over which a step between the ends is spread
ALPHA = (np.log(2.0) / np.pi) ** 0.5


class Points(NamedTuple):
    """Points of a profile, (n,) each: the number of their line in the file, x and z in nm."""

    line: NDArray[np.int64]
    x: Floats
    z: Floats

    @property
    def length(self) -> float:
        """From the first point to the last, nm."""
        return float(self.x[-1] - self.x[0])

    @property
    def apart(self) -> float:
        """Mean distance of two points, nm."""
        return self.length / (self.x.size - 1)

    @property
    def even(self) -> bool:
        """Whether the points are at equal distances."""
        gaps = np.diff(self.x)
        return bool(np.ptp(gaps) <= EVEN * gaps.mean())

    @property
    def levelled(self) -> tuple[Floats, float]:
        """(heights above the line of least squares (n,), its slope)."""
        x, z = self.x - self.x.mean(), self.z - self.z.mean()
        tilt = float(x @ z / (x @ x))
        return z - tilt * x, tilt

    def refused(self, reason: str) -> DataError:
        """The DataError that names the line of the last point."""
        return DataError(reason, int(self.line[-1]) if self.line.size else None)


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
    points = _closed(points, period)
    points, done = (points, []) if cut_off is None else _filtered(points, cut_off, bool(period))
    if period:
        _reject_steep(points)
        done.append(f"The ends meet: read as one period of {period:.6g} nm; nothing was removed or joined.")
    else:
        points, joined = _joined(points)
        done += joined
    z, resampled = _at_equal_distances(points)
    start = int(np.argmin(z))
    shift = f"Shifted by {start * length / z.size:.4g} nm: the deepest valley lies at the ends of the cell"
    shift += f"; with fewer nodes than {z.size} each shows the mean over the node spacing."
    return Profile(length, np.roll(z, -start), (*notes, *done, *resampled, shift))


def _with_cut_off(error, points, periodic, width):
    """The SteepError with the least cut-off, to two digits, with which the profile is read to its end."""
    period = _period(points, periodic)
    spacing, z = _even(_closed(points, period))
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
        raise points.refused(f"only {counted(points.x.size, 'point')}, at least {FEWEST_POINTS} are needed")


def _reject_unlikely(points, length):
    """Raises DataError for a length, nm, and for heights without their tilt, that a wrong unit makes."""
    low, high = LENGTHS
    if not low <= length <= high:
        raise points.refused(f"the profile is {length:.4g} nm long, allowed: {low:g} .. {high:g} nm")
    rms, most = float(points.levelled[0].std()), 0.1 * points.length
    if not LOWEST <= rms <= most:
        allowed = f"allowed: {LOWEST:g} .. {most:.4g} nm, a tenth of the length"
        raise points.refused(f"the heights have an rms of {rms:.3g} nm, {allowed}; check the units of x and z")


def _cut(points, width, part):
    """(the part of the Points that is used, its ends interpolated; [note])."""
    length = points.length
    if part is not None:
        start, end = map(float, part)
        if width is not None or not 0.0 <= start < end <= length * (1.0 + EVEN):
            reason = f"part = {part}: allowed: from 0 to {length:.6g} nm, ascending, without width"
            raise DataError(f"{reason}; give such a part")
        note = f"Of {length:.6g} nm those from {start:g} to {end:g} nm are used."
    elif width is not None:
        if not (width > 0.0 and width <= (1.0 + EVEN) * length):  # nan fails it too
            reason = f"the profile is {length:.6g} nm long, the width asked for is {float(width):g} nm"
            raise points.refused(f"{reason}; allowed: above 0 to that length; set such a width")
        start, end = 0.5 * (length - width), 0.5 * (length + width)
        note = f"Of {length:.6g} nm the {float(width):g} nm in the middle are used."
    else:
        start, end = proposed(points)
        if end - start > LONG:
            raise _too_far_apart(points, (round(start), int(end)))
        why = f"all of it would give nodes at least {length / MOST_POINTS:.3g} nm apart, which is the lattice period"
        note = f"Of {length:.6g} nm the {end - start:g} nm in the middle are used: {why}; choose another by part."
    if part is None and end - start >= (1.0 - EVEN) * length:
        return points, []
    return _between(points, start, end), [note]


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


def _between(points, start, end):
    """The Points from start to end, nm from the first one; the ends are interpolated."""
    line, x, z = points
    ends = x[0] + start, min(x[0] + end, x[-1])
    part = slice(np.searchsorted(x, ends[0], "right") - 1, np.searchsorted(x, ends[1]) + 1)
    within, heights = x[part].copy(), z[part].copy()
    within[[0, -1]], heights[[0, -1]] = ends, np.interp(ends, x, z)
    return Points(line[part], within, heights)


def _period(points, periodic):
    """The length of the period that the points are, nm; None where they are none."""
    z, even, height = points.z, points.even, float(np.ptp(points.z))
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
    """The Points; of a period the last one repeats the first."""
    line, x, z = points
    if period and period > points.length:
        return Points(np.append(line, line[-1]), np.append(x, x[0] + period), np.append(z, z[0]))
    return points


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


def smoothed(z: Floats, spacing: float, cut_off: float, periodic: bool = False) -> Floats:
    """Heights z (n,) at distances of `spacing`, filtered; cut_off and spacing in one unit."""
    from scipy.ndimage import gaussian_filter1d  # a tenth of the time that importing `solver` takes

    sigma = ALPHA * cut_off / (2.0 * np.pi) ** 0.5 / spacing
    if periodic:
        return gaussian_filter1d(z, sigma, mode="wrap", truncate=6.0)
    weights = gaussian_filter1d(np.ones_like(z), sigma, mode="constant", truncate=6.0)
    return gaussian_filter1d(z, sigma, mode="constant", truncate=6.0) / weights


def least_cut_off(z: Floats, spacing: float, steepest: float, periodic: bool = False) -> float | None:
    """The cut-off, to a tenth of it, from which no slope of the heights z (n,) exceeds `steepest`; None: at none.

    Cut-offs up to half of the length are tried.
    """
    cut_off = 2.0 * spacing
    while cut_off < 0.5 * z.size * spacing:
        if np.abs(np.diff(smoothed(z, spacing, cut_off, periodic))).max() <= steepest * spacing:
            return float(cut_off)
        cut_off *= 1.1
    return None


def _reject_steep(points, why=""):
    """Raises SteepError at the first slope beyond STEEPEST; why: what made it."""
    slopes = np.abs(np.diff(points.z) / np.diff(points.x))
    if slopes.max() > STEEPEST:
        k = int(np.argmax(slopes > STEEPEST))
        reason = f"{why}slope {slopes[k]:.3g} from the point before, allowed: up to {STEEPEST:g}"
        raise SteepError(reason, int(points.line[k + 1]))


def _joined(points):
    """(Points less their mean line, with ends of one height; [notes]); rejects slopes that are not small.

    The step between the ends is spread over REACH at each end, as a cosine.
    """
    z, tilt = points.levelled
    if abs(tilt) > STEEPEST:
        allowed = f"allowed: up to {STEEPEST:g}; level it first"
        raise points.refused(f"the profile as a whole is tilted by {tilt:.3g}, {allowed}")
    _reject_steep(points._replace(z=z))
    step, reach = float(z[-1] - z[0]), REACH * points.length
    start, end = (np.clip(far / reach, 0.0, 1.0) for far in (points.x - points.x[0], points.x[-1] - points.x))
    joined = points._replace(z=z + 0.25 * step * (np.cos(np.pi * start) - np.cos(np.pi * end)))
    apart, over = f"{abs(step):.4g} nm apart", f"joined over {reach:.4g} nm at each end"
    _reject_steep(joined, why=f"its ends, {apart}, {over}: ")
    removed = f"A tilt of {tilt:.3g} was removed (line of least squares)."
    return joined, [removed, f"The ends, {apart}, were {over} (a cosine)."]


def _at_equal_distances(points):
    """(heights (m,) of one period at equal distances, [note]), without the last point, the first of the next period."""
    _, x, z = points
    gaps, even = np.diff(x), points.even
    count = gaps.size if even else 4 * gaps.size  # so the corners of the linear pieces stay
    if even and count <= MOST_POINTS:
        return z[:-1], []
    count = min(count, MOST_POINTS)
    resampled = f"{x.size} points were resampled to {count} at equal distances"
    if gaps.min() < points.length / count:
        return averaged(x, z, count), [f"{resampled}: means over the new spacing, where they lay closer."]
    return np.interp(np.arange(count) * points.length / count, x - x[0], z), [f"{resampled}, linearly."]
