"""What tests of the solver share."""

import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed

import numpy as np
from threadpoolctl import threadpool_info

from app.service.caller import Caller, Lost
from solver import load_path
from solver.run.loadpath import Run

PATIENCE = 300  # s; a limit against hanging, not a claim about speed


def until(condition):
    """Wait for it."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.005)


def stage(frames, name):
    return [f for f in frames if f.stage == name]


def same(a, b, error):
    """Whether two frames agree on the nodes that both keep; the others carry no traction in either."""
    first, last = max(a.first, b.first), min(a.first + a.u.shape[1], b.first + b.u.shape[1])
    u, v = (f.u[:, first - f.first : last - f.first] for f in (a, b))
    return bool(np.abs(u - v).max() < error)


def tractions(nodes, seed=0):
    return np.random.default_rng(seed).normal(size=(2, nodes))


def blas_threads():
    """Numbers of threads of the BLAS libraries of this process, as a set."""
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def peculiar(item):
    """Returns, raises, dies or hangs, as told; at module level, for processes of their own."""
    if item == "raise":
        raise ValueError(item)
    if item == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if item == "pid":
        return os.getpid()
    if item == "hang":
        time.sleep(600.0)
    return item


def outcomes(call, items, workers=None, limit=600.0):
    """Yields (index, call(item) or Lost) in the order of completion, from processes that are replaced when lost."""
    own = threading.local()
    callers = []

    def computed(k, item):
        if getattr(own, "caller", None) is None:
            own.caller = Caller()
            callers.append(own.caller)
        try:
            return k, own.caller.call(call, item, limit=limit)
        except Lost as lost:
            if lost.kind != "error":
                own.caller = None
            return k, lost

    with ThreadPoolExecutor(workers or os.cpu_count()) as threads:
        try:
            for future in as_completed([threads.submit(computed, k, item) for k, item in enumerate(items)]):
                yield future.result()
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            for caller in callers:
                caller.end()


def outcomes_beside_a_hang(call, items, workers, hanging):
    """{index: call(item) or Lost}, where the call of index `hanging` never ends.

    With a longer limit if that has cut off others, as on a slow machine it may: it includes the start of a process.
    """
    for limit in (10.0, 60.0, PATIENCE):
        found = dict(outcomes(call, items, workers, limit))
        if not any(isinstance(found[k], Lost) and found[k].kind == "hang" for k in found if k != hanging):
            break
    return found


def on_whole_cell(scene, replay=True):
    """The frames of a run on all nodes of the cell, not on a patch."""
    run = Run(scene, replay=replay)
    run.patch = (0, scene.nodes)
    return [frame for frame, _ in run.frames()]


def first_slip(scene):
    """(the frame before, the frame with the first slip in shear, the SlipEvent)."""
    before = None
    for frame in load_path(scene):
        if frame.stage == "shear" and frame.slip:
            return before, frame, frame.slips[0]
        before = frame
    raise AssertionError("no slip")
