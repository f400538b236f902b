"""Tasks of the pages for workers: pure functions of picklable arguments that return small arrays or numbers."""

from typing import Any, NamedTuple

import numpy as np

from app.service import worker
from app.service.caller import Lost
from solver import DataError, Profile, Scene, read_profile
from solver.analysis.comparison import noise_in
from solver.analysis.curve_files import read_measurement
from solver.analysis.recording import KINDS
from solver.continuation.state import Outcome
from solver.profile import LONG, SteepError, read_trace

READING, MEMORY = 10.0, 2**30  # s and bytes for a file of a visitor
SLICE = 0.12  # s of work before a call returns a Part, so that other calls get a turn
FARTHEST = 1e9  # nm, N, N/m: numbers of a measured curve beyond have another unit
LAID = 500  # points of a measured curve that the browser draws and compares with each picture of a drag
DRAWN = 400  # points of a drawn curve, about one per pixel


def failure_of(error: Exception) -> Exception:
    """Return why there is no result, without a full stop: a Lost if that may be the fault of a busy machine."""
    why = f"{error}".rstrip(".")
    return Lost("hang", why) if getattr(error, "outcome", None) is Outcome.OUT_OF_TIME else ValueError(why)


class Chosen(NamedTuple):
    """What a visitor has chosen of a profile; lengths in nm. sure: whether he has seen it drawn."""

    unit: str = ""
    begin: float | None = None
    end: float | None = None
    cut_off: float | None = None
    sure: bool = False


def measured(content: bytes, chosen: Chosen) -> tuple[Profile | None, str | None, dict[str, Any] | None]:
    """Return (the Profile in a file or None, why the file is not usable or None, the trace to ask about or None).

    A visitor is asked about a file without a unit, a long trace, and steep places.
    """
    try:
        with worker.bounded_memory(MEMORY):
            trace = read_trace(content, chosen.unit or None)
            long, drawn = np.ptp(trace.x) > LONG, _drawn(trace)
            if not chosen.sure and (long or not trace.named):
                return None, None, drawn
            part = None if chosen.begin is None or chosen.end is None else (chosen.begin, chosen.end)
            try:
                return read_profile(content, unit=chosen.unit or None, part=part, cut_off=chosen.cut_off), None, None
            except SteepError as error:
                return None, str(error), drawn | {"cut_off": error.cut_off}
            except DataError as error:
                return None, str(error), drawn if chosen.sure else None
    except DataError as error:
        return None, str(error), None
    except MemoryError:
        return None, "reading it takes too much memory; export it as CSV of x and z", None


def read_curve(
    scene: Scene, content: bytes, speed: float | None = None, force: float | None = None
) -> tuple[dict[str, Any] | None, str | None]:
    """Return (the measured curve in a file, or None; why the file is not usable, or None).

    The curve has `kind`, `over`, `units`, `free` and `virgin` of a Recording, `noise` {quantity: standard deviation},
    `points`, `notes`, and `segments` [{"name", "x", "F", "L" or "A"}], thinned out to be drawn, without holds.
    """
    try:
        with worker.bounded_memory(MEMORY):
            read = read_measurement(scene, content, speed, force)
    except DataError as error:
        return None, str(error)
    except MemoryError:
        return None, "reading it takes too much memory; thin it out"
    moving = [each for each in read.segments if each.name != "hold"]
    largest = max(float(np.abs(y).max()) for each in moving for y in (each.x, *each.values.values()))
    if largest > FARTHEST:
        return None, f"a number of {largest:.3g}; allowed: {FARTHEST:g} nm, N or N/m at most; check the units"
    points = sum(each.x.size for each in moving)
    every = 1 + points // LAID
    segments = []
    for each in moving:
        columns = {"x": each.x} | each.values
        segments.append({"name": each.name} | {name: y[::every].tolist() for name, y in columns.items()})
    over, names = KINDS[read.kind], moving[0].values
    units = {name: read.units[name] for name in (over, *names)}
    made = {"kind": read.kind, "over": over, "units": units, "free": read.free, "segments": segments}
    made |= {"virgin": getattr(read, "virgin", True), "points": int(points), "notes": " ".join(read.notes)}
    return made | {"noise": {name: noise_in(read, name) for name in names}}, None


def _drawn(trace):
    """A Trace thinned out to be drawn, with its extent in nm; where no unit is named, in that of the file."""
    every = 1 + trace.x.size // DRAWN
    x, z = trace.x - trace.x[0], trace.z - trace.z.min()
    extent = {"length": float(x[-1]), "height": float(z.max()), "points": int(x.size)}
    return {"x": x[::every].tolist(), "z": z[::every].tolist(), "named": bool(trace.named)} | extent
