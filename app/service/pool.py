"""The worker processes that all visitors share. They warm up when the server starts; each slot replaces a lost worker.

Others use only `submit`, `move_up`, `abandon`, `position`, `status` and `why`. A worker is a process of this machine,
or any object with the methods of `app.service.caller.Caller` that this module calls: with APP_SCHEDULER it is a worker
of a dask cluster (`app.service.cluster`).
"""

import atexit
import logging
import os
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from multiprocessing import set_forkserver_preload
from threading import Condition, Event, Thread, Timer
from time import monotonic
from typing import Any

from app.environment import CLUSTER, WORKERS
from app.service import metrics, worker
from app.service.caller import Caller, Lost
from app.service.cluster import Cluster
from app.service.fair_queue import FairQueue
from app.service.job import EXACT, HEAVY, LATER, NOBODY, SCREEN, Job

log = logging.getLogger("app")
set_forkserver_preload([worker.__name__])  # imports take two thirds of a worker's start
PATIENCE = 20.0  # s beyond the time that a call should take; then its process is killed. A busy server is slow
LOOK = 0.5  # s between two checks that the process of an idle worker lives
WARMING = 300.0  # s to compile the kernels on a slow machine
STARTS = 3  # failed starts of a slot in a row before waiting jobs fail
GIVE_UP = 60.0  # s since a worker was last ready before waiting jobs fail
SILENT = 60.0  # s without an answer of any worker before the pool counts as dead
MOST_WORKERS = 16  # of a cluster, by default; a slot without a worker looks for one every few seconds
OPEN = (
    "APP_SCHEDULER is a tcp:// address: whoever reaches this scheduler can run any code on it and its workers."
    " Use it in a trusted network only, or use tls://"
)
STOPS = 10.0  # s that a cancelled call may still take. After that its process is killed
STOPPED = "the server is being stopped"
TRIES = 10  # messages within STOPS that ask for it: the first may come before the call does
PAUSES = (0.0, 0.5, 1.0, 2.0, 5.0)  # s before the next start of a worker, by failed starts in a row


