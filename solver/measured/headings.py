"""The heading of a table: names and units of its columns, in the lines above the numbers."""

import csv
import re
from collections.abc import Sequence

from .units import labelled_unit, named_unit, parted, plain_unit

LABEL = re.compile(r"\W*(columns|units|segment)\s*:\s*(.*)", re.I)  # lines by which a file names its own columns
REMARKS = "comment", "comments", "remark", "remarks", "note", "notes"  # a last column that rows leave out
COMMENT, BRACKETS = "#%/!*' \t", "[](){} "  # around a heading; around a unit
BLANKS = re.compile(r'"[^"]*"|[^\s([{]+(?:\s?(?:\([^)]*\)|\[[^\]]*\]|\{[^}]*\})|\s/\s\S+)?|[(\[{][^)\]}]*[)\]}]')


def labelled(lines: Sequence[str]) -> dict[int, str]:
    """{index: the segment that a line of a file labels, or "" where tables of other columns are no segments of one}."""
    marks = [(k, match[1].lower(), match[2].strip()) for k, line in enumerate(lines)
             if line[:1] == "#" and (match := LABEL.match(line))]  # fmt: skip
    same = len({text for _, label, text in marks if label == "columns"}) <= 1
    return {k: text * same for k, label, text in marks if label == "segment"}


def heading_of(above: Sequence[str], separator: str, sizes: tuple[int, int]) -> tuple[list[str | None], list[str]]:
    """([units or None], [names]) of the columns: what the file labels so, or the lines above the first row."""
    labels = {match[1].lower(): match[2] for line in above if (match := LABEL.match(line))}
    named, units = (_split(labels.get(word, ""), separator, sizes) for word in ("columns", "units"))
    near = _near(above, separator, sizes) if named is None else []
    unit_row = next((k for k, cells in enumerate(near) if _are_units(cells)), None)
    if unit_row is not None:  # names stand above it, with comments below, or else below it
        units = [plain_unit(cell.strip(BRACKETS)) for cell in near.pop(unit_row)]
        near = near[unit_row:] or near
    both = [parted(cell) for cell in named or (near[0] if near else [""] * sizes[1])]
    below = units or [""] * sizes[1]
    # two units of one column make one that is not known, and is asked for
    each = [
        " or ".join(dict.fromkeys(filter(None, pair))) for pair in zip((own for _, own in both), below, strict=True)
    ]
    return [unit or None for unit in each], [name for name, _ in both]


def _near(above, separator, sizes):
    """[cells] of the lines next to the first row that have words in each column, the lowest first."""
    near = []
    for line in [line for line in reversed(above) if re.search(r"[^\W\d_]", line)][:3]:
        cells = _split(line.strip(COMMENT), separator, sizes)
        if labelled_unit(line):
            continue
        if cells is None or any(re.match(r"[\d.+-]|.*:$", cell) for cell in cells):
            break
        near.append(cells)
    return near


def _are_units(cells):
    """Whether more than half of the cells are units; others may be such as mm/sec."""
    filled = [cell for cell in cells if cell]
    return 2 * sum(named_unit(cell) or cell[0] in BRACKETS for cell in filled) > len(filled)


def _split(line, separator, sizes):
    """The cells of a heading, cut by the separator of the rows or by another one into as many; None if it has more.

    sizes: numbers of columns without and with the empty ones at their end.
    """
    filled, width = sizes
    if not line or len(line) > 200 * width:
        return None
    marks = dict.fromkeys((separator or "\t", ";", "\t", ","))
    quoted = [next(csv.reader([line], delimiter=mark, skipinitialspace=True)) for mark in marks]
    blanks = [] if re.search("[;\t]", line) else BLANKS.findall(line)
    for cells in (*quoted, re.split(" {2,}", line), blanks):
        cells = [" ".join(cell.split()).strip(' "') for cell in cells]
        while len(cells) > filled and (not cells[-1] or cells[-1].lower() in REMARKS):
            cells.pop()
        if filled <= len(cells) <= width and any(cells):
            return [*cells, *[""] * (width - len(cells))]
    return None
