"""Calls on a dask cluster, in place of processes of this machine; needs the extra `cluster`, here and there."""

from queue import Empty, SimpleQueue
from time import monotonic
from traceback import format_exception

from .isolated import Lost

PATIENCE = 10.0  # s for the scheduler to answer
LOOK = 1.0  # s between two looks whether it is still there
LOST = "--scheduler {}: was lost; start it, and run again"


class ClusterError(RuntimeError):
    """The cluster is of no use; the message is one line that names it and says what to do."""


def outcomes(call, items, address, limit):
    """Yield (index, call(item) or Lost) as they come, from workers that the scheduler at `address` knows then.

    Those of a worker that is lost are made by another; when nothing has come for `limit` s, what is left counts as
    hung. Raises ClusterError.
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
        futures = [client.submit(call, item, pure=False) for item in items]
        found, waiting, heard = SimpleQueue(), {future.key: k for k, future in enumerate(futures)}, monotonic()
        for future in futures:
            future.add_done_callback(found.put)
        while waiting:
            try:
                future = found.get(timeout=LOOK)
            except Empty:
                if client.status != "running":
                    raise ClusterError(LOST.format(address)) from None
                if monotonic() > heard + limit:
                    for index in waiting.values():
                        yield index, Lost("hang", f"no answer of the cluster within {limit:g} s")
                    return
                continue
            if future.status not in ("finished", "error"):
                raise ClusterError(LOST.format(address))
            heard = monotonic()
            yield waiting.pop(future.key), future.result() if future.status == "finished" else _lost(future.exception())


def _lost(error):
    if type(error).__module__.startswith("distributed."):  # KilledWorker and its like
        return Lost("crash", str(error))
    return Lost("error", "".join(format_exception(error, limit=-6)))
