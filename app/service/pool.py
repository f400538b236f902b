"""The worker processes shared by all visitors: spawned, warmed when the server starts, each replaced by itself."""

import atexit
import contextlib
import logging
import multiprocessing
import os
import sys
import threading
from collections import deque
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from app.service import worker

log = logging.getLogger("app")
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
STARTS = 3  # how often in a row a worker may end while it gets ready
spawning = threading.RLock()
GRACE = 2.0  # s: an increment takes up to one; an abandoned task in the way of others for longer ends with its worker


def default_size():
    """One worker per core this process may use, at least two, so that a stale slice never blocks a fresh one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 2
    return int(os.environ.get("APP_WORKERS", max(2, cores)))


@contextlib.contextmanager
def bare_main():
    """Hide `__main__`'s file while a worker is spawned: it would import the server's start script, and so Panel."""
    main = sys.modules["__main__"]
    with spawning:
        file = main.__dict__.pop("__file__", None)
        try:
            yield
        finally:
            if file is not None:
                main.__file__ = file


class Task(Future):
    """A call to be made by a worker; `seat` is where it runs or ran, `abandoned` says that nobody waits for it."""

    def __init__(self, call, background=False):
        super().__init__()
        self.call, self.background, self.seat, self.abandoned = call, background, None, False


class Seat:
    """One worker process with an executor of its own, so that its end disturbs no other; `task` is what it does."""

    def __init__(self):
        self.executor, self.ready, self.task = None, False, None
        self.failures = 0  # to start, in a row

    def spawn(self, probe, wisdom, warmed):
        """A new process; `warmed` is called with (seat, future of `probe`) once it is fit for work."""
        self.ready, self.task = False, None
        context = multiprocessing.get_context("spawn")
        self.executor = ProcessPoolExecutor(1, mp_context=context, initializer=worker.start, initargs=(wisdom,))
        self.run(probe).add_done_callback(lambda future: warmed(self, future))

    def run(self, call, *arguments):
        with bare_main():
            return self.executor.submit(call, *arguments)

    @property
    def processes(self):
        return list((self.executor._processes or {}).values()) if self.executor else []


class Pool:
    """Tasks in order of arrival for a few workers that may die; `status` is 'closed', 'warming' or 'ready'.

    What runs on somebody's screen goes first; sweeps, which fill a page in the background, never take the last worker.
    """

    def __init__(self, size=None):
        self.size = size or default_size()
        self.replaced = 0  # workers lost
        self.wisdom = None  # FFTW's, measured by one worker for all
        self._seats, self._queue = [], deque()
        self._later = deque()  # tasks in the background
        self._lock = threading.RLock()

    @property
    def status(self):
        return "closed" if not self._seats else "ready" if any(seat.ready for seat in self._seats) else "warming"

    @property
    def in_flight(self):
        """How many tasks wait or run for somebody."""
        with self._lock:
            tasks = [*self._queue, *self._later, *(seat.task for seat in self._seats)]
            return sum(task is not None and not task.abandoned and not task.done() for task in tasks)

    def start(self):
        """Spawn the first worker, which compiles the kernels or finds them, then the others; harmless when done."""
        with self._lock:
            if not self._seats:
                for name in ONE_THREAD:  # read by the workers when they import NumPy
                    os.environ.setdefault(name, "1")
                self._seats = [Seat() for _ in range(self.size)]
                atexit.register(self.close)
            if all(seat.executor is None for seat in self._seats):
                self._seats[0].spawn(worker.ready, self.wisdom, self._warmed)

    def _warmed(self, seat, probe):
        """A worker is fit: let the others follow; the second also measures FFTW's plans while the first works."""
        with self._lock:
            if seat not in self._seats:
                return
            if probe.cancelled() or probe.exception() is not None:
                return self._not_started(seat)
            if self.status != "ready":
                log.info("workers are warm")
            seat.ready, seat.failures = True, 0
            self._share(probe.result())
            idle = [other for other in self._seats if other.executor is None]
            for number, other in enumerate(idle):
                measures = number == 0 and self.wisdom is None
                other.spawn(worker.measure if measures else worker.ready, self.wisdom, self._warmed)
        self._dispatch()

    def _not_started(self, seat):
        """A worker ended while it got ready; where that goes on, those who wait are told."""
        seat.failures += 1
        if seat.failures < STARTS:
            return self._replace(seat)
        seat.executor = None
        while (self._queue or self._later) and all(other.executor is None for other in self._seats):
            task = (self._queue or self._later).popleft()
            if task.set_running_or_notify_cancel():
                task.set_exception(BrokenProcessPool("no worker can be started"))

    def _share(self, wisdom):
        """What one worker has measured, the others that are at work learn between two tasks."""
        if wisdom is not None:
            self.wisdom = wisdom
            for seat in self._seats:
                if seat.ready:
                    with contextlib.suppress(BrokenProcessPool):
                        seat.run(worker.learn, wisdom)

    def submit(self, call, *arguments, near=None, background=False):
        """A Task, done by the worker that did the task `near` if that is idle: it still has the plans.

        background: only when no other task waits, and on all workers but one. It raises BrokenProcessPool if its worker
        died: submit again. Cancel it while it waits, `abandon` it when not.
        """
        self.start()
        task = Task((call, *arguments), background)
        task.seat = near and near.seat
        with self._lock:
            (self._later if background else self._queue).append(task)
        self._dispatch()
        return task

    def _dispatch(self):
        """Give waiting tasks to idle workers."""
        with self._lock:
            while idle := [seat for seat in self._seats if seat.ready and seat.task is None]:
                task = self._next()
                if task is None:
                    break
                if task.set_running_or_notify_cancel():
                    self._place(task, task.seat if task.seat in idle else idle[0])

    def _next(self):
        """The task whose turn it is, taken from its queue, or None."""
        if self._queue:
            return self._queue.popleft()
        busy = sum(seat.task is not None and seat.task.background for seat in self._seats)
        return self._later.popleft() if self._later and busy < max(1, len(self._seats) - 1) else None

    def _place(self, task, seat):
        try:
            running = seat.run(*task.call)
        except BrokenProcessPool:  # died while idle
            self._replace(seat)
            task.set_exception(BrokenProcessPool("the worker had died"))
            return
        task.seat, seat.task = seat, task
        running.add_done_callback(lambda future: self._landed(seat, task, future))

    def _landed(self, seat, task, future):
        """Called in a thread of the seat's executor."""
        error = BrokenProcessPool("the pool was closed") if future.cancelled() else future.exception()
        with self._lock:
            if seat.task is task:
                seat.task = None
                if isinstance(error, BrokenProcessPool) and seat in self._seats:
                    self._replace(seat)
        if error is None:
            task.set_result(future.result())
        else:
            task.set_exception(error)
        self._dispatch()

    def abandon(self, task):
        """Nobody waits for this task any longer; its worker is killed if that does not help waiting ones in time."""
        if not task.cancel():
            task.abandoned = True
            timer = threading.Timer(GRACE, self._make_room, (task,))
            timer.daemon = True
            timer.start()

    def _make_room(self, task):
        with self._lock:
            if self._queue and not task.done() and task.seat in self._seats:
                log.warning("a worker stuck in an abandoned slice is replaced")
                for process in task.seat.processes:
                    process.kill()

    def _replace(self, seat):
        log.warning("a worker ended; a new one is starting")
        seat.executor.shutdown(wait=False, cancel_futures=True)
        self.replaced += 1
        seat.spawn(worker.ready, self.wisdom, self._warmed)

    def processes(self):
        """The process ids of the workers."""
        with self._lock:
            return [process.pid for seat in self._seats for process in seat.processes]

    def close(self):
        """End every worker at once, even in the middle of a slice."""
        with self._lock:
            seats, self._seats = self._seats, []
            waiting, self._queue, self._later = [*self._queue, *self._later], deque(), deque()
        for task in waiting:
            task.cancel()
        workers = [process for seat in seats for process in seat.processes]
        for seat in seats:
            if seat.executor:
                seat.executor.shutdown(wait=False, cancel_futures=True)
        for process in workers:
            process.terminate()
        for process in workers:
            process.join(5)
        atexit.unregister(self.close)


pool = Pool()
