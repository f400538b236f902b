"""Reads a measured profile, two columns x, z in nm, and makes it periodic; says what it did, and what it refuses."""

import re
from os import PathLike
from pathlib import Path

import numpy as np

from .scene import LIMITS
from .surfaces import EVEN, FEWEST_POINTS, LENGTHS, STEEPEST, Profile, ProfileError, averaged
from .text import UNITS

MOST_BYTES = 10_000_000
MOST_POINTS = int(LIMITS["nodes"].high)  # kept; there are never more nodes
LARGEST = 1e9  # nm
JOIN = 0.05  # share of the length, at each end, over which the two ends are brought to one height
FINER = 4  # times as many points where unequal distances are resampled to equal ones
HEADED = re.compile(r"[\[(/]\s*(nm|[µμu]m|Å)\b")  # a unit in the heading, as in x [nm], z (nm), z/nm
SEPARATOR = re.compile(r"[,;\t]")  # or any blanks, where none of these occurs


def read_profile(source: str | bytes | PathLike[str], width: float | None = None) -> Profile:
    """The Profile in a CSV of x, z (nm): its mean line removed, made periodic, at equal distances; raises ProfileError.

    source: a path (os.PathLike), or the file's content as str or bytes. Columns are separated by comma, semicolon, tab
    or space; empty lines and what follows # are skipped; of a heading only units are read, as in x [µm], z [nm].
    width (nm): use only the middle part of that width.
    """
    lines, x, z, units = _columns(_text(source))
    read = "x and z are read as nm" if units == ["nm", "nm"] else "x is read as {}, z as {}".format(*units)
    notes = [f"{x.size} points; {read}; summits of z face the substrate."]
    if width is not None:
        lines, x, z = _middle(lines, x, z, float(width), notes)
    if x.size < FEWEST_POINTS:
        raise ProfileError(f"only {x.size} points, at least {FEWEST_POINTS} are needed", int(lines[-1]))
    length = float(x[-1] - x[0]) if width is None else float(width)
    low, high = LENGTHS
    if not low <= length <= high:
        raise ProfileError(f"the profile is {length:.4g} nm long, allowed: {low:g} .. {high:g} nm", int(lines[-1]))
    z = _levelled(lines, x, z, notes)
    z = _at_equal_distances(x, _joined(lines, x, z, notes), notes)
    start = int(np.argmin(z))
    shift = f"shifted by {start * length / z.size:.4g} nm: the deepest valley lies at the ends of the cell"
    notes.append(f"{shift}; with fewer nodes than {z.size} each shows the mean over the node spacing.")
    return Profile(length, np.roll(z, -start), tuple(notes))


def _text(source):
    """The content as text; raises ProfileError where it is not text."""
    if isinstance(source, PathLike):
        source = _content(Path(source))
    if len(source) > MOST_BYTES:
        raise ProfileError(f"more than {MOST_BYTES / 1e6:g} MB; thin it out, {MOST_POINTS} points are all that is used")
    if not isinstance(source, str):
        try:
            source = bytes(source).decode()
        except UnicodeDecodeError as error:
            line = source[: error.start].count(b"\n") + 1
            raise ProfileError("not UTF-8 text; save the profile as CSV in UTF-8 or ASCII", line) from None
    return source.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _content(path):
    """The bytes of a file, but at most one more than is allowed."""
    if not path.is_file():  # a pipe or a device may never end
        raise ProfileError(f"{str(path)!r} is not a file; name a CSV of x, z")
    try:
        with open(path, "rb") as file:
            return file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ProfileError(f"{str(path)!r}: {error.strerror}; name a CSV of x, z that can be read") from None


def _columns(text):
    """(line numbers, x, z), each (points,), of the lines that hold data, x and z in nm; and their units in the file."""
    lines, points, heading = [], [], ""
    for number, line in enumerate(text.split("\n"), start=1):
        if "\0" in line:
            raise ProfileError("a zero byte, so this is no text; save the profile as CSV", number)
        line = line.partition("#")[0].strip()
        if not line:
            continue
        cells = [cell.strip() for cell in SEPARATOR.split(line)] if SEPARATOR.search(line) else line.split()
        if not points and not heading and not any(map(_is_number, cells)):
            heading = line
            continue
        points.append(_point(cells, number, points[-1][0] if points else -np.inf))
        lines.append(number)
    if not points:
        raise ProfileError("no points; two columns x, z in nm are needed", text.count("\n") + 1)
    units = (2 * [unit.replace("μ", "µ") for unit in HEADED.findall(heading)] or ["nm", "nm"])[:2]
    x, z = np.array(points).T * [[UNITS["nm"][unit]] for unit in units]
    return np.array(lines), x, z, units


