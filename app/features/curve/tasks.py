"""Reads the file of a measured curve, for workers."""

from typing import Any

import numpy as np

from app.service import worker
from app.service.tasks import MEMORY
from solver import DataError, Scene
from solver.measured.comparison import noise_in
from solver.measured.curves import read_measurement
from solver.measured.recording import KINDS

FARTHEST = 1e9  # nm, N, N/m: numbers of a measured curve beyond have another unit
LAID = 500  # points of a measured curve that the browser draws and compares with each picture of a drag


def _remedy(call):
    """What a visitor can do about what a file does not say: the page asks for a speed, or the factor of a force."""
    unknown = {name for name, unit in call.get("units", {}).items() if unit is ...}
    if call.keys() == {"speed"} or call.keys() == {"kind", "speed"}:
        return "; give speed= (nm/s)"
    if call.keys() == {"units"} and len(unknown) == 1 and unknown <= {"F", "L"}:
        return "; give force= (N/m per unit)"
    return "; write names and units in the heading, as in U_x (nm),F (N/m)" if call else ""


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
        return None, f"{error.brief}{_remedy(error.call)}"
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
