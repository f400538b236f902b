"""Reads a measured profile, two columns x, z in nm, and makes it periodic; reports what it did and what it rejects."""

import re
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .scene import LIMITS
from .surfaces import EVEN, FEWEST_POINTS, LENGTHS, STEEPEST, Profile, ProfileError, averaged
from .text import UNITS

MOST_BYTES = 10_000_000  # of a file: MOST_POINTS lines of 600 characters
MOST_POINTS = int(LIMITS["nodes"].high)  # kept; there are never more nodes
LARGEST = 1e9  # nm, a metre: beyond it the unit is wrong
JOIN = 0.05  # share of the length, at each end, over which the two ends are brought to one height
FINER = 4  # times as many points where unequal distances are resampled: so the corners of the linear pieces stay
HEADED = re.compile(r"[\[(/]\s*(nm|[µμu]m|Å)\b")  # a unit in the heading, as in x [nm], z (nm), z/nm
SEPARATOR = re.compile(r"[,;\t]")  # or any blanks, in lines without these


class Points(NamedTuple):
    """Points of a profile, (n,) each: the number of their line in the file, x and z in nm."""

    line: NDArray[np.int64]
    x: NDArray[np.float64]
    z: NDArray[np.float64]

    @property
    def length(self) -> float:
        """From the first point to the last, nm."""
        return float(self.x[-1] - self.x[0])


def read_profile(source: str | bytes | PathLike[str], width: float | None = None) -> Profile:
    """The Profile in a CSV of x, z (nm): its mean line removed, made periodic, at equal distances; raises ProfileError.

    source: a path (os.PathLike), or the file's content as str or bytes. Columns are separated by comma, semicolon, tab
    or space; empty lines and text after # are skipped; a heading may give units, as in x [µm], z [nm].
    width (nm): use only the middle part of that width.
    """
    points, units = _points(_text(source))
    read = "x and z are read as nm" if units == ["nm", "nm"] else "x is read as {}, z as {}".format(*units)
    notes = [f"{points.x.size} points; {read}; summits of z face the substrate."]
    if width is not None:
        points, cut = _middle(points, float(width))
        notes += cut
    if points.x.size < FEWEST_POINTS:
        reason = f"only {points.x.size} points, at least {FEWEST_POINTS} are needed"
        raise ProfileError(reason, int(points.line[-1]))
    length = points.length if width is None else float(width)
    low, high = LENGTHS
    if not low <= length <= high:
        reason = f"the profile is {length:.4g} nm long, allowed: {low:g} .. {high:g} nm"
        raise ProfileError(reason, int(points.line[-1]))
    points, tilt = _levelled(points)
    points, step = _joined(points)
    z, resampled = _at_equal_distances(points)
    start = int(np.argmin(z))
    shift = f"shifted by {start * length / z.size:.4g} nm: the deepest valley lies at the ends of the cell"
    shift += f"; with fewer nodes than {z.size} each shows the mean over the node spacing."
    return Profile(length, np.roll(z, -start), (*notes, tilt, step, *resampled, shift))


def _text(source: str | bytes | PathLike[str]) -> str:
    """The content as text; raises ProfileError where it is not text."""
    content = _content(Path(source)) if isinstance(source, PathLike) else source
    if len(content) > MOST_BYTES:
        raise ProfileError(f"more than {MOST_BYTES / 1e6:g} MB; thin it out, {MOST_POINTS} points are all that is used")
    if not isinstance(content, str):
        try:
            content = bytes(content).decode()
        except UnicodeDecodeError as error:
            line = error.object[: error.start].count(b"\n") + 1
            raise ProfileError("not UTF-8 text; save the profile as CSV in UTF-8 or ASCII", line) from None
    return content.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _content(path):
    """The bytes of a file, at most one more than allowed."""
    if not path.is_file():  # a pipe or a device may never end
        raise ProfileError(f"{str(path)!r} is not a file; name a CSV of x, z")
    try:
        with open(path, "rb") as file:
            return file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ProfileError(f"{str(path)!r}: {error.strerror}; name a CSV of x, z that can be read") from None


def _points(text):
    """(Points, their units in the file) of the lines that hold data."""
    lines, rows, heading = [], [], ""
    for number, line in enumerate(text.split("\n"), start=1):
        if "\0" in line:
            raise ProfileError("a zero byte: the file is not text; save the profile as CSV", number)
        line = line.partition("#")[0].strip()
        if not line:
            continue
        cells = [cell.strip() for cell in SEPARATOR.split(line)] if SEPARATOR.search(line) else line.split()
        if not rows and not heading and not any(map(_is_number, cells)):
            heading = line
            continue
        rows.append(_row(cells, number, rows[-1][0] if rows else -np.inf))
        lines.append(number)
    if not rows:
        raise ProfileError("no points; two columns x, z in nm are needed", text.count("\n") + 1)
    units = (2 * [unit.replace("μ", "µ") for unit in HEADED.findall(heading)] or ["nm", "nm"])[:2]
    x, z = np.array(rows).T * [[UNITS["nm"][unit]] for unit in units]
    return Points(np.array(lines), x, z), units


