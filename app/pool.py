"""The worker processes shared by all visitors: spawned, warmed when the server starts, replaced when one dies."""

import atexit
import contextlib
import logging
import multiprocessing
import os
import sys
import threading
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from app import worker

log = logging.getLogger("app")
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def default_size():
    """One worker per core this process may use, at least two, so that a stale slice never blocks a fresh one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 2
    return int(os.environ.get("APP_WORKERS", max(2, cores)))


@contextlib.contextmanager
def _bare_main():
    """Hide `__main__`'s file while a worker is spawned: it would import the server's start script, and so Panel."""
    main = sys.modules["__main__"]
    file = main.__dict__.pop("__file__", None)
    try:
        yield
    finally:
        if file is not None:
            main.__file__ = file


class Pool:
    """A process pool that outlives its workers; `status` is 'closed', 'warming' or 'ready'."""

    def __init__(self, size=None):
        self.size = size or default_size()
        self.status = "closed"
        self.in_flight = 0
        self.replaced = 0  # pools lost to a dead worker
        self._lock = threading.RLock()
        self._executor = None

    def start(self):
        """Spawn the workers; harmless when they run already."""
        with self._lock:
            if self._executor is None:
                for name in ONE_THREAD:  # read by the workers when they import NumPy
                    os.environ.setdefault(name, "1")
                self._spawn()
                atexit.register(self.close)

    def _spawn(self):
        self.status = "warming"
        context = multiprocessing.get_context("spawn")
        self._executor = ProcessPoolExecutor(self.size, mp_context=context, initializer=worker.start)
        with _bare_main():
            probe = self._executor.submit(worker.ready)
        probe.add_done_callback(self._warmed)

    def _warmed(self, probe):
        """The first worker has compiled the kernels or found them: start the others, which find them in the cache."""
        if probe.cancelled() or probe.exception() is not None:
            return
        with self._lock:
            if self._executor is None:
                return
            self.status = "ready"
            log.info("workers are warm")
            with contextlib.suppress(BrokenProcessPool, RuntimeError), _bare_main():
                for _ in range(self.size):
                    self._executor.submit(worker.ready)

    def submit(self, task, *arguments):
        """A future of `task(*arguments)`; if it raises BrokenProcessPool, call `recover(future)` and submit again."""
        with self._lock:
            self.start()
            try:
                future = self._submit(task, arguments)
            except BrokenProcessPool:
                self._replace()
                future = self._submit(task, arguments)
            self.in_flight += 1
        future.add_done_callback(self._landed)
        return future

    def _submit(self, task, arguments):
        with _bare_main():
            future = self._executor.submit(task, *arguments)
        future.executor = self._executor  # which generation of workers computes it
        return future

    def _landed(self, future):
        with self._lock:
            self.in_flight -= 1

    def recover(self, future):
        """Replace the workers among which one died while computing `future`; once, however many slices were lost."""
        with self._lock:
            if future.executor is self._executor:
                self._replace()

    def _replace(self):
        log.warning("a worker died; new workers are starting")
        self._executor.shutdown(wait=False, cancel_futures=True)
        self.replaced += 1
        self._spawn()

    def processes(self):
        """The process ids of the workers."""
        with self._lock:
            return [] if self._executor is None else list(self._executor._processes or ())

    def close(self):
        """End every worker at once, even in the middle of a slice."""
        with self._lock:
            executor, self._executor, self.status = self._executor, None, "closed"
        if executor is None:
            return
        atexit.unregister(self.close)
        workers = list((executor._processes or {}).values())
        executor.shutdown(wait=False, cancel_futures=True)
        for process in workers:
            process.terminate()
        for process in workers:
            process.join(5)


pool = Pool()
