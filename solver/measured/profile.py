"""Reads a measured profile, x and z in nm, from a table or the file of an instrument."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..surfaces import PERIOD, DataError, Profile
from ..text import counted
from .columns import Given, asked, checked, for_user, given, not_used, recognised
from .content import Source, content_of
from .instruments import is_force_curve, is_instruments, read_line
from .periodic import Points, made_periodic, reject_few
from .tables import SHOWN, Block, Table, left_out, table_in
from .units import LENGTH, agreed, allowed_of, is_unit, measure, mentioned, units_above

LONGEST_GAP = 5  # rows in a row without both numbers
FARTHEST = 1e9  # nm: of a number beyond a metre the unit is wrong
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


def read_trace(source: Source | Block, **how: Any) -> Points:
    """Reads a profile as `read_profile` does, without changing any of its Points, to be looked at; raises DataError.

    how: `unit`, `units`, `columns`, `line` and `channel` of `read_profile`.
    """
    points = _points(source, How(**how))[0]
    reject_few(points)
    return points


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

    Parameters: source: a path, text with line breaks, bytes, an open file, or a Block.
    columns: {"x": ..., "z": ...}, each the name of a column or its number from 1 on, where names do not tell; x is None
    for rows at equal distances. units: {"x": "um", "z": "nm"}, also "0.5 um", which is the distance of rows that are
    counted; unit: one for both. The file's own units need none.
    width: use only the middle part of this width, nm. part: use only that from .. to, nm from the first point. Of more
    than 20 um the middle 2 um are used, unless width or part is given.
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
        if marked and periodic is not False and width is part is cut_off is None:
            return Profile(points.length, points.z[:-1], (*notes, "One period, as it was saved."))
        return made_periodic(points, periodic, width, part, cut_off, notes)
    except DataError as error:
        raise for_user(error, "read_profile(", source, options) from None


def _points(source, how):
    """(Points, [notes], whether they are one period that `Profile.to_csv` wrote) of the rows that hold data."""
    if isinstance(source, Block):
        return _of_table(source, how)
    content = content_of(source)
    if is_force_curve(content):
        raise DataError("this is a force curve, no surface; read it as a curve, by read_measurement")
    if is_instruments(content):
        return _of_instrument(content if isinstance(content, bytes) else content.encode(), how)
    if how.line is not None:
        raise DataError(f"line = {how.line!r}: allowed with a map of heights only; leave it out")
    return _of_table(table_in(content, NEEDED, how.channel), how)


def _of_instrument(content, how):
    """As `_points`, of the file of an instrument."""
    if how.columns or how.units:
        raise DataError("columns and units belong to a table, and this is the file of an instrument; leave them out")
    x, z, note = read_line(content, how.unit, how.line, how.channel)
    known = np.flatnonzero(np.isfinite(z))
    _reject_gaps(known, np.zeros(z.size, int))  # there are no lines to name
    missing = [f"{counted(z.size - known.size, 'missing point')} left out."] * (known.size < z.size)
    return Points(np.zeros(known.size, int), x[known], z[known]), [note, *missing], False


def _of_table(block, how):
    """As `_points`, of a Block."""
    table = block.table
    x_z = _x_and_z(table, how)
    sizes, read = _units(table, x_z, how)
    numbers = {role: np.arange(table.rows) if k is None else block.numbers(role, k) for role, k in x_z.items()}
    x, z = (numbers[role] * sizes[role] for role in "xz")
    lines, x, z, notes = _complete(block.lines, x, z)
    for name, values in (("x", x), ("z", z)):
        if (far := np.flatnonzero(np.abs(values) > FARTHEST)).size:
            allowed = f"allowed: {-FARTHEST:g} .. {FARTHEST:g} nm; check its unit"
            raise DataError(f"{name} = {values[far[0]]:g} nm: {allowed}", int(lines[far[0]]))
    first = f"{lines.size} points; {read}; summits of z face the substrate."
    notes = [first, *not_used(block, list(x_z.values())), *notes, *block.notes]
    points = Points(lines, x, z)
    marked = any(PERIOD in line for line in table.above) and x.size > 1
    return points, notes, marked and points.even and z[0] == z[-1]


def named(table: Table) -> dict[str, int]:
    """{"x", "z": index} of the columns that names tell; of two without names both."""
    if len(table.columns) == 2 and not any(column.name for column in table.columns):
        return {"x": 0, "z": 1}
    known, roles = recognised(table, NAMED)
    others = [column.unit or "" for column, role in zip(table.columns, roles, strict=True) if role not in ("x", "y")]
    if "y" in known and "z" not in roles and not any(map(str.isalpha, "".join(others))):
        known["z"] = known["y"]  # beside x, y and a quantity it is another coordinate
    return {role: known[role] for role in "xz" if role in known}


def _x_and_z(table, how):
    """{"x", "z": index}, by name or as given; x is None for rows at equal distances. Raises DataError."""
    own = given(table, how.columns, "xz")
    checked("units", how.units, "xz")
    of: dict[str, int | None] = named(table) | own
    if len(table.columns) == 1 and "x" not in own:
        said = mentioned(line for line in table.above if any(map(str.isdigit, line)))
        raise _asked(table, f"one column; needed: {NEEDED}, or {COUNTED}{said}", {"x": None, "z": 0}, how)
    if len(of) < 2 or of["x"] == of["z"] or of["z"] is None:
        unnamed = len(table.columns) > 2 and not any(column.name for column in table.columns)
        matrix = f"; if this is a map of heights, save one line of it as x and z, or {COUNTED}"
        unclear = [role for role in "xz" if role not in of] or ["z"]
        reason = f"which column is {' and which '.join(unclear)} is not certain"
        raise _asked(table, reason + matrix * unnamed, {role: of[role] for role in of if role not in unclear}, how)
    return of


def _units_of(table, of, how):
    """{"x", "z": (unit that the file names, or None; that of an argument, or None)}.

    The file's is in the heading or a line above: two that differ are one that is not known. Rows that are counted have
    none, and `unit` is not theirs.
    """
    above, found = units_above(table.above), {}
    for role in "xz":
        counted = of.get(role, role) is None
        own = table.columns[of[role]].unit if role in of and not counted else None
        other = None if counted else above.get(role)
        differs = is_unit(own) and other and measure(own) != measure(other)
        file = f"{own} or {other}" if differs else own or other
        found[role] = file, how.units.get(role, None if counted else how.unit)
    return found


def _asked(table, reason, of, how):
    """The DataError that asks for columns and units that are not known; a unit that is two is one of them."""
    known: dict[str, Any] = {}
    for role, (unit, wanted) in _units_of(table, of, how).items():
        if wanted or is_unit(unit) or " or " in f"{unit}":
            known[role] = wanted or (unit if is_unit(unit) else ...)
    return asked(table, reason, of, {"x": LENGTH, "z": LENGTH}, known)


def _units(table, of, how):
    """({"x", "z": nm per unit} of two columns, how they are read). Raises DataError for an unknown one."""
    sizes, read = {}, []
    for role, (unit, wanted) in _units_of(table, of, how).items():
        told = f", where the file says {unit[:SHOWN]}" if wanted and unit and not is_unit(unit) else ""
        read.append(f"{role} {'is read ' * (role == 'x')}as {wanted or unit}{told}")
        if role in how.units:
            sizes[role], _ = agreed(wanted, unit, name=f"units[{role!r}]")
        elif wanted:  # `unit` cannot say what 1 of one column is
            sizes[role], _ = agreed(wanted, unit, role=role)
        elif is_unit(unit):
            sizes[role], _ = measure(unit)
        elif unit:
            raise _asked(table, f"{role} in {unit[:SHOWN]!r}; allowed units: {allowed_of()}", of, how)
        else:
            raise _asked(table, f"{role} has no unit{mentioned(table.above)}", of, how)
    return sizes, ", ".join(read)


def _complete(lines, x, z):
    """(lines, x, z, [notes]) of the rows with both numbers, ascending in x. Raises DataError."""
    complete = np.isfinite(x) & np.isfinite(z)
    _reject_gaps(np.flatnonzero(complete), lines)
    notes, lines, x, z = left_out(lines[~complete]), lines[complete], x[complete], z[complete]
    if x.size > 1 and np.all(np.diff(x) < 0.0):
        lines, x, z = lines[::-1], x[::-1], z[::-1]
        notes.append("x descends: the points are read in reverse order.")
    if (falls := np.flatnonzero(np.diff(x) <= 0.0)).size:
        before, after = x[falls[0]], x[falls[0] + 1]
        remedy = "keep one line of each x" if after == before else "sort the lines by x"
        if after < before and falls.size > 1:
            remedy += ", if each x has one height: an overhang or a matrix of heights cannot be read"
        raise DataError(f"x = {after:g} after {before:g}; {remedy}", int(lines[falls[0] + 1]))
    return lines, x, z, notes


def _reject_gaps(complete, lines):
    """Raises DataError where too many rows between two complete ones are not; complete: their indices (k,)."""
    gaps = np.diff(complete) - 1
    if gaps.max(initial=0) > LONGEST_GAP:
        k = int(np.argmax(gaps > LONGEST_GAP))
        reason = f"{gaps[k]} rows in a row without all numbers; allowed: up to {LONGEST_GAP}"
        raise DataError(f"{reason}; fill them, or keep one side of the gap", int(lines[complete[k] + 1]))
