"""Code of a worker process: computes a part of the load path and packs it. It needs only NumPy and `solver`."""

import os
import pickle
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from queue import SimpleQueue
from time import perf_counter
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.core.event import Listener, install_listener

from app.service.packing import Frames, packed
from solver import NotFollowed, Scene, advance, skeleton_from
from solver.analysis.interior import transfer
from solver.analysis.work import work_of
from solver.continuation.state import Outcome
from solver.mechanics.linearised import form
from solver.run.frame import largest_overlap, largest_safe_damping
from solver.run.load_steps import load_steps_of
from solver.run.slices import in_time
from solver.run.summary import widest

NICENESS = 10  # low priority: the event loop goes before the computations
QUICK, SLOW = 0.3, 10.0  # s of processor time per increment: of a run that must not delay others; of any run
BUDGET = 0.12  # s of work in a part: most runs end in the second, and a slow run visibly grows
APPROACH = 3  # a part may take 3 times its budget to reach the first frames of the shear
MODULES = [module for name, module in sys.modules.items() if name.startswith("solver.")]
KERNELS = len({k for m in MODULES for k in vars(m).values() if isinstance(k, Dispatcher)})  # `warm_up` compiles them


@dataclass(frozen=True)
class Part:
    """An unfinished call: a further call with `state` after its arguments continues it.

    made: a partial result, which is not sent to a worker again; the sum of all parts is the result. heavy: whether the
    next part may take so long that it must not delay others.
    """

    state: Any
    made: Any = None
    heavy: bool = False


def start() -> None:
    """Prepare a new worker: lower its priority and load the kernels."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    warm_up()


class _Compiled(Listener):
    """Counts the kernels of `solver` as they are compiled, and puts the count into a queue."""

    def __init__(self, queue: SimpleQueue) -> None:
        self.queue, self.count = queue, 0

    def on_start(self, event: Any) -> None:
        """Do nothing: the kernel is not compiled yet."""

    def on_end(self, event: Any) -> None:
        if event.data["dispatcher"].py_func.__module__.startswith("solver."):  # Numba has others
            self.count += 1
            self.queue.put(self.count)


def start_up() -> Iterator[int]:
    """Do the same as `start`, and yield the number of kernels compiled so far."""
    compiled = SimpleQueue()
    with install_listener("numba:compile", _Compiled(compiled)), ThreadPoolExecutor(1) as thread:
        done = thread.submit(start)
        done.add_done_callback(lambda _: compiled.put(None))
        yield from iter(compiled.get, None)
        done.result()


def warm_up() -> None:
    """Run a small scene with slips and the first increments of the default one: compile kernels, plan the FFTs."""
    checkpoint = None
    small = Scene(nodes=128, width=312.5, radius=20.0, u_x_max=16.0)
    while checkpoint is None or not checkpoint.done:
        _, checkpoint = advance(small, checkpoint, 1.0)
    advance(Scene(), None, 0.1)
    transfer(np.ones(1), np.ones(1), 2.0, 1.0, small.nu)
    form(np.arange(1), *np.ones((3, 1)), np.ones((4, 1)), np.empty((2, 2)))  # which soft layers need only


@contextmanager
def bounded_memory(more: int) -> Iterator[None]:
    """Let this process take so many bytes more than it has, where the system can: beyond, MemoryError is raised."""
    try:
        import resource

        with open("/proc/self/statm") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        before = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (used + more, before[1]))
    except (ImportError, OSError, ValueError):  # Windows, macOS; a lower limit is set already
        yield
        return
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def ready() -> None:
    """A task that does nothing."""


def compute(
    scene: Scene, state: bytes | None = None, budget: float | None = None, limit: float | None = None
) -> Frames | Part:
    """Return the Frames of a run that has ended, or a Part with the next ones.

    It works for about `budget` seconds (None: BUDGET), or longer if that ends in the approach. limit: s of processor
    time per increment (None: QUICK, or SLOW if the Part before was heavy). A longer one is left out and heavy; the next
    part repeats it with more time.
    """
    begun, budget = perf_counter(), BUDGET if budget is None else budget
    checkpoint, last, heavy = pickle.loads(state) if state else (None, None, False)
    limit = limit if limit is not None else SLOW if heavy else QUICK
    frames, checkpoint = _advanced(scene, checkpoint, begun, budget, limit)
    late = checkpoint.outcome is Outcome.OUT_OF_TIME
    heavy = late or (limit >= SLOW and _slow(begun, budget))
    if late and limit < SLOW:
        checkpoint = in_time(checkpoint)
    work, last = works(scene, frames, last)
    made = Frames(
        blocks=packed(scene, list(zip(frames, work, strict=True)), checkpoint.done),
        frames=len(frames),
        evaluations=int(sum(frame.evaluations for frame in frames)),
        residual=float(max((frame.residual for frame in frames), default=0.0)),
        widest=widest(frames),
        overlap=largest_overlap(frames),
        safe_damping=largest_safe_damping(frames),
        sensitive=any(frame.sensitive for frame in frames),
        ahead=_ahead(scene, checkpoint),
        failure="" if checkpoint.outcome.reached else f"{checkpoint.failure}",
        parted=f"{checkpoint.failure}" if checkpoint.outcome is Outcome.PULLED_OFF else "",
        skeleton=_skeleton(scene, checkpoint),
    )
    return made if checkpoint.done else Part(pickle.dumps((checkpoint, last, heavy)), made, heavy)


def _skeleton(scene, checkpoint):
    """Return the Skeleton of a finished run, or None."""
    if checkpoint.done and not checkpoint.failure:
        with suppress(NotFollowed):
            return skeleton_from(scene, checkpoint)
    return None


def _advanced(scene, checkpoint, begun, budget, limit):
    """Return (frames, Checkpoint) after the budget, or after APPROACH times the budget if shear has not begun."""
    frames, checkpoint = advance(scene, checkpoint, begun + budget - perf_counter(), limit=limit)
    while checkpoint.stage == "approach" and not checkpoint.done and perf_counter() < begun + APPROACH * budget:
        more, checkpoint = advance(scene, checkpoint, budget / APPROACH, limit=limit)
        frames += more
    return frames, checkpoint


def _slow(begun, budget):
    """Whether a slice took so much longer than its budget that its run would delay others."""
    return perf_counter() > begun + budget + QUICK


def works(scene: Scene, frames: list[Any], last: Any = None) -> tuple[Any, Any]:
    """Return the work of the top up to every frame, nJ/m, and (last frame, its work); zeros unless path=loop.

    last: the same of the frames before, if there are any.
    """
    if scene.path != "loop" or not frames:
        return [0.0] * len(frames), None
    before, done = last or (None, 0.0)
    previous = [before] if before else []
    work = done + work_of(previous + frames)[len(previous) :]
    return work, (frames[-1], work[-1])


def _ahead(scene, checkpoint):
    """Return the number of frames left."""
    if checkpoint.done:
        return 0
    load_steps = checkpoint.load_steps or load_steps_of(scene)
    now = next(k for k, step in enumerate(load_steps) if step.stage == checkpoint.stage)
    return sum(step.increments + 1 for step in load_steps[now:]) - checkpoint.increment
