"""A run in slices: a few Frames at a time, each from the Checkpoint that the one before left."""

from dataclasses import replace
from math import inf
from threading import Lock
from time import perf_counter

from ..continuation.state import NotConverged, OutOfTime
from .loadpath import Checkpoint, Run
from .shortcuts import ALL

KEPT = 4  # runs whose buffers are kept for the next slice


def advance(scene, checkpoint=None, budget=0.04, method="fast", leave_out=ALL, limit=inf):
    """(frames, checkpoint): the Frames that follow `checkpoint` (None: the first ones), for about `budget` seconds.

    A pure function of picklable arguments, for use in a worker; at least one frame, unless the increment fails:
    then checkpoint.failure says where and what to do. limit: processor time for one increment, s.
    """
    checkpoint = owned(checkpoint) if checkpoint else Checkpoint()
    frames, end = [], perf_counter() + budget
    with _borrowed(scene, method, leave_out) as run:
        while not checkpoint.done:
            try:
                frame, checkpoint = run.next_frame(checkpoint, limit)
            except NotConverged as failure:
                late = isinstance(failure, OutOfTime)
                return frames, replace(checkpoint, done=True, failure=str(failure), late=late)
            frames.append(frame)
            if perf_counter() > end:
                break
    return frames, checkpoint


def in_time(checkpoint):
    """The Checkpoint before the increment that a run had no time for, from one whose `late` is set."""
    state = checkpoint.state and replace(checkpoint.state, secants=None)  # those of the attempt lead elsewhere
    return replace(checkpoint, state=state, done=False, failure=None, late=False)


def owned(checkpoint):
    """The checkpoint with secant pairs of its own, so that going on from it leaves the given one as it is."""
    state = checkpoint.state
    if state is None:
        return checkpoint
    own = replace(state, secants=state.secants and state.secants.copy(), record=state.record and state.record.copy())
    return replace(checkpoint, state=own)


def next_frame(scene, checkpoint, method="fast", leave_out=ALL, limit=inf):
    """(frame, checkpoint) of the increment that `checkpoint` stands before; may change the latter's arrays."""
    with _borrowed(scene, method, leave_out) as run:
        return run.next_frame(checkpoint, limit)


class _borrowed:
    """A Run of its own for the time of a `with`: buffers are dear, so idle Runs are kept, each for one thread."""

    _idle, _lock = [], Lock()

    def __init__(self, *key):
        self._key = key

    def __enter__(self):
        with self._lock:
            for k, (key, run) in enumerate(self._idle):
                if key == self._key:
                    del self._idle[k]
                    self._run = run
                    return run
        self._run = Run(*self._key)
        return self._run

    def __exit__(self, *_):
        with self._lock:
            self._idle.append((self._key, self._run))
            del self._idle[:-KEPT]
