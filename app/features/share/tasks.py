"""Files and QR codes, for workers."""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import segno

from app.service import worker
from app.service.tasks import SLICE
from solver import Scene, advance
from solver.files import report_of, write_json, write_npz

LONGEST_FILE = 60.0  # s of work on a file


def file_of_run(scene: Scene, kind: str) -> bytes | None:
    """Return the file that `python -m solver run` writes, bytes, or None if the run takes longer than LONGEST_FILE.

    kind: npz or json. The file ends where the run did not converge.
    """
    frames, checkpoint, begun = [], None, perf_counter()
    while checkpoint is None or not checkpoint.done:
        if perf_counter() > begun + LONGEST_FILE:
            return None
        more, checkpoint = advance(scene, checkpoint, SLICE, limit=worker.SLOW)
        frames += more
    with TemporaryDirectory() as folder:
        file = Path(folder, "run")
        if kind == "npz":
            write_npz(file, scene, frames, outcome=checkpoint.outcome)
        else:
            seconds = perf_counter() - begun
            write_json(file, report_of(scene, frames, "fast", seconds, checkpoint.failure, checkpoint.outcome))
        return file.read_bytes()


def qr_code(link: str) -> str:
    """Return the QR code of a link as the data URI of an SVG."""
    return segno.make(link, error="l").svg_data_uri(scale=4, border=2)
