"""Calls in processes of their own, each with a limit of time: a call that hangs or crashes costs a process, no more."""

import os
from collections import deque
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from threading import Thread
from time import monotonic
from traceback import format_exc

# One thread of linear algebra in each process: there are as many of these as cores, and threads would only wait
ONE_THREAD = "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"


@dataclass(frozen=True)
class Lost:
    """A call without a result: kind 'hang', 'crash' or 'error', and what is known of it."""

    kind: str
    reason: str


def outcomes(call, items, workers, limit):
    """Yield (index, call(item) or Lost) as they come; call importable, items picklable, limit in seconds for each."""
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    waiting, desks = deque(enumerate(items)), []
    try:
        desks = [_Desk(call) for _ in range(min(workers, max(1, len(waiting))))]
        while waiting or any(desk.index is not None for desk in desks):
            for desk in desks:
                if desk.index is None and waiting:
                    desk.start(*waiting.popleft(), limit)
            busy = [desk for desk in desks if desk.index is not None]
            ready = wait([desk.pipe for desk in busy], max(0.0, min(desk.due for desk in busy) - monotonic()))
            for desk in busy:
                if desk.pipe in ready or monotonic() >= desk.due:
                    yield desk.finish(limit)
    finally:
        for desk in desks:
            desk.close()


class _Desk:
    """One worker process and the call it is busy with."""

    def __init__(self, call):
        self.call, self.index = call, None
        self._open()

    def _open(self):
        context = get_context("spawn")  # fork copies threads' locks in whatever state they are
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(self.call, theirs), daemon=True)
        self.process.start()
        theirs.close()

    def start(self, index, item, limit):
        self.index, self.due = index, monotonic() + limit
        self.pipe.send(item)

    def finish(self, limit):
        """(index, result) of the call that answered, died or took too long; the last two get a new process."""
        index, self.index = self.index, None
        try:
            if self.pipe.poll():
                return index, self.pipe.recv()
            lost = Lost("hang", f"no answer within {limit:g} s")
        except (EOFError, ConnectionError):
            self.process.join(5.0)
            lost = Lost("crash", f"the process ended with exit code {self.process.exitcode}")
        self.close()
        self._open()
        return index, lost

    def close(self):
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _end_with_parent():
    """End this process when its parent is gone, whatever it is busy with."""
    wait([parent_process().sentinel])
    os._exit(1)


def _work(call, pipe):
    Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            item = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            return
        try:
            result = call(item)
        except Exception:
            result = Lost("error", format_exc(limit=-6))
        pipe.send(result)
