"""Calls on a dask cluster, in place of processes of this machine; the extra `cluster` is needed on every worker too."""

from collections.abc import Callable
from queue import Empty, SimpleQueue
from time import monotonic
from traceback import format_exception
from typing import Any

from .isolated import TRACEBACK, Lost

PATIENCE = 10.0  # s for the scheduler to answer; on a local network it takes milliseconds
LOOK = 1.0  # s between two checks that the scheduler is still there
LOST = "scheduler {}: was lost; start it, and run again"


class ClusterError(RuntimeError):
    """The cluster cannot be used; the message is one line that names it and a remedy."""


class Cluster:
    """The workers of the scheduler at `address`, used as `isolated.Processes`; raises ClusterError.

    Dask repeats the calls of a lost worker on another. If no result arrives for `limit` s, the remaining calls are Lost
    as 'hang'.
    """

    def __init__(self, call: Callable, address: str, limit: float) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise ClusterError('scheduler: dask is missing; pip install -e ".[cluster]"') from None
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError):
            raise ClusterError(f"scheduler {address}: cannot be reached; give tcp://host:8786") from None
        self.count = len(self._client.ncores())
        if not self.count:
            self._client.close()
            raise ClusterError(f"scheduler {address}: no worker there; dask worker {address} --nthreads 1")
        self._call, self._address, self._patience = call, address, limit
        self._hang = Lost("hang", f"no answer of the cluster within {limit:g} s")
        self._ended: SimpleQueue[Any] = SimpleQueue()
        self._waiting: dict[Any, tuple[int, Any]] = {}  # {key: (index, future)}: dask gives up what nobody refers to

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *error: object) -> None:
        self._client.close()

    def submit(self, index: int, item: Any) -> None:
        """Makes call(item) as soon as a worker is free."""
        future = self._client.submit(self._call, item, pure=False)
        self._waiting[future.key] = index, future
        future.add_done_callback(self._ended.put)

    def completed(self) -> tuple[int, Any]:
        """(index, result or Lost) of the call that ends next."""
        end = monotonic() + self._patience
        while (left := end - monotonic()) > 0.0:
            try:
                future = self._ended.get(timeout=min(LOOK, left))
            except Empty:
                if self._client.status != "running":
                    raise ClusterError(LOST.format(self._address)) from None
                continue
            if future.status not in ("finished", "error"):
                raise ClusterError(LOST.format(self._address))
            index, _ = self._waiting.pop(future.key)
            return index, future.result() if future.status == "finished" else _lost(future.exception())
        self._patience = 0.0
        index, _ = self._waiting.pop(next(iter(self._waiting)))
        return index, self._hang


def _lost(error):
    if type(error).__module__.startswith("distributed."):  # such as KilledWorker
        return Lost("crash", str(error))
    return Lost("error", "".join(format_exception(error, limit=TRACEBACK)))
