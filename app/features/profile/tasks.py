"""Reads the file of a profile, for workers."""

from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from app.service import worker
from app.service.tasks import MEMORY
from solver import DataError, Profile, read_profile
from solver.measured.profile import LONG, SteepError, read_trace

DRAWN = 400  # points of a drawn curve, about one per pixel


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
            trace, named = _trace(content, chosen.unit)
            long, drawn = np.ptp(trace.x) > LONG, _drawn(trace, named)
            if not chosen.sure and (long or not named):
                return None, None, drawn
            part = None if chosen.begin is None or chosen.end is None else (chosen.begin, chosen.end)
            try:
                return read_profile(content, unit=chosen.unit or None, part=part, cut_off=chosen.cut_off), None, None
            except SteepError as error:
                return None, error.brief, drawn | {"cut_off": error.cut_off}
            except DataError as error:
                return None, error.brief, drawn if chosen.sure else None
    except DataError as error:
        return None, error.brief, None
    except MemoryError:
        return None, "reading it takes too much memory; export it as CSV of x and z", None


def _trace(content, unit):
    """(the Trace, whether its unit is known); of a file that lacks nothing but the unit, as it would be in nm."""
    try:
        return read_trace(content, unit=unit or None), True
    except DataError as error:
        if unit or error.call.keys() - {"units", "unit"} or not error.call:
            raise
        with suppress(DataError):  # one of the two is named
            return read_trace(content, unit="nm"), False
        raise


def _drawn(trace, named):
    """A Trace thinned out to be drawn, with its extent in nm; where no unit is named, in that of the file."""
    every = 1 + trace.x.size // DRAWN
    x, z = trace.x - trace.x[0], trace.z - trace.z.min()
    extent = {"length": float(x[-1]), "height": float(z.max()), "points": int(x.size)}
    return {"x": x[::every].tolist(), "z": z[::every].tolist(), "named": named} | extent
