"""A run in slices: a few Frames at a time, each slice from the Checkpoint of the one before."""

from collections.abc import Callable
from math import inf
from threading import local
from time import perf_counter
from typing import Any

from ..continuation.state import NotConverged, Outcome
from ..scene import Scene
from ..threads import computation
from .frame import Frame, slides_in
from .loadpath import Checkpoint, Run
from .summary import first_slip_in


@computation
def advance(
    scene: Scene,
    checkpoint: Checkpoint | None = None,
    budget: float = 0.04,
    method: str | Callable[..., Any] = "fast",
    limit: float = inf,
    stop: Callable[[Frame], Any] | None = None,
) -> tuple[list[Frame], Checkpoint]:
    """Computes a slice of a run: a pure function of picklable arguments, for use in a worker.

    Parameters: scene; checkpoint: where the slice begins (default: the start of the run); budget: its length, s;
    method: a name in METHODS; limit: processor time of an increment, s; stop: true of the Frame that ends the slice.
    Returns (frames, checkpoint): the Frames of the slice, at least one, and where it ended. If an increment fails,
    checkpoint.outcome says how, and checkpoint.failure names the load and a remedy.
    Raises ValueError for a method that is not in METHODS, SceneError for the checkpoint of another scene.

    Example: `frames, checkpoint = advance(Scene())`
    """
    checkpoint = checkpoint or Checkpoint()
    frames: list[Frame] = []
    end = perf_counter() + budget
    try:
        for frame, after in _run_of(scene, method).frames(checkpoint, limit):
            frames.append(frame)
            checkpoint = after
            if perf_counter() > end or (stop is not None and stop(frame)):
                break
    except NotConverged as failure:
        checkpoint = checkpoint._replace(done=True, failure=str(failure), outcome=failure.outcome)
    return frames, checkpoint


def first_slip(
    scene: Any, checkpoint: Any = None, budget: float = inf, limit: float = inf, beyond: Any = lambda frame: False
) -> tuple[Any, list[Any], Any]:
    """((Frame, SlipEvent) of the first slip along U_x or None, Frames, Checkpoint) of a slice that ends with it.

    Arguments as of `advance`; beyond: true of a Frame at which the search ends without a slip.
    """

    def ends(frame):
        return slides_in(frame) or beyond(frame)

    frames, checkpoint = advance(scene, checkpoint, budget, limit=limit, stop=ends)
    return first_slip_in(frames), frames, checkpoint


def in_time(checkpoint) -> Checkpoint:
    """The Checkpoint before the increment that ran out of time, which ended it."""
    return checkpoint._replace(done=False, failure=None, outcome=Outcome.FINISHED)


_kept = local()  # of each thread: its last Run, whose buffers are expensive to make, and the arguments of that Run


def _run_of(*arguments):
    """The Run of these arguments for this thread."""
    if getattr(_kept, "arguments", None) != arguments:
        _kept.arguments, _kept.run = arguments, Run(*arguments)
    return _kept.run