def _is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _row(cells, number, before):
    """(x, z) of a line; x must exceed that of the line before."""
    if len(cells) != 2:
        count = "one column" if len(cells) == 1 else f"{len(cells)} columns"
        raise ProfileError(f"{count}, two are needed: x, z in nm, with decimal points, not commas", number)
    for name, cell in zip("xz", cells, strict=True):
        if not _is_number(cell):
            raise ProfileError(f"{name} = {cell[:40]!r} is not a number", number)
        if not abs(float(cell)) <= LARGEST:  # nan fails it too
            raise ProfileError(f"{name} = {cell[:40]}: allowed: -{LARGEST:g} .. {LARGEST:g} nm", number)
    x, z = map(float, cells)
    if x <= before:
        raise ProfileError(f"x = {x:g} after {before:g}; x must ascend from line to line", number)
    return x, z


def _middle(points, width):
    """(the middle part of that width, its ends interpolated; [note]), or all where it is no longer."""
    spare = points.length - width
    if not (width > 0.0 and spare >= -EVEN * points.length):  # nan fails it too
        reason = f"the profile is {points.length:.6g} nm long, the width asked for is {width:g} nm"
        raise ProfileError(f"{reason}; allowed: above 0 to that length; set such a width", int(points.line[-1]))
    if spare <= EVEN * points.length:
        return points, []
    line, x, z = points
    ends = x[0] + 0.5 * spare, x[-1] - 0.5 * spare
    part = slice(np.searchsorted(x, ends[0], "right") - 1, np.searchsorted(x, ends[1]) + 1)
    within, heights = x[part].copy(), z[part].copy()
    within[[0, -1]], heights[[0, -1]] = ends, np.interp(ends, x, z)
    note = f"of {points.length:.6g} nm the {width:g} nm in the middle are used."
    return Points(line[part], within, heights), [note]


def _levelled(points):
    """(Points with heights above the mean line of least squares, note); rejects slopes that are not small."""
    x, z = points.x - points.x.mean(), points.z - points.z.mean()
    tilt = float(np.sum(x * z) / np.sum(x**2))
    if abs(tilt) > STEEPEST:
        reason = f"the profile as a whole is tilted by {tilt:.3g}, allowed: up to {STEEPEST:g}; level it first"
        raise ProfileError(reason, int(points.line[-1]))
    levelled = points._replace(z=z - tilt * x)
    _reject_steep(levelled, "smooth or rescale it")
    return levelled, f"a tilt of {tilt:.3g} was removed (line of least squares)."


def _reject_steep(points, remedy, why=""):
    """Raises ProfileError at the first slope beyond STEEPEST."""
    slopes = np.abs(np.diff(points.z) / np.diff(points.x))
    if slopes.max() > STEEPEST:
        k = int(np.argmax(slopes > STEEPEST))
        reason = f"{why}slope {slopes[k]:.3g} from the point before, allowed: up to {STEEPEST:g}; {remedy}"
        raise ProfileError(reason, int(points.line[k + 1]))


def _joined(points):
    """(Points with ends of one height, note): the step is spread over JOIN of the length at each end, as a cosine."""
    _, x, z = points
    step, reach = float(z[-1] - z[0]), JOIN * points.length
    steepest = np.pi * abs(step) / (4.0 * reach)
    if steepest > STEEPEST:
        raise ProfileError(
            f"its ends differ by {abs(step):.4g} nm; joined over {reach:.4g} nm at each end this is a slope of"
            f" {steepest:.3g}, allowed: up to {STEEPEST:g}; cut it where its ends are of one height"
        )
    start, end = (np.clip(distance / reach, 0.0, 1.0) for distance in (x - x[0], x[-1] - x))
    joined = points._replace(z=z + 0.25 * step * (np.cos(np.pi * start) - np.cos(np.pi * end)))
    why = f"its ends, {abs(step):.4g} nm apart, joined over {reach:.4g} nm at each end: "
    _reject_steep(joined, "cut it where its ends are of one height", why)
    return joined, f"the ends, {abs(step):.4g} nm apart, were joined over {reach:.4g} nm at each end (a cosine)."


def _at_equal_distances(points):
    """(heights (m,) of one period at equal distances, [note]), without the last point, the first of the next period."""
    _, x, z = points
    gaps = np.diff(x)
    even = np.ptp(gaps) <= EVEN * gaps.mean()
    count = gaps.size if even else FINER * gaps.size
    if even and count <= MOST_POINTS:
        return z[:-1], []
    count = min(count, MOST_POINTS)
    resampled = f"{x.size} points were resampled to {count} at equal distances"
    if gaps.min() < points.length / count:
        return averaged(x, z, count), [f"{resampled}: means over the new spacing, where they lay closer."]
    spacing = points.length / count
    return np.interp(np.arange(count) * spacing, x - x[0], z), [f"{resampled}, linearly."]
