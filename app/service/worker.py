"""What runs inside a worker process: a slice of the load path, packed for the browser; NumPy and `solver` only."""

import os
import pickle
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise
from math import e, inf
from queue import SimpleQueue
from time import perf_counter

import numpy as np
from numba.core.event import Listener, install_listener

from app.service.packing import Frames, packed
from solver import Checkpoint, NotConverged, NotFollowed, Scene, SceneError, advance, skeleton_from
from solver.analysis.energy_balance import work_of
from solver.analysis.interior import transfer
from solver.continuation.state import OutOfTime
from solver.run.carry import carry_on
from solver.run.frame import largest_safe_damping
from solver.run.load_steps import load_steps_of
from solver.run.loadpath import Run, deadline
from solver.run.slices import in_time

KERNELS = 39  # compiled by `warm_up` where none is in the cache; tests/cli/test_cold_start.py counts them
NICENESS = 10  # the event loop must win against the physics
QUICK, SLOW = 0.3, 10.0  # s of processor time for an increment: of a run that must not be in the way of others, of any
APPROACH = 3  # a slice may take so many times its budget to reach the first frames of the shear
REACH = 1e-3  # of the peak adhesive traction phi_n / (e delta_n): weaker attraction does not count as width that acts


@dataclass(frozen=True)
class Slice(Frames):
    """The outcome of one task.

    ahead: frames still to come, as far as is known, None on the way to where a run carries on; kept: what the next
    slice continues from, pickled, so that the server need not read it; None once the run is done.
    """

    ahead: int | None = None
    kept: bytes | None = None
    done: bool = False
    failure: str | None = None
    heavy: bool = False  # whether an increment takes, or took, longer than QUICK


