"""Tables in text files, as instruments and spreadsheets write them: columns of numbers below lines of any text."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import NamedTuple
from unicodedata import normalize

import numpy as np
from numpy.typing import NDArray

MOST_BYTES = 10_000_000  # of a file: 16,384 points, more than any run has nodes, in lines of 600 characters
SHOWN = 40  # characters of a cell or a heading in a message
LISTED = 3  # lines that a note lists by their numbers
HEADING = re.compile(r"(\w+) ?(?:[\[(/] ?([^\])]{0,40}?) ?[\])]?)?")  # F, F (N/m), F [N/m], U_x/nm
# A column of a heading that separates columns by blanks. Units have a largest length, so that any text is read in time
BLANKS = re.compile(r"\w+(?:\s?[\[(][^\])]{0,40}[\])]|/\S{1,40})?")


class TableError(ValueError):
    """An unusable file; the message gives the reason and the number of the line, if there is one, as `line`."""

    def __init__(self, reason: str, line: int | None = None) -> None:
        self.line = line
        super().__init__(reason if line is None else f"line {line}: {reason}")


class Column(NamedTuple):
    """Of a heading: F (N/m), F [N/m] and F/N/m are the same; unit "" for none."""

    name: str
    unit: str


class Rows(NamedTuple):
    """Complete rows: the numbers of their lines (k,), {name: column (k,)}, and notes on rows that were left out."""

    lines: NDArray[np.int64]
    columns: dict[str, NDArray[np.float64]]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """The texts of a file: the columns of its heading, and rows of `width` cells, each with the number of its line."""

    columns: list[Column]
    width: int
    rows: list[tuple[int, list[str]]]
    error: type[TableError]

    def texts(self, name: str) -> list[str]:
        """The texts in the column of this name, one per row; none if there is no such column."""
        k = next((k for k, column in enumerate(self.columns) if column.name == name), None)
        return [] if k is None else [cells[k] for _, cells in self.rows]

    def where(self, name: str, text: str) -> "Table":
        """The rows with this text in the column of this name."""
        return replace(self, rows=[row for row, here in zip(self.rows, self.texts(name), strict=True) if here == text])

    def numbers(self, columns: Mapping[str, int]) -> Rows:
        """The rows with a finite number in each of the columns {name: index}, the first of which must ascend."""
        values = np.array([[self._number(name, *row, k) for name, k in columns.items()] for row in self.rows])
        values, lines = values.reshape(-1, len(columns)), np.array([line for line, _ in self.rows], int)
        complete = np.isfinite(values).all(axis=1)
        missing, values, lines = lines[~complete], values[complete], lines[complete]
        (name, *_), x = columns, values[:, 0]
        if (falls := np.flatnonzero(np.diff(x) <= 0.0)).size:
            k = int(falls[0])
            raise self.error(f"{name} = {x[k + 1]:g} after {x[k]:g}; sort the lines by {name}", int(lines[k + 1]))
        notes: tuple[str, ...] = ()
        if missing.size:
            listed = ", ".join(map(str, missing[:LISTED])) + (" ..." if missing.size > LISTED else "")
            count = f"{missing.size} row{'s' * (missing.size > 1)} without all numbers"
            notes = (f"{count} left out (line {listed}).",)
        return Rows(lines, dict(zip(columns, values.T, strict=True)), notes)

    def _number(self, name, line, cells, k):
        try:
            return float(cells[k] or "nan")
        except ValueError:
            cell = repr(cells[k][:SHOWN]) if cells[k].isprintable() else "an unreadable cell"
            raise self.error(f"{name} = {cell} is not a number; correct or delete the line", line) from None


def read_table(
    source: str | bytes | PathLike[str],
    error: type[TableError],
    needed: str,
    named: Callable[[set[str]], bool] | None = None,
) -> Table:
    """The Table in a file (os.PathLike), or in its content; raises `error`, with `needed` in its message.

    Semicolons, tabs, commas or blanks separate columns; with the first two, numbers may have decimal commas. Blank
    lines, text after # and lines above the heading are skipped. named: whether column names are those of the heading;
    by default the heading is the line above the first one of numbers, if there is any.
    """
    text = _text(source, error)
    stripped = ((number, line.partition("#")[0].strip()) for number, line in enumerate(text.split("\n"), start=1))
    lines = [(number, line) for number, line in stripped if line]
    if named is None:
        start = next((k for k, (_, line) in enumerate(lines) if _all_numbers(line)), len(lines))
    else:
        names = ({column.name for column in _columns(line)} for _, line in lines)
        start = next((k for k, line_names in enumerate(names, start=1) if named(line_names)), 0)
        if not start:
            number, line = lines[0] if lines else (1, "")
            heading = (line[:SHOWN] if line.isprintable() else "not readable") or "missing"
            raise error(f"heading {heading}; needed: {needed}", number)
    if not lines[start:]:
        raise error(f"no points; needed: {needed}", text.count("\n") + 1)
    columns, separator = _columns(lines[start - 1][1]) if start else [], _separator(lines[start][1])
    rows = [(number, _cells(line, separator)) for number, line in lines[start:]]
    width = len(rows[0][1]) if named is None else len(columns)
    for k, (number, cells) in enumerate(rows):
        if any(cells[width:]):
            remedy = "use decimal points, or semicolons between columns"
            raise error(f"{len(cells)} columns in place of {width}; {remedy}", number)
        if len(cells) != width:
            rows[k] = number, (cells + width * [""])[:width]
    return Table(columns, width, rows, error)


def _text(source, error):
    """The content as text; raises `error` where it is not text."""
    content = _content(Path(source), error) if isinstance(source, PathLike) else source
    if len(content) > MOST_BYTES:
        raise error(f"more than {MOST_BYTES / 1e6:g} MB; thin it out, fewer points are enough")
    if not isinstance(content, str):
        try:
            content = bytes(content).decode()
        except UnicodeDecodeError as failure:
            line = failure.object[: failure.start].count(b"\n") + 1
            raise error("not UTF-8 text; save it as CSV in UTF-8 or ASCII", line) from None
    content = content.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    if binary := re.search("[\0\ufffd]", content):
        raise error("not a text file; save it as CSV in UTF-8", content.count("\n", 0, binary.start()) + 1)
    return content


def _content(path, error):
    """The bytes of a file, at most one more than allowed."""
    if not path.is_file():  # a pipe or a device may never end
        raise error(f"{str(path)!r} is not a file; name a CSV file")
    try:
        with open(path, "rb") as file:
            return file.read(MOST_BYTES + 1)
    except OSError as failure:
        raise error(f"{str(path)!r}: {failure.strerror}; name a CSV file that can be read") from None


def _separator(line):
    return next((mark for mark in ";\t," if mark in line), None)


def _cells(line, separator):
    """The texts of a line, with decimal points and plain minus signs."""
    if separator != ",":
        line = line.replace(",", ".")
    return [cell.strip(' "').replace("\N{MINUS SIGN}", "-") for cell in line.split(separator)]


def _columns(line):
    """The Columns of a heading."""
    separator = _separator(line)
    cells = line.split(separator) if separator else BLANKS.findall(line)
    cells = [" ".join(cell.split()).strip(' "') for cell in cells]
    matches = ((cell, HEADING.fullmatch(cell)) for cell in cells)
    named = (match.groups() if match else (cell, "") for cell, match in matches)
    return [Column(name, _unit(unit or "")) for name, unit in named]


def _unit(text):
    """A unit with one sign for micro and one for Angstrom, each of which Unicode has twice."""
    return normalize("NFC", text).replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")


def _all_numbers(line):
    try:
        return bool([float(cell) for cell in _cells(line, _separator(line)) if cell])
    except ValueError:
        return False
