"""Reads a measured profile, x and z in nm, and makes it periodic; reports what it did and what it rejects."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from io import StringIO
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene import LIMITS
from ..surfaces import EVEN, FEWEST_POINTS, LENGTHS, PERIOD, STEEPEST, DataError, Profile, averaged
from ..text import counted
from .columns import Given, asked, checked, for_user, given, not_used, plain, recognised
from .force_curves import is_force_curve
from .instruments import is_instruments, read_line
from .smoothing import least_cut_off, smoothed
from .tables import SHOWN, Block, Source, content_of, listed, read_table
from .units import ALLOWED, agreed, factor, is_unit, mentioned, units_above
from .units import LENGTHS as NM

LONG = 20_000.0  # nm: a longer profile has nodes too far apart at any number of nodes that is computed soon
PART = 2_000.0  # nm
LONGEST_GAP = 5  # rows in a row without both numbers
LOWEST = 0.01  # nm, rms of heights: no instrument measures less
SAME = 1e-6  # of peak to valley: ends that differ by less are one point, printed twice
SMOOTH = 0.2  # of peak to valley: largest second difference of a profile whose period shows; 15 points a wave have 0.09
MOST_POINTS = int(LIMITS["nodes"].high)  # kept; there are never more nodes
NEEDED = "two columns: x, z in nm"
COUNTED = 'take none for x: its unit is then the distance of the rows, as "2.5 nm"'
NAMED = {  # names of columns in small letters without blanks and signs
    "x": ("x", "distance", "lateral", "length", "position", "xposition", "lateralposition", "scanposition"),
    "z": ("z", "height", "raw", "profile", "zheight", "profileheight", "rawheight"),
    "y": ("y",),
}


class How(NamedTuple):
    """Arguments of `read_profile` that say how a file is read, not what is made of it."""

    unit: str | None = None
    units: Mapping[str, str] = MappingProxyType({})
    columns: Given = MappingProxyType({})
    line: str | None = None
    channel: str | int | None = None


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
    """A profile as measured: x and z (n,) in nm."""

    x: NDArray[np.float64]
    z: NDArray[np.float64]


class SteepError(DataError):
    """Slopes that are not small; cut_off: a wavelength, nm, of a filter that suffices, or None for none."""

    cut_off: float | None = None


def read_trace(source: Source | Block, **how: Any) -> Trace:
    """Reads the points of a profile as `read_profile` does, without changing any, to be looked at; raises DataError.

    how: `unit`, `units`, `columns`, `line` and `channel` of `read_profile`.
    """
    points, _, _ = _points(source, How(**how))
    return Trace(points.x, points.z)


def read_profile(
    source: Source | Block,
    width: float | None = None,
    periodic: bool | None = None,
    unit: str | None = None,
    part: tuple[float, float] | None = None,
    line: str | None = None,
    cut_off: float | None = None,
    columns: Given | None = None,
    units: Mapping[str, str] | None = None,
    channel: str | int | None = None,
) -> Profile:
    """Reads a measured profile from a table of x and z, or from the file of an instrument.

    Parameters: source: a path, or the content of a file: text with line breaks, bytes, or an open file; or a Block of
    `read_table`.
    columns: {"x": ..., "z": ...}, each the name of a column or its number from 1 on, where names do not tell; x is None
    for rows at equal distances. units: {"x": "um", "z": "nm"}, also "0.5 um", which is the distance of rows that are
    counted; unit: one for both. The file's own units need none.
    width: use only the middle part of this width, nm. part: use only that from .. to, nm from the first point. Of more
    than LONG the middle PART is used, unless width or part is given.
    periodic: whether the points are one period, with or without its first point repeated at the end; by default that is
    so where the ends meet in height and slope. line: "row 12" or "column 12" of a map of heights; by default the row
    through its highest point. channel: the name or number of one of several channels or tables.
    cut_off: wavelength, nm, below which a Gaussian filter removes roughness; nothing is smoothed without it.
    Returns a Profile with points at equal distances. Of one period all heights are kept. Of another profile the mean
    line is removed, and the ends are joined.
    Raises DataError; where an argument is missing, it shows the table and the call that reads the file.

    Example: `profile = read_profile("profile.csv")`, then
    `Scene(surface="measured", measured=profile, width=profile.length)`
    """
    how = How(unit, units or {}, columns or {}, line, channel)
    options = {"width": width, "periodic": periodic, "part": part, "cut_off": cut_off} | how._asdict()
    try:
        points, notes, marked = _points(source, how)
        periodic = marked or None if periodic is None and width is None else periodic
        points, cut = _cut(points, width, part)
        try:
            return _made(points, periodic, width, cut_off, [*notes, *cut])
        except SteepError as error:
            raise _with_cut_off(error, points, periodic, width) from None
    except DataError as error:
        raise for_user(error, "read_profile(", source, options) from None


def _made(points, periodic, width, cut_off, notes):
    """The Profile of Points; raises DataError."""
    _reject_few(points)
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
        try:
            _made(points, periodic, width, cut_off, [])
        except DataError:
            continue
        error.cut_off, error.call = cut_off, {"cut_off": cut_off}
        error.reason += f"; a cut-off of {cut_off:g} nm makes it flat enough, or rescale it"
        return error
    error.reason += "; no cut-off makes it flat enough: rescale it, or cut it where its ends are of one height"
    return error


def _points(source, how):
    """(Points, [notes], whether the file calls them one period) of the rows that hold data."""
    if isinstance(source, Block):
        return _of_table(source, how)
    content = content_of(source)
    raw = content.replace("\0", "?").encode(errors="replace") if isinstance(content, str) else content
    if is_force_curve(raw):
        raise DataError("this is a force curve, no surface; read it as a curve, by read_measurement")
    if is_instruments(raw):
        return _of_instrument(raw, how)
    if how.line is not None:
        raise DataError(f"line = {how.line!r}: allowed with a map of heights only; leave it out")
    # without a line break, a text would be a path
    return _of_table(read_table(content if isinstance(content, bytes) else StringIO(content), NEEDED, how.channel), how)


def _of_table(block, how):
    """As `_points`, of a Block."""
    x_z = _x_and_z(block.table, how)
    sizes, read = _units(block.table, x_z, how)
    numbers = {role: np.arange(block.table.rows) if k is None else block.numbers(role, k) for role, k in x_z.items()}
    x, z = (numbers[role] * sizes[role] for role in "xz")
    lines, x, z, left_out = _complete(block.lines, x, z)
    for name, values in (("x", x), ("z", z)):
        large = np.flatnonzero(np.abs(values) > 1e9)  # a metre: the unit is wrong
        if large.size:
            reason = f"{name} = {values[large[0]]:g} nm: allowed: -1e+09 .. 1e+09 nm; check its unit"
            raise DataError(reason, int(lines[large[0]]))
    points = Points(lines, x, z)
    _reject_few(points)
    spare = not_used(block, list(x_z.values()))
    notes = [f"{lines.size} points; {read}; summits of z face the substrate.", *spare, *left_out, *block.notes]
    return points, notes, any(PERIOD in line for line in block.table.above)


def _x_and_z(table, how):
    """{"x", "z": index}, by name or as given; x is None for rows at equal distances. Raises DataError."""
    own = given(table, how.columns, "xz")
    checked("units", how.units, "xz")
    known, several = recognised(table, NAMED)
    unnamed = not any(column.name for column in table.columns)
    if len(table.columns) == 2 and unnamed:
        known = {"x": 0, "z": 1}
    rest = [column for column in table.columns if plain(column.name) not in ("x", "y")]
    if "z" not in {*known, *several} and not any(any(map(str.isalpha, column.unit or "")) for column in rest):
        known |= {"z": known["y"]} if "y" in known else {}  # of x, y and a quantity it is another coordinate
    of = {role: known[role] for role in "xz" if role in known} | own
    if len(table.columns) == 1 and "x" not in own:
        raise _asked(table, f"one column; needed: {NEEDED}, or {COUNTED}", {"x": None, "z": 0}, how)
    if len(of) < 2 or of["x"] == of["z"] or of["z"] is None:
        matrix = f"; if this is a map of heights, save one line of it as x and z, or {COUNTED}"
        unclear = [role for role in "xz" if role not in of] or ["z"]
        reason = f"which column is {' and which '.join(unclear)} is not certain"
        of = {role: k for role, k in of.items() if role not in unclear}
        raise _asked(table, reason + matrix * (len(table.columns) > 2 and unnamed), of, how)
    return of


def _file_units(table, of):
    """{"x", "z": unit or None} of two columns, in the heading and in lines above; two that differ are one unknown."""
    above, units = units_above(table.above), dict.fromkeys("xz")
    for role in (role for role in "xz" if of.get(role, role) is not None):
        own = table.columns[of[role]].unit if role in of else None
        differs = is_unit(own) and role in above and factor(own) != factor(above[role])
        units[role] = f"{own} or {above[role]}" if differs else own or above.get(role)
    return units


def _given_units(of, how):
    """{"x", "z": unit} that arguments give; `unit` is none of rows that are counted."""
    alone = {role: how.unit for role in "xz" if how.unit is not None and of.get(role, role) is not None}
    return alone | dict(how.units)


def _asked(table, reason, of, how):
    """The DataError that asks for columns and units that are not known."""
    sure = {role: unit for role, unit in _file_units(table, of).items() if is_unit(unit)} | _given_units(of, how)
    return asked(table, reason, of, {"x": NM, "z": NM}, sure)


def _units(table, of, how):
    """({"x", "z": nm per unit} of two columns, how they are read). Raises DataError for an unknown one."""
    file, own, sizes, read = _file_units(table, of), _given_units(of, how), {}, []
    for role, unit in file.items():
        if role in own:
            sizes[role] = agreed(own[role], unit, name=f"units[{role!r}]" if role in how.units else "unit")
        elif is_unit(unit):
            sizes[role] = factor(unit)
        else:
            why = f"{role} in {unit[:SHOWN]!r}; allowed units: {ALLOWED}" if unit else f"{role} has no unit"
            raise _asked(table, why + ("" if unit else mentioned(table.above)), of, how)
        told = f", where the file says {unit[:SHOWN]}" if role in own and unit and not is_unit(unit) else ""
        read.append(f"{role} {'is read ' * (role == 'x')}as {own.get(role, unit)}{told}")
    return sizes, ", ".join(read)


def _complete(lines, x, z):
    """(lines, x, z, [notes]) of the rows with both numbers, ascending in x. Raises DataError."""
    complete = np.isfinite(x) & np.isfinite(z)
    reject_gaps(np.flatnonzero(complete), lines)
    missing, lines, x, z = lines[~complete].tolist(), lines[complete], x[complete], z[complete]
    notes = [f"{counted(len(missing), 'row')} without all numbers left out (line {listed(missing)})."] * bool(missing)
    steps = np.diff(x)
    if steps.size and np.all(steps < 0.0):
        lines, x, z, steps = lines[::-1], x[::-1], z[::-1], -steps[::-1]
        notes.append("x descends: the points are read in reverse order.")
    if (falls := np.flatnonzero(steps <= 0.0)).size:
        before, after = x[falls[0]], x[falls[0] + 1]
        remedy = "keep one line of each x" if after == before else "sort the lines by x"
        if after < before and falls.size > 1:
            remedy += ", if each x has one height: an overhang or a matrix of heights cannot be read"
        raise DataError(f"x = {after:g} after {before:g}; {remedy}", int(lines[falls[0] + 1]))
    return lines, x, z, notes


def reject_gaps(complete: NDArray[np.int64], lines: Sequence[int]) -> None:
    """Raises DataError where too many rows between two complete ones are not; complete: their indices (k,)."""
    gaps = np.diff(complete) - 1
    if gaps.max(initial=0) > LONGEST_GAP:
        k = int(np.argmax(gaps > LONGEST_GAP))
        reason = f"{gaps[k]} rows in a row without all numbers; allowed: up to {LONGEST_GAP}"
        raise DataError(f"{reason}; fill them, or keep one side of the gap", int(lines[complete[k] + 1]))


def _of_instrument(content, how):
    """As `_points`, of the file of an instrument."""
    if how.columns or how.units:
        raise DataError("columns and units belong to a table, and this is the file of an instrument; leave them out")
    x, z, note = read_line(content, how.unit, how.line, how.channel)
    known = np.flatnonzero(np.isfinite(z))
    reject_gaps(known, [0] * z.size)
    left = z.size - known.size
    missing = [f"{counted(left, 'missing point')} left out."] * bool(left)
    points = Points(np.zeros(known.size, int), x[known], z[known])  # there are no lines to name
    _reject_few(points)
    return points, [note, *missing], False


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
    apart = points.length / (points.x.size - 1)
    if (enough := 2 * FEWEST_POINTS * apart) > LONG:
        middle = 0.5 * points.length
        call = {"part": (round(max(0.0, middle - 0.5 * enough)), int(min(points.length, middle + 0.5 * enough)))}
        with suppress(SteepError):  # which names a cut-off once the part is given
            _made(_between(points, *call["part"]), None, None, None, [])
        why = f"its points are {apart:.4g} nm apart: {LONG:g} nm, the most that is taken by itself, hold too few"
        raise DataError(
            f"{why}; give a part, but the nodes are then as far apart, which is the lattice period", call=call
        )
    used, notes = _middle(points, max(PART, enough))
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


def _reject_steep(points, why=""):
    """Raises SteepError at the first slope beyond STEEPEST; why: what made it."""
    slopes = np.abs(np.diff(points.z) / np.diff(points.x))
    if slopes.max() > STEEPEST:
        k = int(np.argmax(slopes > STEEPEST))
        reason = f"{why}slope {slopes[k]:.3g} from the point before, allowed: up to {STEEPEST:g}"
        raise SteepError(reason, int(points.line[k + 1]))


def _joined(points):
    """(Points with ends of one height, note): the step is spread over 5 % of the length at each end, as a cosine."""
    _, x, z = points
    step, reach = float(z[-1] - z[0]), 0.05 * points.length
    steepest = np.pi * abs(step) / (4.0 * reach)
    if steepest > STEEPEST:
        raise SteepError(
            f"its ends differ by {abs(step):.4g} nm; joined over {reach:.4g} nm at each end this is a slope of"
            f" {steepest:.3g}, allowed: up to {STEEPEST:g}"
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