def default_size() -> int:
    """Return one worker per available core, at least two, so that an outdated slice never blocks a new one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 2
    return WORKERS or max(2, cores)


@dataclass(eq=False)
class WorkerSlot:
    """A slot for one worker process, with a thread that starts the worker."""

    caller: Any = None
    ready: bool = False
    job: Job | None = None  # that it runs
    failures: int = 0  # failed starts in a row


class Pool:
    """Workers that may die and jobs that may hang; `status` is 'closed', 'warming', 'ready' or 'failing' (see `why`).

    Owners take turns. Neither expensive jobs nor those in the background take the last worker, though both together
    may: one in the background soon ends.
    """

    def __init__(self, size: int | None = None, patience: float = PATIENCE, make: Callable[[], Any] = Caller) -> None:
        self.size, self.patience, self.make = size or default_size(), patience, make
        self.replaced = 0  # workers lost
        self.why = ""  # why no worker can start
        self.compiled = 0  # kernels that the first worker has compiled, of worker.KERNELS
        self._slots, self._queue = [], FairQueue()
        self._lock = Condition()  # notifies slots of jobs and of the end
        self._closing, self._warm = Event(), Event()
        self._answered = -inf  # time of the last answer of a worker, s, monotonic
        self._last_ready = -inf  # time when a worker was last ready, s, monotonic

    @property
    def status(self) -> str:
        if not self._slots:
            return "closed"
        return "ready" if any(slot.ready for slot in self._slots) else "failing" if self.why else "warming"

    @property
    def ready(self) -> int:
        """Number of workers that are ready."""
        return sum(slot.ready for slot in self._slots)

    @property
    def in_flight(self) -> int:
        """Number of jobs that wait or run for visitors."""
        with self._lock:
            jobs = [job for job in (*self._queue, *(slot.job for slot in self._slots)) if job is not None]
            return sum(job.owner != NOBODY and not job.done() for job in jobs)

    def start(self) -> None:
        """Start the first worker, which compiles or loads the kernels, then the others; may be called twice."""
        with self._lock:
            if self._slots or self._closing.is_set():
                return
            self._answered = monotonic() + WARMING - SILENT  # no answer is due before the warm-up ends
            self._slots = [WorkerSlot() for _ in range(self.size)]
            for number, slot in enumerate(self._slots):
                Thread(target=self._run_slot, args=(slot, number), name=f"slot {number}", daemon=True).start()
        atexit.register(self.close)

    def submit(self, job: Job) -> Job:
        """Add a job to the queue, and return it."""
        self.start()
        with self._lock:
            takes = not (self._closing.is_set() or self.why)
            if takes and not job.done():
                self._queue.add(job)
                self._dispatch()
        if not takes:
            self._pass_on(job, Lost("closed", self.why or STOPPED))
        return job

    def move_up(self, job: Job, owner: object, rank: int) -> None:
        """Give a job the rank of an owner who needs it sooner."""
        with self._lock:
            waits = self._queue.remove(job)
            job.owner, job.rank = owner, rank
            if waits:
                self._queue.add(job)
                self._dispatch()

    def abandon(self, job: Job) -> None:
        """Cancel a job. One that waits leaves the queue at once, and what a running one returns is ignored.

        One that may take long is also stopped: a generator at its next item, others after STOPS with their worker.
        """
        job.cancel()
        with self._lock:
            self._queue.remove(job)
            caller = job.slot.caller if job.slot and job.seconds >= STOPS else None
        if caller:
            self._stop(job, caller, TRIES)

    def _stop(self, job, caller, tries):
        """Stop a job, again and again, as its worker may not have heard of it yet; then end its worker."""
        with self._lock:
            if job.slot is None or job.slot.caller is not caller:
                return
            if tries:
                caller.stop()
        if not tries:
            return caller.end()
        timer = Timer(STOPS / TRIES, self._stop, (job, caller, tries - 1))
        timer.daemon = True
        timer.start()

    def position(self, job: Job) -> int | None:
        """Number of jobs before this one; None if it does not wait."""
        with self._lock:
            return self._queue.position(job)

    def alive(self) -> tuple[bool, str]:
        """Return (healthy, reason). Healthy: a worker answered lately, or an idle worker's process lives."""
        if self.why:
            return False, self.why
        with self._lock:
            idle = any(slot.ready and slot.job is None and slot.caller.alive() for slot in self._slots)
            silent = monotonic() - self._answered
        if idle or silent <= SILENT:
            return True, ""
        return False, f"no worker has answered for {min(silent, 1e6):.0f} s"

    def processes(self) -> list[int]:
        """Process ids of the workers on this machine."""
        with self._lock:
            return [slot.caller.process.pid for slot in self._slots if isinstance(slot.caller, Caller)]

    def close(self) -> None:
        """End every worker at once, even during a slice."""
        self._closing.set()
        self._warm.set()
        atexit.unregister(self.close)
        with self._lock:
            slots, self._slots = self._slots, []
            waiting, self._queue = self._queue, FairQueue()
            callers = [slot.caller for slot in slots if slot.caller]
            self._lock.notify_all()
        for caller in callers:
            caller.end()
        for job in waiting:
            self._pass_on(job, Lost("closed", STOPPED))

    def _dispatch(self):
        """Give the next jobs to idle workers."""
        while idle := [slot for slot in self._slots if slot.ready and slot.job is None]:
            job = self._queue.take({SCREEN, EXACT} | {rank for rank in (HEAVY, LATER) if self._spare(rank)})
            if job is None:
                break
            if not job.done():  # it was cancelled before it came
                job.slot, idle[0].job = idle[0], job
                self._lock.notify_all()

    def _spare(self, rank):
        """Return whether jobs of a rank leave a worker to others, if one more is started."""
        expected = sum(slot.failures < STARTS for slot in self._slots)
        free = sum(slot.ready and (slot.job is None or slot.job.queued != rank) for slot in self._slots)
        return free > (expected > 1)

    # The following methods run in the thread of a slot.

    def _run_slot(self, slot, number):
        """Run a worker in the slot, and replace it when lost, until the pool closes."""
        if number:
            self._warm.wait()
        while not self._closing.wait(PAUSES[min(slot.failures, len(PAUSES) - 1)]):
            try:
                self._start_worker(slot)
                self._serve(slot)
            except Lost as lost:
                self._worker_lost(slot, lost)
            except Exception as error:  # the process did not start
                log.exception("a worker could not be started")
                self._worker_lost(slot, Lost("crash", str(error)))

    def _start_worker(self, slot):
        """Start a worker and make it ready."""
        slot.caller = self.make()
        if self._closing.is_set():  # `close` may have run before the caller existed
            slot.caller.end()
        slot.caller.call(worker.start_up, limit=WARMING, hear=self._count_kernels)
        with self._lock:
            if self.status != "ready":
                log.info("workers are warm")
            slot.ready, slot.failures, self.why, self._last_ready = True, 0, "", monotonic()
            self._answered = monotonic()
        self._warm.set()

    def _count_kernels(self, compiled):
        self.compiled = max(self.compiled, compiled)

    def _serve(self, slot):
        """Run jobs until the worker is lost."""
        while True:
            with self._lock:
                self._dispatch()
                while slot.job is None:
                    self._lock.wait(LOOK)
                    if self._closing.is_set():
                        raise Lost("closed", STOPPED)
                    if not slot.caller.alive():
                        raise Lost("crash", "the process ended while it was idle")
            self._run(slot, slot.job)

    def _run(self, slot, job):
        """Make one call of a job."""
        hear = job.heard if job.streams else None
        try:
            made = slot.caller.call(*job.call, *job.state, limit=job.seconds + self.patience, hear=hear)
        except Lost as lost:
            if lost.kind != "error":
                raise
            log.error("a call failed in a worker:\n%s", lost.reason)
            made = lost
        with self._lock:
            slot.job = job.slot = None
            self._answered = monotonic()
        metrics.count("tasks")
        self._pass_on(job, made)

    def _pass_on(self, job, made):
        """Give a job what its call has returned, or the Lost of its worker."""
        if not job.done() and job.returned(made):
            self.submit(job)
        job.tell()

    def _worker_lost(self, slot, lost):
        """Pass the loss of a worker on to its job; after STARTS failed starts all waiting jobs fail."""
        if slot.caller is not None:
            slot.caller.end()
        with self._lock:
            job, slot.job = slot.job, None
            if job:
                job.slot = None
            warm, slot.ready, slot.caller = slot.ready, False, None
            if self._closing.is_set():
                lost = Lost("closed", STOPPED)
            else:
                slot.failures += not warm
                if lost.kind != "absent":  # no worker of the cluster is free yet
                    self.replaced += 1
                    metrics.count("worker_restarts")
                    log.warning("a worker is replaced (%s): %s", lost.kind, lost.reason)
            if warm:
                self._last_ready = monotonic()
            no_worker = slot.failures >= STARTS and monotonic() > self._last_ready + GIVE_UP
            no_worker = no_worker and not any(other.ready for other in self._slots)
            waiting = ()
            if no_worker:
                self.why = getattr(self.make, "why", "no worker process can be started; the server's log says why")
                waiting, self._queue = self._queue, FairQueue()
        for other in waiting:
            self._pass_on(other, Lost("closed", self.why))
        if job:
            metrics.count("tasks_lost")
            self._pass_on(job, lost)


def made() -> Pool:
    """Return the pool that the environment variables select."""
    if CLUSTER is None:
        return Pool()
    if CLUSTER.startswith("tcp://"):
        log.warning(OPEN)
    return Pool(WORKERS or MOST_WORKERS, make=Cluster(CLUSTER))


pool = made()
metrics.gauge("queue", "jobs that wait or run for visitors", lambda: pool.in_flight)
metrics.gauge("workers", "workers that are ready", lambda: pool.ready)
