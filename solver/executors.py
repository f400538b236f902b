"""Many calls on any `concurrent.futures.Executor`: processes of this machine, or a cluster with an executor of its own.

For dask that is `distributed.Client(address).get_executor()`.
"""

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from multiprocessing import current_process, get_context
from typing import Any

# processes as many as cores need no further threads
ONE_THREAD = "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"


def processes(count: int | None = None) -> ProcessPoolExecutor:
    """An executor of `count` processes, by default one for each core.

    A plain fork would copy the locks of threads. On Linux a server without threads, which has imported the solver, is
    forked instead. Call this under `if __name__ == "__main__":`, as each process imports the script that runs.
    """
    if getattr(current_process(), "_inheriting", False):
        raise SystemExit(1)  # this process imports a script without that line; `explore_map` reports it
    if sys.platform != "linux":
        return ProcessPoolExecutor(count, mp_context=get_context("spawn"))
    from multiprocessing import forkserver  # Windows has none

    with _one_thread_each():
        forkserver.set_forkserver_preload(["solver.analysis.maps.task"])
        forkserver.ensure_running()
    return ProcessPoolExecutor(count, mp_context=get_context("forkserver"))


@contextmanager
def _one_thread_each():
    """The environment tells libraries that a process which starts now loads to use one thread."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            os.environ.update({name: value} if value is not None else {})


def outcomes(
    call: Callable, items: Iterable[Any], executor: Executor, ahead: int | None = None
) -> Iterator[tuple[Any, Any]]:
    """Yields (item, call(item) or the exception that it raised) in the order of completion.

    items: taken one by one as calls end, so that one may depend on the outcomes before. ahead: how many calls the
    executor has at a time, by default as many as there are cores.
    """
    left, running = iter(items), dict[Future, Any]()
    try:
        while True:
            for item in islice(left, (ahead or os.cpu_count() or 1) - len(running)):
                running[_submitted(executor, call, item)] = item
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                yield running.pop(future), future.exception() or future.result()
    finally:  # whoever asked may have left before the last one
        for future in running:
            future.cancel()


def _submitted(executor, call, item):
    """The Future of a call; it has failed where an earlier call has ended the executor's process."""
    try:
        return executor.submit(call, item)
    except BrokenExecutor as error:
        failed = Future[Any]()
        failed.set_exception(error)
        return failed
