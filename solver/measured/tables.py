"""Tables in text files, as instruments and spreadsheets write them: a heading, and columns of numbers below it."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO
from unicodedata import normalize

import numpy as np
from numpy.typing import NDArray

from ..surfaces import DataError

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
Source = str | bytes | PathLike[str] | TextIO
MOST_BYTES = 10_000_000  # of a file: 16,384 points, more than any run has nodes, in lines of 600 characters
MISSING = ("", "Bad", "BAD", "bad", "***", "---", "--", "-")  # cells without a number
LONGEST_GAP = 5  # rows of a profile without all numbers
FORTRAN = r"(\d\.?)[dD]([+-]?\d)"  # an exponent, as in 1.0D+00
SHOWN = 40  # characters of a cell or a heading in a message
LISTED = 3  # lines or columns that a note lists
# F, Friction force, F (N/m), F [N/m], U_x/nm, U_x / nm. Every part has a largest length, so any text is read in time
NAME, UNIT = r"[^\W\d][\w.-]{0,40}", r"[\[(][^\])]{0,40}[\])]|/ ?\S{1,40}"
HEADING = re.compile(rf"({NAME}(?: {NAME}){{0,4}}) ?({UNIT})?")
BLANKS = re.compile(rf"{NAME}(?:\s?(?:{UNIT}|/\s?\S{{1,40}}))?")  # a column of a heading that blanks separate
RAISED = str.maketrans("⁻¹·*", "-1  ")


class Column(NamedTuple):
    """Of a heading: F (N/m), F [N/m] and F / N/m are the same; unit "" for none."""

    name: str
    unit: str


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of the heading of a file, and its cells: text, a row per line, whose number is the index."""

    columns: list[Column]
    cells: "pd.DataFrame"
    comma: bool  # whether commas separate the columns
    above: str = ""  # the lines above the first row, with comments
    end: int | None = None  # the line where another table begins

    def numbers(
        self, columns: Mapping[str, int], profile: bool = False
    ) -> tuple[NDArray[np.int64], dict[str, Floats], list[str]]:
        """(numbers of their lines (k,), {name: column (k,)}, [a note on others]) of rows that are complete.

        columns: {name: index}; they have a finite number in each of them. profile: the first must ascend or descend
        throughout, and at most LONGEST_GAP rows in a row may be incomplete.
        """
        values = np.column_stack([self._numbers(name, self.cells[k]) for name, k in columns.items()])
        complete, lines = np.isfinite(values).all(axis=1), self.cells.index.to_numpy()
        missing, values, lines = lines[~complete], values[complete], lines[complete]
        count = f"{missing.size} row{'s' * (missing.size > 1)} without all numbers"
        notes = [f"{count} left out (line {listed(missing.tolist())})."] if missing.size else []
        if profile:
            (name, *_), steps = columns, np.diff(values[:, 0])
            reject_gaps(np.flatnonzero(complete), self.cells.index)
            if steps.size and np.all(steps < 0.0):
                values, lines, steps = values[::-1], lines[::-1], -steps[::-1]
                notes.append(f"{name} descends: the points are read in reverse order.")
            if (falls := np.flatnonzero(steps <= 0.0)).size:
                before, x = values[falls[0] : falls[0] + 2, 0]
                remedy = f"keep one line of each {name}" if x == before else f"sort the lines by {name}"
                if x < before and falls.size > 1:
                    remedy += ", if each x has one height: an overhang or a matrix of heights cannot be read"
                raise DataError(f"{name} = {x:g} after {before:g}; {remedy}", int(lines[falls[0] + 1]))
        return lines, dict(zip(columns, values.T, strict=True)), notes

    def _numbers(self, name, texts):
        """A column of texts as float64; "" as nan."""
        from pandas import to_numeric

        texts = texts.where(~texts.isin(MISSING), "nan").str.replace(FORTRAN, r"\1e\2", regex=True)
        wrong = to_numeric(texts, errors="coerce").isna() & ~texts.str.lower().isin(["nan", "+nan", "-nan"])
        for line, text in texts[wrong].items():
            cell = repr(text[:SHOWN]) if text.isprintable() else "an unreadable cell"
            raise DataError(f"{name} = {cell} is not a number; correct or delete the line", line)
        return texts.astype(float)


