"""How the lines of a text are cut into cells, as most of them are rows of numbers."""

import csv
import re
from typing import NamedTuple

from ..surfaces import DataError

MOST_COLUMNS = 100
MISSING = ("", "Bad", "BAD", "bad", "***", "---", "--", "-", "nan", "NaN", "NAN")  # cells without a number
SAMPLE = 1000  # lines from the top, and as many from everywhere, that decide which separator there is
LONGEST = 8  # rows of a table that counts beside another one
# never goes back over a character
_NUMBER = r"[+\-\N{MINUS SIGN}]?(?:\d++,\d++|\d++\.?\d*+|[.,]\d++)(?:[eEdD][+\-\N{MINUS SIGN}]?\d++)?"
is_number = re.compile(rf"{_NUMBER}|[+-]?(?:nan|NaN|NAN|inf|Inf|INF)").fullmatch


class Layout(NamedTuple):
    """How a line is cut: separator ("" for blanks); and whether rows may have words among two numbers or more."""

    separator: str
    words: bool

    def split(self, line: str) -> list[str]:
        if self.separator and '"' in line:  # a separator in quotes is none
            cells = next(csv.reader([line], delimiter=self.separator, skipinitialspace=True))
        else:
            cells = line.split(self.separator or None)
        return [cell.strip(' \t"') for cell in cells]

    def width(self, line: str) -> int:
        """The number of cells of a line."""
        return line.count(self.separator) + 1 if self.separator and '"' not in line else len(self.split(line))

    def is_row(self, line: str) -> bool:
        cells = self.split(line)
        if self.words:
            return len(cells) > 2 and sum(map(bool, map(is_number, cells[:20]))) > 1
        return all(cell in MISSING or is_number(cell) for cell in cells)


LAYOUTS = [Layout(mark, False) for mark in (";", "\t", "", ",")]


def reject_wide(count: int, k: int) -> None:
    """Raises DataError for too many columns in the line of index k."""
    if count > MOST_COLUMNS:
        reason = f"{count} columns; allowed: up to {MOST_COLUMNS}; of a map of heights, save one line as x and z"
        raise DataError(reason, k + 1)


def layout_of(lines: list[str]) -> Layout | None:
    """The Layout with the most rows in a sample of lines; None for text without any."""
    full = [line for line in lines[: 4 * SAMPLE] if line] or [""]
    if len(full) > LONGEST and min(map(len, full[-LONGEST:])) > 2 * MOST_COLUMNS:  # before all of it is cut
        wide = next(k for k, line in enumerate(lines) if len(line) > 2 * MOST_COLUMNS)
        widths = [each.width(lines[wide]) for each in LAYOUTS if each.is_row(lines[wide])]
        reject_wide(max(widths, default=0), wide)
    sample = full[:SAMPLE] + lines[SAMPLE :: 1 + len(lines) // SAMPLE]

    def most(words):
        layouts = [each._replace(words=words) for each in LAYOUTS]
        hits = [sum(1 for line in sample if line and each.is_row(line)) for each in layouts]
        cut = [sum(len(each.split(line)) for line in full[-20:] if each.is_row(line)) for each in layouts]
        best = max(range(len(layouts)), key=lambda k: (hits[k], cut[k] if layouts[k].separator else 0))
        return hits[best], layouts[best]

    (plain, numeric), (wordy, mixed) = most(False), most(True)
    if max(plain, wordy) == 0 or not any(any(map(str.isdigit, line)) for line in sample):
        return None
    return mixed if wordy > 2 * plain + 1 else numeric