def _is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _point(cells, number, before):
    """(x, z) of a line; x must lie beyond the one before."""
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


def _middle(lines, x, z, width, notes):
    """The middle part of a profile, its ends interpolated."""
    length = x[-1] - x[0]
    spare = length - width
    if not (width > 0.0 and spare >= -EVEN * length):  # nan fails it too
        reason = f"the profile is {length:.6g} nm long, the width asked for is {width:g} nm"
        raise ProfileError(f"{reason}; allowed: above 0 to that length; set such a width", int(lines[-1]))
    if spare <= EVEN * length:
        return lines, x, z
    notes.append(f"of {length:.6g} nm the {width:g} nm in the middle are used.")
    ends = x[0] + 0.5 * spare, x[-1] - 0.5 * spare
    part = slice(np.searchsorted(x, ends[0], "right") - 1, np.searchsorted(x, ends[1]) + 1)
    within, heights = x[part].copy(), z[part].copy()
    within[[0, -1]], heights[[0, -1]] = ends, np.interp(ends, x, z)
    return lines[part], within, heights


def _levelled(lines, x, z, notes):
    """Heights above the mean line (least squares), where slopes are small."""
    from_middle = x - x.mean()
    tilt = float(np.sum(from_middle * (z - z.mean())) / np.sum(from_middle**2))
    if abs(tilt) > STEEPEST:
        reason = f"the profile as a whole is tilted by {tilt:.3g}, allowed: up to {STEEPEST:g}; level it first"
        raise ProfileError(reason, int(lines[-1]))
    notes.append(f"a tilt of {tilt:.3g} was removed (line of least squares).")
    z = z - z.mean() - tilt * from_middle
    _refuse_steep(lines, x, z, "smooth or rescale it")
    return z


def _refuse_steep(lines, x, z, remedy, why=""):
    """Raises ProfileError at the first slope beyond STEEPEST."""
    slopes = np.abs(np.diff(z) / np.diff(x))
    if slopes.max() > STEEPEST:
        k = int(np.argmax(slopes > STEEPEST))
        reason = f"{why}slope {slopes[k]:.3g} from the point before, allowed: up to {STEEPEST:g}; {remedy}"
        raise ProfileError(reason, int(lines[k + 1]))


def _joined(lines, x, z, notes):
    """z with ends of one height: the step between them is spread over JOIN of the length at each end, as a cosine."""
    step, reach = float(z[-1] - z[0]), JOIN * (x[-1] - x[0])
    steepest = np.pi * abs(step) / (4.0 * reach)
    if steepest > STEEPEST:
        raise ProfileError(
            f"its ends differ by {abs(step):.4g} nm; joined over {reach:.4g} nm at each end this is a slope of"
            f" {steepest:.3g}, allowed: up to {STEEPEST:g}; cut it where its ends are of one height"
        )
    notes.append(f"the ends, {abs(step):.4g} nm apart, were joined over {reach:.4g} nm at each end (a cosine).")
    start, end = (np.clip(distance / reach, 0.0, 1.0) for distance in (x - x[0], x[-1] - x))
    z = z + 0.25 * step * (np.cos(np.pi * start) - np.cos(np.pi * end))
    why = f"its ends, {abs(step):.4g} nm apart, joined over {reach:.4g} nm at each end: "
    _refuse_steep(lines, x, z, "cut it where its ends are of one height", why)
    return z


def _at_equal_distances(x, z, notes):
    """Heights (points,) of one period at equal distances; its last point, the first of the next period, is left out."""
    gaps, length = np.diff(x), x[-1] - x[0]
    even = np.ptp(gaps) <= EVEN * gaps.mean()
    points = gaps.size if even else FINER * gaps.size
    if even and points <= MOST_POINTS:
        return z[:-1]
    points = min(points, MOST_POINTS)
    resampled = f"{x.size} points were resampled to {points} at equal distances"
    if gaps.min() < length / points:
        notes.append(f"{resampled}: means over the new spacing, where they lay closer.")
        return averaged(x, z, points)
    notes.append(f"{resampled}, linearly.")
    return np.interp(np.arange(points) * (length / points), x - x[0], z)