def reject_gaps(complete: NDArray[np.int64], lines: Sequence[int]) -> None:
    """Raises DataError where too many rows between two complete ones are not; complete: their indices (k,)."""
    gaps = np.diff(complete) - 1
    if gaps.max(initial=0) > LONGEST_GAP:
        k = int(np.argmax(gaps > LONGEST_GAP))
        reason = f"{gaps[k]} rows in a row without all numbers; allowed: up to {LONGEST_GAP}"
        raise DataError(f"{reason}; fill them, or keep one side of the gap", int(lines[complete[k] + 1]))


def read_table(source: Source, needed: str, named: Callable[[list[Column]], bool] | None = None) -> Table:
    """Reads a Table from a file, or from its content; raises DataError, with `needed` in its message.

    source: a path, a text without a line break being one; the content as text or bytes; or an open file.
    Semicolons, tabs, commas or blanks separate columns; with the first two, numbers may have decimal commas. Blank
    lines, text after # and lines above the heading are skipped. named: whether a line is the heading, which may stand
    behind a # and have a row of units below it; another one ends the table. By default the heading is the line above
    the first one of numbers, if there is any.
    """
    from pandas import read_csv  # takes longer to import than the solver

    text = _text(source)
    stripped = ((number, line.partition("#")[0].strip()) for number, line in enumerate(text.split("\n"), start=1))
    lines = [(number, line) for number, line in stripped if line]
    columns, rows_below, end = _heading(lines, text, needed, named) if named else (*_above_numbers(lines), None)
    if not rows_below:
        raise DataError(f"no points; needed: {needed}", text.count("\n") + 1)
    separator = _separator(rows_below[0][1])
    numbers, rows = zip(*rows_below, strict=True)
    sizes = [len(row.split(separator)) for row in rows]
    width = sizes[0] if named is None else len(columns)
    if max(sizes) > 100:  # a table of some bytes with a million empty columns would fill the memory
        raise DataError(f"{max(sizes)} columns; allowed: up to 100", numbers[int(np.argmax(sizes))])
    cells = read_csv(
        StringIO("\n".join(rows)), sep=separator or r"\s+", header=None, names=range(max(width, *sizes, 1)), dtype=str,
        keep_default_na=False, quoting=3, skip_blank_lines=False, index_col=False,
    )  # fmt: skip
    cells.index = list(numbers)
    cells = cells.fillna("").apply(lambda texts: texts.str.strip(' "').str.replace("\N{MINUS SIGN}", "-"))
    if separator != ",":
        cells = cells.apply(lambda texts: texts.str.replace(",", "."))
    longer = cells.loc[:, width:].ne("").any(axis=1)
    if longer.any():
        line = longer.idxmax()
        remedy = "use decimal points, or semicolons between columns"
        raise DataError(f"{sizes[numbers.index(line)]} columns in place of {width}; {remedy}", line)
    above = "\n".join(text.split("\n")[: numbers[0] - 1])
    return Table(columns, cells.loc[:, : width - 1], separator == ",", above, end)


def listed(items: Sequence) -> str:
    """The first LISTED of some items, as text."""
    return ", ".join(map(str, items[:LISTED])) + " ..." * (len(items) > LISTED)


def _above_numbers(lines):
    """(Columns of the line above the first one of numbers, that line and all below)."""
    first = next((k for k, (_, line) in enumerate(lines) if _all_numbers(line)), len(lines))
    # a number alone above rows of several is their count
    sizes = [len(line.split(_separator(line))) for _, line in lines[first : first + 2]]
    first += len(sizes) == 2 and sizes[0] == 1 < sizes[1] and _all_numbers(lines[first + 1][1])
    return _columns(lines[first - 1][1]) if first else [], lines[first:]


