"""The worker processes shared by all visitors: warmed when the server starts, each in a seat that fills itself again.

The interface is all that a visitor's session and its pages know: `submit` of a pure function of picklable arguments,
`abandon`, `place`, `status` and `why`. What sits in a seat is a process of this machine, or whatever else has the
methods of `solver.isolated.Caller` that are used here: with APP_SCHEDULER a worker of a dask cluster (cluster.py).
"""

import atexit
import logging
import os
from dataclasses import dataclass
from math import inf
from multiprocessing import set_forkserver_preload
from threading import Condition, Event, Thread
from time import monotonic
from typing import Any

from app.service import metrics, worker
from app.service.fair_queue import EXACT, HEAVY, LATER, NOBODY, PATIENCE, SCREEN, FairQueue, Task
from solver.isolated import Caller, Lost

log = logging.getLogger("app")
set_forkserver_preload([worker.__name__])  # two thirds of a worker's start are imports
__all__ = ["EXACT", "HEAVY", "LATER", "NOBODY", "SCREEN", "FairQueue", "Pool", "Task", "pool"]
LOOK = 0.5  # s between two looks whether the process of an idle worker still is
WARMING = 300.0  # s for kernels to be compiled, on a slow machine
STARTS = 3  # times in a row that a seat may fail to start a worker before those who wait are told
HOPE = 60.0  # s since a worker was last ready, before which they are not told
SILENT = 60.0  # s without an answer of any worker, after which the pool counts as dead
PAUSES = (0.0, 0.5, 1.0, 2.0, 5.0)  # s before a worker is started once more, by how often in a row that failed


