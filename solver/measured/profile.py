"""Reads a measured profile, two columns x, z in nm, and makes it periodic; reports what it did and what it rejects."""

import re
from io import StringIO
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene import LIMITS
from ..surfaces import EVEN, FEWEST_POINTS, LENGTHS, NO_UNIT, PERIOD, STEEPEST, DataError, Profile, averaged
from ..text import counted
from .instruments import is_instruments, read_line
from .smoothing import least_cut_off, smoothed
from .tables import SHOWN, Source, content_of, listed, read_table, reject_gaps
from .units import FACTORS, factor, units_above

LONG = 20_000.0  # nm: a longer profile has nodes too far apart at any number of nodes that is computed soon
PART = 2_000.0  # nm
LOWEST = 0.01  # nm, rms of heights: no instrument measures less
SAME = 1e-6  # of peak to valley: ends that differ by less are one point, printed twice
SMOOTH = 0.2  # of peak to valley: largest second difference of a profile whose period shows; 15 points a wave have 0.09
MOST_POINTS = int(LIMITS["nodes"].high)  # kept; there are never more nodes


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


class Trace(NamedTuple):
    """A profile as measured: x and z (n,) in nm; named: whether the file, or the argument, names their unit."""

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    named: bool


class SteepError(DataError):
    """Slopes that are not small; cut_off: a wavelength, nm, of a filter that suffices, or None for none."""

    def __init__(self, reason: str, line: int | None, cut_off: float | None) -> None:
        super().__init__(reason, line)
        self.cut_off = cut_off


def read_trace(source: Source, unit: str | None = None, line: str | None = None) -> Trace:
    """Reads the points of a profile as `read_profile` does, without changing any, to be looked at; raises DataError."""
    points, notes, _ = _points(source, unit, line)
    return Trace(points.x, points.z, NO_UNIT not in notes)


def read_profile(
    source: Source,
    width: float | None = None,
    periodic: bool | None = None,
    unit: str | None = None,
    part: tuple[float, float] | None = None,
    line: str | None = None,
    cut_off: float | None = None,
) -> Profile:
    """Reads a measured profile from a CSV of x and z (nm), or from the file of an instrument (`solver.instruments`).

    Parameters: source: a path, or the content of a file: text with line breaks, bytes, or an open file. The
    lines above the numbers may give units, as in x [µm], z [nm]. width: use only the middle part of this width, nm.
    periodic: whether the points are one period, with or without its first point repeated at the end; by default that is
    so where the ends meet in height and slope. unit: that of x and z, where the file names none; without either they
    are read as nm, with a caution. part: use only that from .. to, nm from the first point. Of more than LONG the
    middle part of PART is used, unless width or part is given. line: "row 12" or "column 12" of a map of heights; by
    default the row through its highest point. cut_off: wavelength, nm, below which a Gaussian filter removes roughness;
    nothing is smoothed without it.
    Returns a Profile with points at equal distances. Of one period all heights are kept. Of another profile the mean
    line is removed, and the ends are joined.
    Raises DataError.

    Example: `profile = read_profile("profile.csv")`, then
    `Scene(surface="measured", measured=profile, width=profile.length)`
    """
    points, notes, marked = _points(source, unit, line)
    periodic = marked or None if periodic is None and width is None else periodic
    points, cut = _cut(points, width, part)
    _reject_few(points)
    period = _period(points, periodic)
    length = period or (points.length if width is None else float(width))
    _reject_unlikely(points, length)
    points, done = _one_period(points, period, cut_off)
    z, resampled = _at_equal_distances(points)
    start = int(np.argmin(z))
    shift = f"Shifted by {start * length / z.size:.4g} nm: the deepest valley lies at the ends of the cell"
    shift += f"; with fewer nodes than {z.size} each shows the mean over the node spacing."
    return Profile(length, np.roll(z, -start), (*notes, *cut, *done, *resampled, shift))


def _one_period(points, period, cut_off):
    """(Points filtered, and of one period: as they are, or levelled and with their ends joined; [notes])."""
    if period:
        points = _closed(points, period)
    points, notes = (points, []) if cut_off is None else _filtered(points, cut_off, bool(period))
    if period:
        _reject_steep(points, True)
        return points, [*notes, f"The ends meet: read as one period of {period:.6g} nm; nothing was removed or joined."]
    points, tilt = _levelled(points)
    points, step = _joined(points)
    return points, [*notes, tilt, step]


