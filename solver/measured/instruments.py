"""Files of instruments: one line of a surface, read by SurfaceTopography, and force curves, read by afmformats.

Both packages are imported only for such a file, and need `pip install "mixed-mode-contact[instruments]"`.
"""

import logging
import re
import warnings
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..surfaces import DataError
from .content import Source, content_of
from .tables import FIRST, Block, Table, column_of, index_of, table_in
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
FORMATS = {  # what the beginning and words of a file tell: how the name of such a file ends
    ".jpk-force": (b"PK", b"segments/", b"header.properties"),
    ".h5": (b"\x89HDF", b"imaging mode"),
    ".ibw": (b"\5\0", b"SpringConstant", b"Defl"),
}
THIRD = 140  # place of the third size in an Igor wave: an image has channels there, a curve has 0
ANOTHER = (
    "this is no table in text, and no force curve of a known format; export it as CSV; read_profile reads surfaces"
)


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
    heights: NDArray[np.float64] = np.ma.filled(np.ma.asarray(surface.heights(), float), np.nan)
    heights = np.where(np.abs(heights) > MISSING / nm, np.nan, heights) * nm
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
            names = [one.name or f"channel {k}" for k, one in enumerate(reader.channels, 1)]
            if not names:
                raise DataError("the file holds no heights; export it as CSV of x and z")
            index = index_of(names, channel, f"{len(names)} channels")
            return reader.topography(channel_index=index), type(reader).__name__
    except DataError:
        raise
    except Exception as error:  # each of some fifty readers raises errors of its own
        archive = content[:2] == b"PK"
        what = "an archive without a known file; unpack it" if archive else "no known file of an instrument"
        raise DataError(f"{what} ({type(error).__name__}); export it as CSV of x and z") from None


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


def read_block(source: Source, needed: str, channel: str | int | None = None) -> Block:
    """The Block of a force curve, or of a table in text as `table_in` finds it; raises DataError."""
    content = content_of(source)
    if is_force_curve(content):
        return _of_microscope(content, channel)
    if is_instruments(content):
        raise DataError(ANOTHER)
    return table_in(content, needed, channel)


def is_force_curve(content: str | bytes) -> bool:
    """Whether a file holds force curves in one of FORMATS."""
    return isinstance(content, bytes) and bool(_ending(content))


def _ending(content):
    """How the name of a file of force curves ends; "" for another file."""
    for ending, (beginning, *words) in FORMATS.items():
        if content.startswith(beginning) and all(word in content for word in words):
            third = int.from_bytes(content[THIRD : THIRD + 4], "little", signed=True)  # 0 of a file that is cut off
            return "" if ending == ".ibw" and third > 0 else ending
    return ""


def _of_microscope(content, channel):
    """The Block of one of the curves in a file; raises DataError."""
    try:
        import afmformats
        from afmformats.errors import AFMFileFormatError, MissingMetaDataError
        from afmformats.formats.fmt_jpk.jpk_reader import ArchiveCache
        from afmformats.meta import MetaDataMissingError
    except ImportError:
        raise DataError(INSTALL) from None
    ArchiveCache.max_archives = 1  # else the files of 32 visitors stay open
    logging.getLogger("afmformats").setLevel(logging.CRITICAL)  # a file that cannot be read is no error of the server
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / f"curve{_ending(content)}"
        path.write_bytes(content)
        try:
            curves = afmformats.load_data(path)
            names = [f"curve {k}" for k in range(1, len(curves) + 1)]
            return _block(curves, index_of(names, channel, f"{len(names)} force curves"))
        except DataError:
            raise
        except (Exception, AFMFileFormatError, MissingMetaDataError, MetaDataMissingError) as error:  # three are none
            reason = " ".join(f"{error}".split())[:120] or type(error).__name__
            if isinstance(error, MissingMetaDataError):  # of what makes newtons of volts
                why = 'export columns of it as text, and say what 1 V is, as in units={"L": "500 nN"}'
                raise DataError(f"no force in N can be read ({reason}); {why}") from None
            why = "export its columns as text"
            raise DataError(f"this file of force curves cannot be read ({reason}); {why}") from None


def _block(curves, index):
    """A curve as a Block, in N and m; raises DataError for one without points."""
    from afmformats.afm_data import column_units

    curve = curves[index]
    read = {name: np.asarray(curve[name], np.float64) for name in curve.columns}
    if not read or not min(column.size for column in read.values()):
        raise DataError(f"force curve {index + 1} of {len(curves)} has no points; choose another curve or file")
    # of other modes, numbers count segments: 1 is no retraction
    if "segment" in read and not (curve.modality == "force-distance" and np.ptp(read["segment"]) > 0):
        del read["segment"]
    cells = list(read.values())
    columns = tuple(column_of(name, column_units.get(name) or None, own) for name, own in read.items())
    spring = curve.metadata.get("spring constant")
    above = (f"spring constant: {spring:.6g} N/m",) if spring else ()
    first = tuple(tuple(f"{own[k]:.6g}" for own in cells) for k in range(min(FIRST, cells[0].size)))
    notes = (f"Force curve {index + 1} of {len(curves)}.",) if len(curves) > 1 else ()
    table = Table(columns, first, above, cells[0].size)
    return Block(table, cells, np.arange(1, cells[0].size + 1), notes, "load")