def _heading(lines, text, needed, named):
    """(Columns of the first heading that `named` knows, the lines of its table, the line of another one or None)."""
    behind = ((number, line.lstrip("# ")) for number, line in enumerate(text.split("\n"), 1) if line.startswith("#"))
    found = next(((number, line) for number, line in (*lines, *behind) if named(_columns(line))), None)
    if found is None:
        number, line = lines[0] if lines else (1, "")
        heading = (line[:SHOWN] if line.isprintable() else "not readable") or "missing"
        raise DataError(f"heading {heading}; needed: {needed}", number)
    columns, below = _columns(found[1]), [each for each in lines if each[0] > found[0]]
    if below and not re.search(r"\d", below[0][1]):  # a row of units
        units = [_unit(unit.strip(' "[]()')) for unit in below[0][1].split(_separator(below[0][1]))]
        if len(units) >= len(columns) > 1:
            columns = [Column(name, unit or own) for (name, unit), own in zip(columns, units, strict=False)]
            below = below[1:]
    end = next((k for k, (_, line) in enumerate(below) if line == found[1]), None)
    if end is None:
        return columns, below, None
    rows = end
    while rows and not _all_numbers(below[rows - 1][1]):  # the lines above another table
        rows -= 1
    return columns, below[:rows], below[end][0]


def content_of(source: Source) -> str | bytes:
    """The content of a file, a path, or the content itself; raises DataError, also for more than MOST_BYTES."""
    if isinstance(source, PathLike) or (isinstance(source, str) and not re.search("[\r\n]", source)):
        content = _content(source)
    else:
        content = source if isinstance(source, (str, bytes)) else source.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise DataError(f"more than {MOST_BYTES / 1e6:g} MB; thin it out, fewer points are enough")
    return content


def _text(source):
    """The content as text, with plain line breaks; raises DataError where it is not text."""
    content = content_of(source)
    if not isinstance(content, str):
        raw = bytes(content)
        try:
            content = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8")
        except UnicodeDecodeError:  # of an older instrument: in Latin-1 every byte is a character
            content = bytes(content).decode("latin-1")
    content = content.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    if binary := re.search("[\0\ufffd]", content):
        raise DataError("not a text file; save it as CSV in UTF-8", content.count("\n", 0, binary.start()) + 1)
    return content


def _content(path):
    """The bytes of a file, at most one more than allowed."""
    shown = repr(str(path)[: 3 * SHOWN])
    try:
        if not Path(path).is_file():  # a pipe or a device may never end
            raise DataError(f"{shown} is not a file; name a CSV file, or give its lines")
        with open(path, "rb") as file:
            return file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as failure:  # ValueError: a null character in the name
        if isinstance(failure, DataError):
            raise
        reason = getattr(failure, "strerror", None) or failure
        raise DataError(f"{shown}: {reason}; name a CSV file that can be read") from None


def _separator(line):
    return next((mark for mark in ";\t," if mark in line), None)


def _columns(line):
    """The Columns of a heading."""
    separator = _separator(line)
    cells = line.split(separator) if separator else BLANKS.findall(line)
    cells = [" ".join(cell.split()).strip(' "') for cell in cells]
    matches = ((cell, HEADING.fullmatch(cell)) for cell in cells)
    named = (match.groups() if match else (cell, "") for cell, match in matches)
    return [Column(name, _unit((unit or "").strip("[]()/ "))) for name, unit in named]


def _unit(text):
    """A unit with one sign for micro and one for Angstrom, each of which Unicode has twice; N m^-1 as N/m."""
    text = normalize("NFC", text).replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}").translate(RAISED)
    return re.sub(r"^(\w+) +(\w+) ?\^?-1$", r"\1/\2", text)


def _all_numbers(line):
    separator = _separator(line)
    line = line if separator == "," else line.replace(",", ".")
    try:
        cells = (cell.strip(' "').replace("\N{MINUS SIGN}", "-") for cell in line.split(separator))
        return bool([float(re.sub(FORTRAN, r"\1e\2", cell)) for cell in cells if cell not in MISSING])
    except ValueError:
        return False
