"""Calls on a dask cluster, in place of processes of this machine; the extra `cluster` is needed on every worker too."""

from collections.abc import Callable, Iterator, Sequence
from queue import Empty, SimpleQueue
from time import monotonic
from traceback import format_exception
from typing import Any

from .isolated import TRACEBACK, Lost

PATIENCE = 10.0  # s for the scheduler to answer; on a local network it takes milliseconds
LOOK = 1.0  # s between two checks that the scheduler is still there
LOST = "--scheduler {}: was lost; start it, and run again"


class ClusterError(RuntimeError):
    """The cluster cannot be used; the message is one line that names it and a remedy."""


def outcomes(call: Callable, items: Sequence[Any], address: str, limit: float) -> Iterator[tuple[int, Any]]:
    """Yields as `isolated.outcomes`, from the workers of the scheduler at `address`.

    Dask repeats the calls of a lost worker on another. If no result arrives for `limit` s, the remaining calls are Lost
    as 'hang'. Raises ClusterError.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ClusterError('--scheduler: dask is missing; pip install -e ".[cluster]"') from None
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError):
        raise ClusterError(f"--scheduler {address}: cannot be reached; give tcp://host:8786") from None
    with client:
        if not client.ncores():
            raise ClusterError(f"--scheduler {address}: no worker there; dask worker {address} --nthreads 1")
        ended: SimpleQueue[Any] = SimpleQueue()
        waiting: dict[Any, tuple[int, Any]] = {}  # {key: (index, future)}: dask gives up what nobody refers to
        submitted, last = 0, monotonic()
        while True:
            for item in items[submitted:]:
                future = client.submit(call, item, pure=False)
                waiting[future.key] = submitted, future
                future.add_done_callback(ended.put)
                submitted += 1
            if not waiting:
                return
            try:
                future = ended.get(timeout=LOOK)
            except Empty:
                if client.status != "running":
                    raise ClusterError(LOST.format(address)) from None
                if monotonic() > last + limit:
                    hang = Lost("hang", f"no answer of the cluster within {limit:g} s")
                    yield from ((index, hang) for index, _ in waiting.values())
                    return
                continue
            if future.status not in ("finished", "error"):
                raise ClusterError(LOST.format(address))
            last = monotonic()
            index, _ = waiting.pop(future.key)
            yield index, future.result() if future.status == "finished" else _lost(future.exception())


def _lost(error):
    if type(error).__module__.startswith("distributed."):  # such as KilledWorker
        return Lost("crash", str(error))
    return Lost("error", "".join(format_exception(error, limit=TRACEBACK)))