def _points(source, unit, line):
    """(Points, [notes], whether the file calls them one period) of the rows that hold data."""
    content = content_of(source)
    if isinstance(content, bytes) and is_instruments(content):
        return _of_instrument(content, unit, line)
    if line is not None:
        raise DataError(f"line = {line!r}: allowed with a map of heights only; leave it out")
    # without a line break, a text would be a path
    table = read_table(content if isinstance(content, bytes) else StringIO(content), "two columns: x, z in nm")
    x_z, units, spare = _two_of(table)
    lines, columns, left_out = table.numbers(dict(zip("xz", x_z, strict=True)), profile=True)
    units = units or units_above(table.above)
    if unit is not None and units and {factor(each) for each in units} != {factor(unit)}:
        named = " and ".join(dict.fromkeys(units))
        raise DataError(f"unit = {unit!r}, but the file names {named}; leave unit out, or correct the file")
    unknown = [NO_UNIT] * (units is None and unit is None)
    units = units or (unit or "nm",) * 2
    for name, given in zip("xz", units, strict=True):
        columns[name] = columns[name] * factor(given)
        large = np.flatnonzero(np.abs(columns[name]) > 1e9)  # a metre: the unit is wrong
        if large.size:
            reason = f"{name} = {columns[name][large[0]]:g} nm: allowed: -1e+09 .. 1e+09 nm; check its unit"
            raise DataError(reason, int(lines[large[0]]))
    read = "x and z are read as nm" if set(units) == {"nm"} else "x is read as {}, z as {}".format(*units)
    points = Points(lines, columns["x"], columns["z"])
    _reject_few(points)
    notes = [f"{lines.size} points; {read}; summits of z face the substrate.", *spare, *left_out, *unknown]
    return points, notes, PERIOD in table.above


def _of_instrument(content, unit, line):
    """As `_points`, of the file of an instrument."""
    x, z, note = read_line(content, unit, line)
    known = np.flatnonzero(np.isfinite(z))
    reject_gaps(known, [0] * z.size)
    left = z.size - known.size
    missing = [f"{counted(left, 'missing point')} left out."] * bool(left)
    points = Points(np.zeros(known.size, int), x[known], z[known])  # there are no lines to name
    _reject_few(points)
    return points, [note, *missing], False


def _two_of(table):
    """(the indices of x and z, their units or None, [a note on other columns]): by name, or else the first two."""
    columns, width, line = table.columns, table.cells.shape[1], int(table.cells.index[0])
    if width < 2:
        raise DataError("one column, two are needed: x, z in nm", line)
    if not columns and width % 2 == 0 and width > 2 and table.comma:
        remedy = "write a heading, decimal points, or semicolons between columns"
        raise DataError(f"{width} columns, two are needed: x, z in nm; {remedy}", line)
    if not columns and width > 3:
        remedy = "a matrix of heights cannot be read: save one row or column of it as x and z"
        raise DataError(f"{width} columns without a heading, two are needed: x, z in nm; {remedy}", line)
    names = [re.split(r"[\W_]", column.name.strip())[0].lower() for column in columns[:width]]  # x of x_um, x in um
    height = "z" if "z" in names else "y"
    x_z = [names.index("x"), names.index(height)] if {"x", height} <= set(names) else [0, 1]
    units = [columns[k].unit for k in x_z if k < len(columns) and columns[k].unit]
    for name, unit in zip("xz", units, strict=False):
        if unit.lower() not in FACTORS:
            allowed = "allowed units: nm, µm, Å, mm, cm, m"
            raise DataError(f"heading: {name} in {unit[:SHOWN]!r}; {allowed}; correct or delete the heading")
    others = [k for k in range(width) if k not in x_z and table.cells.iloc[:, k].ne("").any()]
    rest = [(columns[k].name if k < len(columns) else "") or f"column {k + 1}" for k in others]
    return x_z, tuple((2 * units)[:2]) or None, [f"Not used: {listed(rest)}."] * bool(rest)


def _reject_unlikely(points, length):
    """Raises DataError for a length, nm, and for heights without their tilt, that a wrong unit makes."""
    low, high = LENGTHS
    if not low <= length <= high:
        reason = f"the profile is {length:.4g} nm long, allowed: {low:g} .. {high:g} nm"
        raise DataError(reason, points.last)
    x, z = points.x - points.x.mean(), points.z - points.z.mean()
    rms, most = float((z - x * (x @ z) / (x @ x)).std()), 0.1 * points.length
    if not LOWEST <= rms <= most:
        allowed = f"allowed: {LOWEST:g} .. {most:.4g} nm, a tenth of the length"
        raise DataError(f"the heights have an rms of {rms:.3g} nm, {allowed}; check the units of x and z", points.last)


def _reject_few(points):
    if points.x.size < FEWEST_POINTS:
        raise DataError(f"only {counted(points.x.size, 'point')}, at least {FEWEST_POINTS} are needed", points.last)


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
    if points.length <= LONG:
        return points, []
    spacing = points.length / MOST_POINTS
    enough = 2 * FEWEST_POINTS * points.length / points.x.size
    used, notes = _middle(points, min(max(PART, enough), LONG))
    why = f"all of it would give nodes at least {spacing:.3g} nm apart, which is the lattice period"
    return used, [f"{notes[0].rstrip('.')}: {why}; choose another by part."]


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


