"""Workers of a dask cluster, in place of processes of this machine, for commands and for the app.

This needs the extra `cluster`, and workers with one thread each that have the same version of this project. A call goes
to one worker, which stays warm. A call that takes too long is abandoned; a nanny, if there is one, restarts the worker.
Whoever reaches a scheduler at tcp:// can run code on it and on its workers: use it in a trusted network only, else tls://.
"""

from collections.abc import Callable
from contextlib import suppress
from math import inf
from queue import Empty, SimpleQueue
from threading import RLock, Thread
from time import sleep
from traceback import format_exception
from typing import Any
from uuid import uuid4

from .isolated import TRACEBACK, Lost

PATIENCE = 5.0  # s for the scheduler to answer; on a local network it takes milliseconds


class Cluster:
    """Connection to a cluster. A call returns a Remote for a free worker; it reconnects if necessary.

    Raises Lost of the kind "absent" without dask.
    """

    why = "the cluster cannot be reached, or has no worker; the server continues as soon as a worker is there"

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise Lost("absent", 'scheduler: dask is missing; pip install "mixed-mode-contact[cluster]"') from None
        self.connect = Client
        self.address, self.client, self.lock = address, None, RLock()
        self.remotes: dict[str, Remote] = {}

    def count(self) -> int:
        """The number of workers; raises Lost where there is none."""
        try:
            count = len(self._workers())
        except Exception:  # of any kind, from sockets to handshakes
            self.close()
            raise Lost("absent", "cannot be reached; give tcp://host:8786") from None
        if not count:
            self.close()
            raise Lost("absent", f"no worker there; dask worker {self.address} --nthreads 1")
        return count

    def __call__(self) -> "Remote":
        """A Remote for a worker that has none; raises Lost."""
        with self.lock:
            try:
                free = [worker for worker in self._workers() if worker not in self.remotes]
            except Exception as error:
                self.close()
                raise Lost("absent", f"the cluster cannot be reached: {error}") from None
            if not free:
                raise Lost("absent", "no worker is free")
            self.remotes[free[0]] = remote = Remote(self, self.client, free[0])
            return remote

    def left(self, remote: "Remote") -> None:
        """Free the worker of a Remote."""
        with self.lock:
            if self.remotes.get(remote.worker) is remote:
                del self.remotes[remote.worker]

    def _workers(self):
        """Return the addresses of all workers of the scheduler."""
        if self.client is None:
            self.client = self.connect(self.address, timeout=PATIENCE, set_as_default=False)
            Thread(target=self._watch, args=(self.client,), name="cluster", daemon=True).start()
        if self.client.status != "running":
            raise OSError("the connection is lost")
        return list(self.client.sync(self.client.scheduler.ncores, callback_timeout=PATIENCE))

    def _watch(self, client):
        """Notify each Remote when its worker leaves, and all when the connection is lost."""
        there = True
        while there and self.client is client:
            sleep(1.0)
            try:
                known = set(client.sync(client.scheduler.ncores, callback_timeout=PATIENCE))
                there = client.status == "running"
            except Exception:
                known, there = set(), False
            with self.lock:
                gone = [remote for worker, remote in self.remotes.items() if worker not in known]
            for remote in gone:
                remote.lose()
        with self.lock:
            if self.client is client:
                self.close()

    def close(self) -> None:
        """Abandon all calls and disconnect."""
        client, self.client = self.client, None
        if client is not None:
            for remote in list(self.remotes.values()):
                remote.lose()
            Thread(target=_closed, args=(client,), daemon=True).start()  # closing may take long


def _closed(client):
    with suppress(Exception):
        client.close(timeout=PATIENCE)


class Remote:
    """One worker of the cluster, with the interface of `isolated.Caller`."""

    def __init__(self, cluster, client, worker):
        self.cluster, self.client, self.worker = cluster, client, worker
        self._gone, self._news = False, SimpleQueue()

    def alive(self) -> bool:
        """Whether the scheduler listed the worker at the last check."""
        return not self._gone

    def lose(self) -> None:
        """Mark the worker as lost: it or the cluster is gone."""
        self._gone = True
        self._news.put(None)

    def call(self, function: Callable, *arguments: Any, limit: float = inf) -> Any:
        """Return function(*arguments), computed by the worker; raises Lost."""
        where = {"workers": [self.worker], "allow_other_workers": False, "key": f"contact-{uuid4().hex}"}
        try:
            future = self.client.submit(function, *arguments, pure=False, **where)
            future.add_done_callback(self._news.put)
            done = self._gone or self._news.get(timeout=None if limit == inf else limit)
            while done is not future and not self._gone:  # an earlier call
                done = self._news.get(timeout=None if limit == inf else limit)
            if self._gone or future.status not in ("finished", "error"):
                raise Lost("crash", "the worker has left the cluster")
            if future.status == "error":
                raise self._failed(future)
            return future.result(timeout=PATIENCE)
        except Empty:
            self._restart()
            raise Lost("hang", f"no answer within {limit:g} s") from None
        except Lost:
            raise
        except Exception as error:
            raise Lost("crash", f"the worker has left the cluster: {error!r}") from None

    def _failed(self, future):
        error = future.exception(timeout=PATIENCE)
        if type(error).__module__.startswith("distributed."):  # e.g. KilledWorker
            return Lost("crash", str(error))
        return Lost("error", "".join(format_exception(error, limit=TRACEBACK)))

    def _restart(self):
        self.lose()
        with suppress(Exception):  # without a nanny the worker first finishes its task
            self.client.restart_workers([self.worker], timeout=PATIENCE, raise_for_error=False)

    def end(self) -> None:
        """Free the worker and abandon its call."""
        if not self._gone:
            self.lose()
        self.cluster.left(self)
