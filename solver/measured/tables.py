"""Tables in text files: the block of numbers, its columns with names and units, and the lines above it."""

import re
from collections.abc import Sequence
from io import StringIO
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..surfaces import DataError
from ..text import counted
from .content import text_of
from .headings import heading_of, labelled
from .layout import LONGEST, MISSING, is_number, layout_of, reject_wide
from .lines import BOTH_SIGNS, MAYBE_THOUSANDS, cleaned, factors_in, missing_in

MOST_LINES, LONGEST_LINE = 1_000_000, 1_000_000  # so any text is read or refused within some seconds
SHOWN = 40  # characters of a cell in a message
FIRST = 5  # rows that a refusal shows
DECIMAL = re.compile(r"(?<!\d)0?,|,(?!\d{3}(?!\d))")  # a comma that separates no thousands
FORTRAN = re.compile(r"(\d\.?)[dD]([+-]?\d)")  # an exponent, as in 1.0D+00


class Column(NamedTuple):
    """name: as in the heading, "" without one; unit: as there, None for none; low, high: range, nan of words."""

    name: str
    unit: str | None
    low: float
    high: float


class Table(NamedTuple):
    """What a file shows: its columns, the cells of its first rows, the lines above them, and the number of rows."""

    columns: tuple[Column, ...]
    first: tuple[tuple[str, ...], ...]
    above: tuple[str, ...]
    rows: int

    def __str__(self) -> str:
        listed = [f"{k} {_shown(column)}" for k, column in enumerate(self.columns[:8], 1)]
        words = [line for line in self.above if re.search(r"[^\W\d_]", line)]
        named = any(column.name for column in self.columns) or not words
        beside = "" if named else f"; above them: {' '.join(words[-1].split())[: 3 * SHOWN]!r}"
        return f"columns: {'; '.join(listed)}{' ...' * (len(self.columns) > 8)}{beside}"

    def to_json(self) -> dict[str, Any]:
        """The same as JSON has it, with null for no unit and for the range of words; long lines and cells are cut."""
        ranges = [{"low": None, "high": None} if column.low != column.low else {} for column in self.columns]
        columns = [column._asdict() | own for column, own in zip(self.columns, ranges, strict=True)]
        first = [[cell[:SHOWN] for cell in row[: len(columns)]] for row in self.first]
        above = [line[: 2 * SHOWN] for line in self.above[-20:]]
        return {"columns": columns, "first": first, "above": above, "rows": self.rows}


class Block(NamedTuple):
    """A Table with its cells: a column each, of float64 (k,) or of words; lines (k,): their numbers in the file.

    kind: of the curve, where the format tells it.
    """

    table: Table
    cells: list[NDArray[Any]]
    lines: NDArray[np.int64]
    notes: tuple[str, ...]
    kind: str = ""

    def numbers(self, name: str, k: int) -> NDArray[np.float64]:
        """The k-th column; raises DataError, which calls it `name`, where it has words."""
        if self.cells[k].dtype == object:
            call = {"columns": {name: ...}}
            raise DataError(f"{name} = {self.cells[k][0][:SHOWN]!r} is not a number; choose another column", call=call)
        return self.cells[k]


def _shown(column):
    unit = "" if column.unit is None else f" ({column.unit[:SHOWN]})"
    name = repr(column.name[:SHOWN]) if column.name.isprintable() else "'?'"
    return f"{name}{unit} {column.low:.4g} .. {column.high:.4g}" if column.low == column.low else f"{name} of words"


def column_of(name: str, unit: str | None, cells: NDArray[Any]) -> Column:
    """The Column of some cells."""
    known = cells[np.isfinite(cells)] if cells.dtype != object else np.zeros(0)
    return Column(name, unit, *((float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)))


def table_in(content: str | bytes, needed: str, channel: str | int | None = None) -> Block:
    """Finds the table in the content of a file.

    Semicolons, tabs, commas or blanks separate columns; numbers may have decimal commas, except between commas. Blank
    lines and text after # are skipped. The heading is the line above the first row, and may have a row of units below.
    Parameters: content: of a file, as text or bytes. needed: what a file should have, for messages. channel: the number
    of a table, from 1 on, or "all", where there are several.
    Returns a Block. Raises DataError.
    """
    raw = _lines(text_of(content))
    lines, notes = cleaned(raw)
    layout = layout_of(lines)
    layout, parts = _parts(lines, layout, labelled(raw)) if layout else (layout, [])
    if not layout or not parts:
        raise DataError(f"no points; needed: {needed}", len(raw))
    chosen, later = _chosen(parts, channel)
    rows = np.concatenate([at for _, at in chosen])
    words = np.concatenate([np.full(at.size, segment, object) for segment, at in chosen])
    _reject_bad(lines, rows, layout)
    width, full = _full_rows(lines, rows, layout)
    others = [
        at for _, at in parts if all(at is not own for _, own in chosen) and channel in (None, "all") and not later
    ]
    apart = [at for at in others if layout.width(lines[at[0]]) == width]
    notes += later + _apart(np.sort(np.concatenate([rows[~full], *apart])))
    rows, words = rows[full], words[full]
    cells = _cells([lines[k] for k in rows], layout, width, rows)
    above = tuple(line for line in raw[: rows[0]] if line.strip())
    notes += (*_without_markers(cells, above), *factors_in(above))
    filled = max((k for k in range(width) if cells[k].dtype == object or np.isfinite(cells[k]).any()), default=0) + 1
    units, names = heading_of(above, layout.separator, (filled, width))
    _reject_other_columns(raw, chosen, layout, (units, names), (filled, width))
    kept = [k for k in range(width) if names[k] or k < filled]
    columns, cells = [column_of(names[k], units[k], cells[k]) for k in kept], [cells[k] for k in kept]
    if len(chosen) > 1 and all(segment for segment, _ in chosen):
        columns, cells = [*columns, column_of("segment", None, words)], [*cells, words]
    first = tuple(tuple(layout.split(lines[k]))[:width] for k in rows[:FIRST])
    return Block(Table(tuple(columns), first, above, rows.size), cells, rows + 1, notes)