def _period(points, periodic):
    """The length of the period that the points are, nm; None where they are none."""
    _, x, z = points
    spacing = points.length / (x.size - 1)
    even = np.ptp(np.diff(x)) <= EVEN * spacing
    step, height = abs(float(z[-1] - z[0])), float(np.ptp(z))
    repeats = step <= SAME * height
    if periodic:
        if not (repeats or even):
            reason = f"its ends differ by {step:.4g} nm, and its points are not at equal distances"
            raise DataError(f"{reason}; a period needs one of both; repeat the first point, or use periodic=False")
        return points.length if repeats else points.length + spacing
    if periodic is not None or not even or not height:
        return None
    around = np.append(z[:-1], z[:2]) if repeats else np.append(z, z[:2])
    bends = np.abs(np.diff(around, 2))
    smooth = bends.max() <= SMOOTH * height  # else ends that differ may meet by chance
    if not (repeats or smooth) or bends[-2:].max() > 2.0 * bends[:-2].max():
        return None
    return points.length if repeats else points.length + spacing


def _closed(points, period):
    """Points of one period, whose last one repeats the first."""
    line, x, z = points
    if period > points.length:
        return Points(np.append(line, line[-1]), np.append(x, x[0] + period), np.append(z, z[0]))
    return points


def _levelled(points):
    """(Points with heights above the mean line of least squares, note); rejects slopes that are not small."""
    x, z = points.x - points.x.mean(), points.z - points.z.mean()
    tilt = float(np.sum(x * z) / np.sum(x**2))
    if abs(tilt) > STEEPEST:
        reason = f"the profile as a whole is tilted by {tilt:.3g}, allowed: up to {STEEPEST:g}; level it first"
        raise DataError(reason, points.last)
    levelled = points._replace(z=z - tilt * x)
    _reject_steep(levelled)
    return levelled, f"A tilt of {tilt:.3g} was removed (line of least squares)."


def _even(points):
    """(spacing, z (n,)) of Points at equal distances: themselves, or interpolated linearly."""
    count = points.x.size - 1
    spacing = points.length / count
    return spacing, np.interp(np.arange(count + 1) * spacing, points.x - points.x[0], points.z)


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


def _enough(points, periodic=False):
    """A cut-off, nm, that makes slopes small; None if there is none."""
    spacing, z = _even(points)
    cut_off = least_cut_off(z[:-1] if periodic else z, spacing, STEEPEST, periodic)
    return cut_off and float(f"{1.1 * cut_off:.2g}")


def _reject_steep(points, periodic=False, why=""):
    """Raises SteepError at the first slope beyond STEEPEST; why: what made it, where a cut-off does not help."""
    slopes = np.abs(np.diff(points.z) / np.diff(points.x))
    if slopes.max() > STEEPEST:
        k = int(np.argmax(slopes > STEEPEST))
        cut_off = None if why else _enough(points, periodic)
        remedy = "cut it where its ends are of one height" if why else "rescale it"
        remedy = f"smooth it by cut_off={cut_off:g} (nm), or {remedy}" if cut_off else remedy
        reason = f"{why}slope {slopes[k]:.3g} from the point before, allowed: up to {STEEPEST:g}; {remedy}"
        raise SteepError(reason, int(points.line[k + 1]), cut_off)


def _joined(points):
    """(Points with ends of one height, note): the step is spread over 5 % of the length at each end, as a cosine."""
    _, x, z = points
    step, reach = float(z[-1] - z[0]), 0.05 * points.length
    steepest = np.pi * abs(step) / (4.0 * reach)
    if steepest > STEEPEST:
        raise DataError(
            f"its ends differ by {abs(step):.4g} nm; joined over {reach:.4g} nm at each end this is a slope of"
            f" {steepest:.3g}, allowed: up to {STEEPEST:g}; cut it where its ends are of one height"
        )
    start, end = (np.clip(distance / reach, 0.0, 1.0) for distance in (x - x[0], x[-1] - x))
    joined = points._replace(z=z + 0.25 * step * (np.cos(np.pi * start) - np.cos(np.pi * end)))
    why = f"its ends, {abs(step):.4g} nm apart, joined over {reach:.4g} nm at each end: "
    _reject_steep(joined, why=why)
    return joined, f"The ends, {abs(step):.4g} nm apart, were joined over {reach:.4g} nm at each end (a cosine)."


def _at_equal_distances(points):
    """(heights (m,) of one period at equal distances, [note]), without the last point, the first of the next period."""
    _, x, z = points
    gaps = np.diff(x)
    even = np.ptp(gaps) <= EVEN * gaps.mean()
    count = gaps.size if even else 4 * gaps.size  # so the corners of the linear pieces stay
    if even and count <= MOST_POINTS:
        return z[:-1], []
    count = min(count, MOST_POINTS)
    resampled = f"{x.size} points were resampled to {count} at equal distances"
    if gaps.min() < points.length / count:
        return averaged(x, z, count), [f"{resampled}: means over the new spacing, where they lay closer."]
    spacing = points.length / count
    return np.interp(np.arange(count) * spacing, x - x[0], z), [f"{resampled}, linearly."]
