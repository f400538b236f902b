"""Surfaces in the files of instruments, read by the package SurfaceTopography: one line of each, in nm.

That package is imported only for a file that is no text. It needs `pip install "mixed-mode-contact[instruments]"`.
"""

import re
import warnings
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..surfaces import DataError
from .tables import index_of
from .units import agreed, is_unit, measure

INSTALL = 'this file needs a reader of instruments: pip install "mixed-mode-contact[instruments]"'
BEGIN = 500  # characters that have the known beginning of a text
MISSING = 1e9  # nm: heights beyond are marks of missing points
BEGINNINGS = re.compile(rb"[ab]BCR-1|aISO-1|WSxM file|# Channel: .*\r?\n# Width: |\\\*File list")  # of files in text
UNREAD = (  # what a file is that the library cannot read: a test of its content, and what to do
    (lambda raw: raw[:2] == b"PK" and b"/main.xml" in raw, "an X3P in a folder; zip the files without their folder"),
    (lambda raw: raw[:12] == b"DSCOMPRESSED", "a compressed SUR; save it without compression"),
)
LINE = re.compile(r"(row|column) (\d{1,6})")


def is_instruments(content: str | bytes) -> bool:
    """Whether a file is no table of numbers in text: it has null bytes but no mark of UTF-16, or a known beginning."""
    if isinstance(content, str):
        return bool(BEGINNINGS.match(content[:BEGIN].encode(errors="replace")))
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return False
    return b"\0" in content or bool(BEGINNINGS.match(content)) or any(test(content) for test, _ in UNREAD)


def read_line(
    content: bytes, unit: str | None = None, line: str | None = None, channel: str | int | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], str]:
    """Reads a line of a file.

    Parameters: content: the bytes of the file; unit, line and channel: as of `read_profile`.
    Returns (x (n,) nm, z (n,) nm, nan where it is missing, a note on where they are from).
    Raises DataError for a file that is not known, for one without a unit, and where the package is not installed.
    """
    surface, kind = _opened(content, channel)
    found = surface.unit
    if unit is None and not is_unit(found):
        names = f"the unit {found!r}; give what 1 is" if found else "no unit of length; give it"
        raise DataError(f"the file names {names}, as in unit='{'1 ' * bool(found)}um'", call={"unit": ...})
    nm, _ = measure(found) if unit is None else agreed(unit, found)
    heights = np.ma.filled(np.ma.asarray(surface.heights(), float), np.nan) * nm
    heights[np.abs(heights) > MISSING] = np.nan
    sizes, z, where = surface.physical_sizes, heights, "line"
    if heights.ndim == 2:
        where, z, sizes = _of_map(heights, sizes, line)
    elif line is not None:
        raise DataError(f"line = {line!r}, but the file has one line only; leave it out")
    length = float(sizes[0]) * nm
    high = float(np.nanmax(z) - np.nanmin(z))
    note = f"{kind}: {where} {length:.6g} nm long, {high:.4g} nm high, {z.size} points."
    return np.arange(z.size, dtype=np.float64) * (length / z.size), z, note


def _opened(content: bytes, channel: str | int | None) -> tuple[Any, str]:
    """(a channel of a file, the name of the library's reader)."""
    for test, what in UNREAD:
        if test(content):
            raise DataError(f"this is {what}")
    try:
        from SurfaceTopography import open_topography
    except ImportError:
        raise DataError(INSTALL) from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            reader = open_topography(BytesIO(content))
            return reader.topography(channel_index=_channel(reader, channel)), type(reader).__name__
    except DataError:
        raise
    except Exception as error:  # each of some fifty readers raises errors of its own
        what = "no known file of an instrument"
        what = "an archive without a known file; unpack it" if content[:2] == b"PK" else what
        raise DataError(f"{what} ({type(error).__name__}); export it as CSV of x and z") from None


def _channel(reader: Any, wanted: str | int | None) -> int:
    """The index of a channel, by its name or number; of several one is asked for."""
    names = [channel.name or f"channel {k}" for k, channel in enumerate(reader.channels, 1)]
    if not names:
        raise DataError("the file holds no heights; export it as CSV of x and z")
    return index_of(names, wanted, f"{len(names)} channels")


def _of_map(heights: Any, sizes: Any, line: str | None) -> tuple[str, Any, Any]:
    """(name of the line, its heights (n,), [its length]) of a map (nx, ny)."""
    if line is None:
        if not np.isfinite(heights).any():
            raise DataError("all points of the map are missing; choose another file")
        row = int(np.unravel_index(np.nanargmax(heights), heights.shape)[1])
        return f"row {row}, through the highest point,", heights[:, row], sizes[:1]
    match = LINE.fullmatch(line)
    axis = 0 if match and match[1] == "column" else 1
    if not match or int(match[2]) >= heights.shape[axis]:
        columns, rows = heights.shape
        raise DataError(f"line = {line!r}: allowed: row 0 .. {rows - 1} or column 0 .. {columns - 1}; write 'row 0'")
    k = int(match[2])
    return line, heights[k] if axis == 0 else heights[:, k], sizes[1 - axis :][:1]