def _apart(rows):
    """(a note on rows (k,) of numbers that are not of the table)."""
    at = ", ".join(str(k + 1) for k in rows[:3]) + " ..." * (rows.size > 3)
    return (f"{counted(rows.size, 'row')} apart from the table left out (line {at}).",) * bool(rows.size)


def _without_markers(cells, above):
    """[notes] on numbers that stand for a missing value in the columns `cells`, where they become nan."""
    notes = []
    for marker in missing_in(above):
        hits = [column == marker if column.dtype != object else np.zeros(column.size, bool) for column in cells]
        cells[:] = [
            np.where(at, np.nan, column) if at.any() else column for column, at in zip(cells, hits, strict=True)
        ]
        if count := int(np.sum(hits)):
            notes.append(f"{counted(count, 'cell')} of {marker:g} missing, as the file says.")
    return notes


def _reject_other_columns(raw, chosen, layout, heading, sizes):
    """Raises DataError where one of several tables that are read as one has another heading (units, names)."""
    for k, ((_, before), (_, at)) in enumerate(pairwise(chosen), 2):
        between = tuple(line for line in raw[before[-1] + 1 : at[0]] if line.strip())
        own = heading_of(between, layout.separator, sizes)
        if any(own[1]) and own != heading:
            columns = ", ".join(f"{name} ({unit})" if unit else name for unit, name in zip(*own, strict=True))
            first = (
                f"table {k}, from line {at[0] + 1}, has other columns or units than the first: {columns[: 3 * SHOWN]}"
            )
            raise DataError(f"{first}; read one table after the other", call={"channel": ...})


def _lines(text):
    """The lines of a text; raises DataError for too many or too long ones."""
    count = text.count("\n") + 1
    lines = text.split("\n") if count <= MOST_LINES else []
    if not lines or max(map(len, lines)) > LONGEST_LINE:
        most = f"up to {MOST_LINES} of {LONGEST_LINE} characters"
        raise DataError(f"{count} lines of {len(text)} characters; allowed: {most}; thin it out")
    return lines


def _parts(lines, layout, segments):
    """(Layout, [(the segment that a line above names, or "", indices of rows)] of tables).

    segments: {index of a line: the segment that it names}.
    """
    row = np.fromiter((bool(line) and layout.is_row(line) for line in lines), bool, len(lines))
    breaks = [k for k, line in enumerate(lines) if (line and not row[k]) or k in segments]
    rows = np.flatnonzero(row)
    parts = []
    for at in np.split(rows, np.flatnonzero(np.diff(np.searchsorted(breaks, rows))) + 1):
        # a table does not begin or end with dashes or separators alone
        ends = [next((j for j, k in enumerate(way) if re.search(r"\d", lines[k])), at.size) for way in (at, at[::-1])]
        if sum(ends) < at.size:
            parts.append(at[ends[0] : at.size - ends[1]])
    if not parts:
        return layout, []
    k = parts[0][0]
    beside, above = layout._replace(words=True), lines[k - 1]
    if k and beside != layout and beside.is_row(above) and layout.width(above) == layout.width(lines[k]):
        return _parts(lines, beside, segments)  # some oscilloscopes write words beside the first rows
    return layout, [(next((segments[k] for k in reversed(segments) if k < at[0]), ""), at) for at in parts]


def _chosen(parts, channel):
    """([parts] that are read, (a note on what is left out)); several are one where each names its segment."""
    long = [part for part in parts if part[1].size >= LONGEST] or [max(parts, key=lambda part: part[1].size)]
    together = len(long) > 1 and all(segment for segment, _ in long)
    if channel == "all":
        return long, ()
    if channel is not None or (len(long) > 1 and not together):
        k = index_of([f"from line {at[0] + 1}" for _, at in long], channel, f"{len(long)} tables", ["all"])
        return long[k : k + 1], ()
    later = [at for _, at in parts if at[0] > long[-1][1][0] and at.size > 1]
    return long, tuple(f"line {at[0] + 1} begins another table: left out." for at in later[:1])


