"""Force curves in the files of atomic force microscopes, read by the package afmformats: JPK, Asylum, its own HDF5.

It is imported only for such a file, and needs `pip install "mixed-mode-contact[instruments]"`.
"""

import logging
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..surfaces import DataError
from .content import Source, content_of
from .instruments import INSTALL, is_instruments
from .tables import FIRST, Block, Table, column_of, index_of, table_in

FORMATS = {  # what the beginning and words of a file tell: how the name of such a file ends
    ".jpk-force": (b"PK", b"segments/", b"header.properties"),
    ".h5": (b"\x89HDF", b"imaging mode"),
    ".ibw": (b"\5\0", b"SpringConstant", b"Defl"),
}
THIRD = 140  # place of the third size in an Igor wave: an image has channels there, a curve has 0
ANOTHER = (
    "this is no table in text, and no force curve of a known format; export it as CSV; read_profile reads surfaces"
)


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
    return isinstance(content, bytes) and _ending(content) is not None


def _ending(content):
    """How the name of a file of force curves ends; None for another file."""
    for ending, (beginning, *words) in FORMATS.items():
        if content.startswith(beginning) and all(word in content for word in words):
            third = int.from_bytes(content[THIRD : THIRD + 4], "little", signed=True)  # 0 of a file that is cut off
            image = ending == ".ibw" and third > 0
            return None if image else ending
    return None


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
            raise _unread(error, isinstance(error, MissingMetaDataError)) from None


def _unread(error, uncalibrated):
    """The DataError for a file that afmformats rejects; uncalibrated: as it lacks what makes newtons of volts."""
    reason = " ".join(f"{error}".split())[:120] or type(error).__name__
    if uncalibrated:
        why = 'export columns of it as text, and say what 1 V is, as in units={"L": "500 nN"}'
        return DataError(f"no force in N can be read ({reason}); {why}")
    return DataError(f"this file of force curves cannot be read ({reason}); export its columns as text")


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
    if "height (measured)" in read:
        read = {name: column for name, column in read.items() if name not in ("height (piezo)", "tip position")}
    cells = list(read.values())
    columns = tuple(column_of(name, column_units.get(name) or None, own) for name, own in read.items())
    spring = curve.metadata.get("spring constant")
    above = (f"spring constant: {spring:.6g} N/m",) if spring else ()
    first = tuple(tuple(f"{own[k]:.6g}" for own in cells) for k in range(min(FIRST, cells[0].size)))
    notes = (f"Force curve {index + 1} of {len(curves)}.",) if len(curves) > 1 else ()
    table = Table(columns, first, above, cells[0].size)
    return Block(table, cells, np.arange(1, cells[0].size + 1), notes, "load")