def default_size():
    """One worker per core this process may use, at least two, so that a stale slice never blocks a fresh one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 2
    return int(os.environ.get("APP_WORKERS", max(2, cores)))


@dataclass(eq=False)
class Seat:
    """Room for one worker process, with a thread that fills it; `task` is what it does."""

    caller: Any = None
    ready: bool = False
    task: Task | None = None
    failures: int = 0  # starts in a row


class Pool:
    """Workers that may die and tasks that may hang; `status` is 'closed', 'warming', 'ready' or 'failing' (see `why`).

    Owners take turns. What takes long, and what nobody looks at yet, never takes the last worker.
    """

    def __init__(self, size=None, patience=PATIENCE, make=Caller):
        self.size, self.patience, self.make = size or default_size(), patience, make
        self.replaced = 0  # workers lost
        self.why = ""  # no worker can be started
        self.compiled = 0  # kernels, of worker.KERNELS, by the first worker
        self._seats, self._queue = [], FairQueue()
        self._lock = Condition()  # notified when seats have been given tasks, and of the end
        self._closing, self._warm = Event(), Event()
        self._answered = -inf  # when a worker last gave an answer, s, monotonic
        self._fit = -inf  # when a worker was last known to be fit, s, monotonic

    @property
    def status(self):
        if not self._seats:
            return "closed"
        return "ready" if any(seat.ready for seat in self._seats) else "failing" if self.why else "warming"

    @property
    def ready(self):
        """How many workers are."""
        return sum(seat.ready for seat in self._seats)

    @property
    def in_flight(self):
        """How many tasks wait or run for somebody."""
        with self._lock:
            tasks = [task for task in (*self._queue, *(seat.task for seat in self._seats)) if task is not None]
            return sum(task.owner != NOBODY and not task.abandoned and not task.done() for task in tasks)

    def start(self):
        """Start the first worker, which compiles the kernels or finds them, then the others; harmless when done."""
        with self._lock:
            if self._seats or self._closing.is_set():
                return
            self._answered = monotonic() + WARMING - SILENT  # until then nobody expects one
            self._seats = [Seat() for _ in range(self.size)]
            for number, seat in enumerate(self._seats):
                Thread(target=self._sit, args=(seat, number), name=f"seat {number}", daemon=True).start()
        atexit.register(self.close)

    def submit(self, call, *arguments, owner=None, rank=SCREEN, seconds=0.0):
        """A Task of that owner.

        seconds: what it is expected to take at most. Cancel it while it waits, `abandon` it when not.
        """
        self.start()
        task = Task((call, *arguments), owner, rank, seconds + self.patience)
        with self._lock:
            if self._closing.is_set() or self.status == "failing":
                task.set_exception(Lost("closed", self.why or "the server is being stopped"))
            else:
                self._queue.add(task)
                self._dispatch()
        return task

    def abandon(self, task):
        """Nobody waits for this task any longer."""
        if not task.cancel():
            task.abandoned = True

    def position(self, task):
        """How many tasks have their turn before this one; None if it does not wait."""
        with self._lock:
            return self._queue.position(task)

    def alive(self):
        """(whether a worker has answered lately, or one is idle whose process lives, what is to be said of it)."""
        if self.why:
            return False, self.why
        with self._lock:
            idle = any(seat.ready and seat.task is None and seat.caller.alive() for seat in self._seats)
            silent = monotonic() - self._answered
        if idle or silent <= SILENT:
            return True, ""
        return False, f"no worker has answered for {min(silent, 1e6):.0f} s"

    def processes(self):
        """The process ids of the workers on this machine."""
        with self._lock:
            return [seat.caller.process.pid for seat in self._seats if isinstance(seat.caller, Caller)]

    def close(self):
        """End every worker at once, even in the middle of a slice."""
        self._closing.set()
        self._warm.set()
        atexit.unregister(self.close)
        with self._lock:
            seats, self._seats = self._seats, []
            waiting, self._queue = self._queue, FairQueue()
            callers = [seat.caller for seat in seats if seat.caller]
            self._lock.notify_all()
        for task in waiting:
            task.cancel()
        for caller in callers:
            caller.end()

    def _dispatch(self):
        """Give idle workers the tasks whose turn it is."""
        while idle := [seat for seat in self._seats if seat.ready and seat.task is None]:
            rank = self._queue.rank
            free = sum(seat.ready and (seat.task is None or seat.task.rank <= EXACT) for seat in self._seats)
            hoped = sum(seat.failures < STARTS for seat in self._seats)
            if rank is None or (rank > EXACT and free <= (hoped > 1)):
                break
            task = self._queue.take()
            if task.set_running_or_notify_cancel():
                task.seat, idle[0].task = idle[0], task
                self._lock.notify_all()

    # a seat, in its thread

    def _sit(self, seat, number):
        """Keep a worker in the seat until the pool is closed."""
        if number:
            self._warm.wait()
        while not self._closing.wait(PAUSES[min(seat.failures, len(PAUSES) - 1)]):
            try:
                self._fill(seat)
                self._serve(seat)
            except Lost as lost:
                self._emptied(seat, lost)
            except Exception as error:  # no process could be started
                log.exception("a worker could not be started")
                self._emptied(seat, Lost("crash", str(error)))

    def _fill(self, seat):
        """Start a worker and make it ready."""
        seat.caller = self.make()
        if self._closing.is_set():  # it may have come too late to be ended by `close`
            seat.caller.end()
        if isinstance(seat.caller, Caller):
            seat.caller.call(worker.start_up, limit=WARMING, hear=self._hear)
        else:
            seat.caller.call(worker.start, limit=WARMING)
        with self._lock:
            if self.status != "ready":
                log.info("workers are warm")
            seat.ready, seat.failures, self.why, self._fit = True, 0, "", monotonic()
            self._answered = monotonic()
        self._warm.set()

    def _hear(self, compiled):
        self.compiled = max(self.compiled, compiled)

    def _serve(self, seat):
        """Do tasks until the worker is lost."""
        while True:
            with self._lock:
                self._dispatch()
                while seat.task is None:
                    self._lock.wait(LOOK)
                    if self._closing.is_set():
                        raise Lost("closed", "the server is being stopped")
                    if not seat.caller.alive():
                        raise Lost("crash", "the process ended while it was idle")
            self._do(seat)

    def _do(self, seat):
        task = seat.task
        try:
            result = seat.caller.call(*task.call, limit=task.limit)
        except Lost as lost:
            if lost.kind != "error":
                raise
            log.error("a task failed in a worker:\n%s", lost.reason)
            result = lost
        with self._lock:
            seat.task, self._answered = None, monotonic()
        self._settle(task, result)

    def _settle(self, task, result):
        metrics.count("tasks_lost" if isinstance(result, Lost) and result.kind != "error" else "tasks")
        if isinstance(result, Lost):
            task.set_exception(result)
        else:
            task.set_result(result)

    def _emptied(self, seat, lost):
        """The worker has ended, or did not start: those who wait for it are told, or wait again."""
        if seat.caller is not None:
            seat.caller.end()
        with self._lock:
            task, seat.task = seat.task, None
            warm, seat.ready, seat.caller = seat.ready, False, None
            if self._closing.is_set():
                lost = Lost("closed", "the server is being stopped")
            else:
                seat.failures += not warm
                if lost.kind != "absent":  # a seat for which there is nobody yet
                    self.replaced += 1
                    metrics.count("worker_restarts")
                    log.warning("a worker is replaced (%s): %s", lost.kind, lost.reason)
            if warm:
                self._fit = monotonic()
            hopeless = seat.failures >= STARTS and monotonic() > self._fit + HOPE
            hopeless = hopeless and not any(other.ready for other in self._seats)
            waiting = ()
            if hopeless:
                self.why = getattr(self.make, "why", "no worker process can be started; the server's log says why")
                waiting, self._queue = self._queue, FairQueue()
        if task is not None:
            self._settle(task, lost)
        for other in waiting:
            if other.set_running_or_notify_cancel():
                other.set_exception(Lost("closed", self.why))


def made():
    """The pool that the environment asks for."""
    if "APP_SCHEDULER" not in os.environ:
        return Pool()
    from app.service.cluster import SEATS, Cluster

    return Pool(int(os.environ.get("APP_WORKERS", SEATS)), make=Cluster(os.environ["APP_SCHEDULER"]))


pool = made()
metrics.gauge("queue", "tasks that wait or run for somebody", lambda: pool.in_flight)
metrics.gauge("workers", "workers that are ready", lambda: pool.ready)
