"""The lines of a text before they are cut into cells: without comments, and with one way to write a number."""

import re
from collections.abc import Sequence

from ..surfaces import DataError

COMMENT = re.compile(r"(?:^|(?<=[\s;,]))#.*")  # one begins a line, or follows a blank or a separator
NO_NUMBER = re.compile(r"[+-]?\d\.?#(?:IND|QNAN|SNAN|INF)\d*", re.I)  # as Windows wrote what is none
QUOTED = re.compile(r'"\s*([+-]?[\d.]*\d,[\d.,]*(?:[eE][+-]?\d+)?)\s*"')  # a number with a comma
PLAIN = re.compile(r'"([+-]?[\d.]+(?:[eE][+-]?\d+)?)"')
THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+(?:\.\d*)?")
MARKER = re.compile(
    r"(?:missing|no[ _-]?data|undefined|invalid)(?:[ _-]?(?:values?|data|points?|marker))?\s{0,8}[:=]?\s{0,8}"
    r"([+-]?\d[\d.]{0,20})\s{0,8}$",
    re.I,
)
FACTOR = re.compile(r"(?:factor|scal(?:e|ing)|multiplier|gain|sensitivity)\b\D{0,30}\d", re.I)
LONGEST_SAID = 40  # characters of a line in a note
BOTH_SIGNS = "decimal points and commas; write one sign, without separators of thousands"
MAYBE_THOUSANDS = "commas with three digits behind each may separate thousands; write decimal points"


def cleaned(raw: Sequence[str]) -> tuple[list[str], tuple[str, ...]]:
    """(the lines without comments and without commas in quoted numbers, notes).

    Raises DataError where such a comma may be either decimal or of thousands.
    """
    lines = [COMMENT.sub("", NO_NUMBER.sub("nan", line)) if "#" in line else line for line in raw]
    lines, notes = _unquoted([line.strip(" \r\f\v") for line in lines])
    return [PLAIN.sub(r"\1", line) if '"' in line else line for line in lines], notes


def _unquoted(lines):
    """(lines with quoted numbers that have a comma written with a point and no quotes, (a note))."""
    found = [(k, number) for k, line in enumerate(lines) if '"' in line for number in QUOTED.findall(line)]
    if not found:
        return lines, ()
    apart = [bool(THOUSANDS.fullmatch(number)) for _, number in found]
    pointed = any("." in number for _, number in found)
    if all(apart) and (pointed or any("." in lines[k] for k, _ in found)):
        mark, notes = "", ("Commas in quotes separate thousands.",)
    elif pointed or all(apart) or any(number.count(",") > 1 for _, number in found):
        raise DataError(BOTH_SIGNS if pointed else MAYBE_THOUSANDS, found[0][0] + 1)
    else:
        mark, notes = ".", ()
    return [QUOTED.sub(lambda one: one[1].replace(",", mark), line) for line in lines], notes


def missing_in(above: Sequence[str]) -> list[float]:
    """Numbers that stand for a missing value, as lines above a table say."""
    found = (MARKER.search(line) for line in above)
    return [float(match[1].rstrip(".")) for match in found if match]


def factors_in(above: Sequence[str]) -> list[str]:
    """[a note on factors that lines above a table name]: nothing is multiplied by them."""
    found = [repr(" ".join(line.split())[:LONGEST_SAID]) for line in above if FACTOR.search(line)]
    return [f"Not used: the file says {'; '.join(found[:2])}{' ...' * (len(found) > 2)}."] if found else []
