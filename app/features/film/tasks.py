"""The motion through a slip, for workers."""

from time import perf_counter
from typing import Any

from app.service import packing, worker
from app.service.tasks import SLICE
from app.service.worker import Part
from solver import NotConverged, Scene
from solver.run.film import through
from solver.run.loadpath import Checkpoint, Run, deadline


def slow_motion(scene: Scene, frame: int, state: Any = None) -> tuple[bytes, ...] | Part | str:
    """Return packed blocks of the transient that led to a frame of the run; a Part; or a str: why there is none.

    The run is repeated, as the browser's frames are rounded.
    """
    done, checkpoint = state or (0, Checkpoint())
    run, until = Run(scene), perf_counter() + SLICE
    try:
        while done < frame and not checkpoint.done and perf_counter() < until:
            _, checkpoint = run.next_frame(checkpoint, deadline(worker.SLOW))
            done += 1
        if checkpoint.done:
            return f"frame = {frame}; allowed: 0 .. {done - 1}, where the run ends; choose one of them"
        if done < frame:
            return Part((done, checkpoint))
        film, _ = through(scene, checkpoint, limit=worker.SLOW)
    except NotConverged as error:
        return str(error)
    return packing.packed(scene, [(frame, 0.0) for frame in film], True) if film else "no branch ends here"