def start():
    """Prepare a new worker: low priority, kernels loaded."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    warm_up()


class _Compiled(Listener):
    """Counts the kernels that are compiled, into a queue."""

    def __init__(self, queue):
        self.queue, self.count = queue, 0

    def on_start(self, event):
        """Nothing is there yet."""

    def on_end(self, event):
        self.count += 1
        self.queue.put(self.count)


def start_up():
    """As `start`; yields how many kernels have been compiled, where they are not in the cache."""
    compiled = SimpleQueue()
    with install_listener("numba:compile", _Compiled(compiled)), ThreadPoolExecutor(1) as thread:
        done = thread.submit(start)
        done.add_done_callback(lambda _: compiled.put(None))
        yield from iter(compiled.get, None)
        done.result()


def warm_up():
    """Run a small scene through approach, shear and slips, and begin the default one: compiles kernels, makes plans."""
    checkpoint = None
    small = Scene(nodes=128, width=312.5, radius=20.0, u_x_max=16.0)
    while checkpoint is None or not checkpoint.done:
        _, checkpoint = advance(small, checkpoint, 1.0)
    advance(Scene(), None, 0.1)
    transfer(np.ones(1), np.ones(1), 2.0, 1.0, small.nu)


def ready():
    """A task that does nothing."""


@dataclass(frozen=True)
class Carrying:
    """On the way to where a run goes on from another: the legs of the history done, frames of the next, Checkpoint."""

    legs: int = 0
    frames: int = 0
    checkpoint: Checkpoint = field(default_factory=Checkpoint)


def compute(scene, kept, budget, history=(), limit=SLOW):
    """Advance `scene` for about `budget` seconds, somewhat longer if that ends in the approach, and pack the frames.

    kept: of the Slice before, or None; history: ((Scene, frames), ...) of the runs that this one carries on from;
    limit: s of processor time for an increment. One that takes longer is left out, and may be tried again with more.
    """
    begun = perf_counter()
    checkpoint, last = pickle.loads(kept) if kept else (None, None)
    if history and (checkpoint is None or isinstance(checkpoint, Carrying)):
        checkpoint = _on_the_way(scene, checkpoint, begun, budget, history, limit)
        if isinstance(checkpoint, Slice):
            return checkpoint
    frames, checkpoint = _advanced(scene, checkpoint, begun, budget, limit)
    heavy = checkpoint.late or (limit == SLOW and _slow(begun, budget))
    if checkpoint.late and limit < SLOW:
        checkpoint = in_time(checkpoint)
    works, last = _works(scene, frames, last)
    return Slice(
        blocks=packed(scene, list(zip(frames, works, strict=True)), checkpoint.done),
        frames=len(frames),
        ahead=_ahead(scene, checkpoint),
        evaluations=int(sum(frame.evaluations for frame in frames)),
        residual=float(max((frame.residual for frame in frames), default=0.0)),
        widest=max((_width(scene, frame) for frame in frames), default=0.0),
        safe_damping=largest_safe_damping(frames),
        sensitive=any(frame.sensitive for frame in frames),
        kept=None if checkpoint.done else pickle.dumps((checkpoint, last)),
        done=checkpoint.done,
        failure=checkpoint.failure,
        heavy=heavy,
        skeleton=None if history else _skeleton(scene, checkpoint),
    )


def _skeleton(scene, checkpoint):
    """The pickled Skeleton of a run that is done, or None."""
    if checkpoint.done and not checkpoint.failure:
        with suppress(NotFollowed):
            return pickle.dumps(skeleton_from(scene, checkpoint))
    return None


def _on_the_way(scene, way, begun, budget, history, limit):
    """The Checkpoint from which a run goes on from others; or a Slice without frames: not there yet, or no way."""
    try:
        found = carried((*history, (scene, 0)), way or Carrying(), begun + budget, limit)
    except (NotConverged, SceneError, NotInShear) as error:  # the state does not lead on into this scene
        if isinstance(error, OutOfTime) and limit < SLOW:
            return Slice(kept=pickle.dumps((way, None)), heavy=True)
        return Slice(ahead=0, done=True, failure=str(error))
    return Slice(kept=pickle.dumps((found, None)), heavy=_slow(begun, budget)) if isinstance(found, Carrying) else found


def _advanced(scene, checkpoint, begun, budget, limit):
    """(frames, Checkpoint) after the budget, or after APPROACH times that where the shear has not begun."""
    frames, checkpoint = advance(scene, checkpoint, begun + budget - perf_counter(), limit=limit)
    while checkpoint.stage == "approach" and not checkpoint.done and perf_counter() < begun + APPROACH * budget:
        more, checkpoint = advance(scene, checkpoint, budget / APPROACH, limit=limit)
        frames += more
    return frames, checkpoint


def _slow(begun, budget):
    """Whether a slice took so much longer than its budget that its run would be in the way of others."""
    return perf_counter() > begun + budget + QUICK


def carried(history, way=None, until=inf, limit=inf):
    """The checkpoint from which a run goes on as the last scene of history [(scene, frames), ...]: see `carry_on`.

    Every run before is computed again up to the frame at which its successor took over: nothing has to be kept of it.
    Or the Carrying that it has come to by `until`, of perf_counter.
    """
    way = way or Carrying()
    checkpoint, frame = way.checkpoint, None
    for k, ((scene, count), (changed, _)) in enumerate(pairwise(history)):
        if k < way.legs:
            continue
        run = Run(scene)
        for frames in range(way.frames if k == way.legs else 0, count):
            if frame and perf_counter() > until:
                return Carrying(k, frames, checkpoint)
            if checkpoint.done:
                raise NotInShear("the run ended before the increment from which this one should go on")
            frame, checkpoint = run.next_frame(checkpoint, deadline(limit))
        try:
            checkpoint = carry_on(frame, changed) if changed != scene else checkpoint
        except SceneError:
            raise
        except ValueError as error:
            raise NotInShear(str(error)) from None
    return checkpoint


class NotInShear(ValueError):
    """A run goes on from shear only, and from an increment that it has reached."""


def _works(scene, frames, last):
    """The work of the top up to every frame, nJ/m, and (last frame, work up to it); a loop only has use for it."""
    if scene.path != "loop" or not frames:
        return [0.0] * len(frames), None
    before, done = last or (None, 0.0)
    known = [before] if before else []
    works = done + work_of(scene, known + frames).top[len(known) :]
    return works, (frames[-1], works[-1])


def _ahead(scene, checkpoint):
    """Frames still to come."""
    if checkpoint.done:
        return 0
    load_steps = checkpoint.load_steps or load_steps_of(scene)
    place = next(k for k, step in enumerate(load_steps) if step.stage == checkpoint.stage)
    return sum(step.increments + 1 for step in load_steps[place:]) - checkpoint.increment


def _width(scene, frame):
    """Part of w between the outermost nodes that repel or adhere."""
    normal = frame.T[1]
    acting = np.flatnonzero((normal > 0) | (normal < -REACH * scene.phi_n / (e * scene.delta_n)))
    return float(acting[-1] - acting[0] + 1) / scene.nodes if len(acting) else 0.0