def _reject_bad(lines, rows, layout):
    """Raises DataError for a line that a cell keeps from being a row of the table."""
    for k in (int(rows[-1]) + 1, int(rows[0]) - 1):
        near = lines[k] if 0 <= k < len(lines) else ""
        cells = layout.split(near)
        before = k > rows[0] or (k and layout.is_row(lines[k - 1]) and lines[k - 1])
        if not near or not before or len(cells) != len(layout.split(lines[rows[0]])):
            continue
        bad = [cell for cell in cells if not is_number(cell) and cell not in MISSING]
        if bad and any(map(is_number, cells)):
            cell = repr(bad[0][:SHOWN]) if bad[0].isprintable() else "an unreadable cell"
            raise DataError(f"{cell} is not a number; correct or delete the line", k + 1)


def _full_rows(lines, rows, layout):
    """(the number of columns, which of the rows (k,) count). Raises DataError for a row with more cells.

    Above the first full one none do; between blanks nobody knows which cell a shorter one lacks.
    """
    counts = np.fromiter((layout.width(lines[k]) for k in rows), int, rows.size)
    width = int(np.bincount(counts[: 2 * LONGEST]).argmax())
    reject_wide(int(counts.max()), int(rows[counts.argmax()]))
    full = np.arange(rows.size) >= np.argmax(counts == width)
    if (wider := np.flatnonzero(full & (counts > width))).size:
        remedy = "use decimal points, or semicolons between columns"
        raise DataError(f"{counts[full].max()} columns in place of {width}; {remedy}", int(rows[wider[0]]) + 1)
    return width, full if layout.separator else full & (counts == width)


def _cells(texts, layout, width, rows):
    """The columns of rows: float64 (k,) each, or words."""
    from pandas import read_csv, to_numeric  # takes longer to import than the solver

    if layout.separator and any('"' in line for line in texts):
        texts = [layout.separator.join(cell.replace(layout.separator, " ") for cell in layout.split(line))
                 if '"' in line else line for line in texts]  # fmt: skip
    text = "\n".join(texts).replace("\N{MINUS SIGN}", "-").replace('"', "")
    if "D" in text or "d" in text:
        text = FORTRAN.sub(r"\1e\2", text)
    commas, words = layout.separator != "," and "," in text, layout.words
    if commas and not words and ("." in text or not DECIMAL.search(text)):
        line = int(rows[next(k for k, line in enumerate(texts) if "," in line)]) + 1
        raise DataError(BOTH_SIGNS if "." in text else MAYBE_THOUSANDS, line)
    frame = read_csv(
        StringIO(text), sep=layout.separator or r"\s+", header=None, names=range(width), index_col=False,
        decimal="," if commas else ".", na_values=MISSING, keep_default_na=False, skip_blank_lines=False, quoting=3,
        skipinitialspace=True, low_memory=False, dtype=str if words else None,
    )  # fmt: skip
    cells = []
    for k in frame:
        column = frame[k]
        if words or column.dtype == object or column.dtype == "str":
            own = column.fillna("").astype(str).str.strip(' \t"')
            numbers = to_numeric(own.str.replace(",", ".") if commas else own, errors="coerce")
            known = int(numbers.notna().sum())
            # a column of which few cells are numbers is one of words, such as the stage of a run
            column = numbers if known and 2 * known >= own.ne("").sum() else own.astype(object)
        cells.append(column.to_numpy(object if column.dtype == object else np.float64))
    return cells


def index_of(names: Sequence[str], channel: str | int | None, what: str, others: Sequence[str] = ()) -> int:
    """The index of the channel that is asked for, by its name or number from 1 on; of several one must be.

    others: further words that a caller takes.
    """
    shown = ", ".join([f"{k} {name!r}" for k, name in enumerate(names[:12], 1)] + [repr(other) for other in others])
    if channel is None and len(names) > 1:
        choices = {f"{k}": name for k, name in enumerate(names, 1)} | {other: other for other in others}
        raise DataError(f"{what}: {shown}", call={"channel": ...}, choices=choices)
    wanted = 1 if channel is None else channel
    at = names.index(wanted) if wanted in names else int(wanted) - 1 if str(wanted).isdigit() else -1
    if not 0 <= at < len(names):
        raise DataError(f"channel = {channel!r}: allowed: {shown}; give one of these")
    return at


def left_out(lines: NDArray[np.int64]) -> list[str]:
    """[a note on incomplete rows in these lines (k,) of the file]."""
    at = ", ".join(map(str, lines[:3].tolist())) + " ..." * (lines.size > 3)
    return [f"{counted(lines.size, 'row')} without all numbers left out (line {at})."] * bool(lines.size)
