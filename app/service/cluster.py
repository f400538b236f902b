"""Places on a dask cluster for the pool, in place of processes of this machine: dask chooses the worker of a call."""

from collections.abc import Callable
from contextlib import suppress
from inspect import isgenerator
from math import inf
from threading import Event, Lock
from traceback import format_exception
from typing import Any
from uuid import uuid4

from app.service.caller import TRACEBACK, Lost

PATIENCE = 5.0  # s for the scheduler to answer; on a local network it takes milliseconds
LOOK = 1.0  # s between two checks that the scheduler is there


class Cluster:
    """The scheduler at an address, to which it connects again where necessary; a call returns a free Place."""

    why = "the cluster cannot be reached, or has no worker; the server continues as soon as a worker is there"

    def __init__(self, address: str) -> None:
        self.address, self.lock = address, Lock()
        self.client: Any = None
        self.places: list[Place] = []

    def __call__(self) -> "Place":
        """One for a worker that has none; raises Lost of the kind "absent"."""
        from distributed import Client

        with self.lock:
            try:
                if self.client is None or self.client.status != "running":
                    self.client = Client(self.address, timeout=PATIENCE, set_as_default=False)
                self.places = [place for place in self.places if place.alive()]
                count = len(self.client.sync(self.client.scheduler.ncores, callback_timeout=PATIENCE))
            except Exception as error:  # of any kind, from sockets to handshakes
                raise Lost("absent", f"the cluster cannot be reached: {error}") from None
            if len(self.places) >= count:
                raise Lost("absent", "no worker is free")
            self.places.append(Place(self.client))
            return self.places[-1]


class Place:
    """Room for one call at a time, with the methods of `caller.Caller` that the pool calls."""

    def __init__(self, client: Any) -> None:
        self.client, self.ended = client, Event()

    def alive(self) -> bool:
        """Whether the scheduler is there."""
        return not self.ended.is_set() and self.client.status == "running"

    def call(
        self, function: Callable, *arguments: Any, limit: float = inf, hear: Callable[[Any], Any] | None = None
    ) -> Any:
        """Return function(*arguments), computed by a worker, as `Caller.call`; items are heard all at the end.

        Raises Lost. dask computes it again where a worker is killed.
        """
        items, value = self._computed(limit, whole, function, *arguments)
        if hear is not None:
            for item in items:
                hear(item)
        return value

    def _computed(self, limit, *call):
        key, done = f"contact-{uuid4().hex}", Event()
        try:
            future = self.client.submit(*call, pure=False, key=key)
            future.add_done_callback(lambda _: done.set())
            while not done.wait(min(LOOK, limit)) and limit > 0.0 and self.alive():
                limit -= LOOK
            if future.status == "finished":
                return future.result(timeout=PATIENCE)
            error = future.exception(timeout=PATIENCE) if future.status == "error" else None
            if done.is_set() or (not self.ended.is_set() and self.client.status != "running"):
                raise self._lost(error)
            self._restart(key)  # else the worker computes to the end what nobody waits for
        except Lost:
            raise
        except Exception as gone:
            raise Lost("crash", f"the scheduler is gone: {gone!r}") from None
        raise Lost("hang", "no answer within the limit of time")

    def _lost(self, error):
        if error is None or type(error).__module__.startswith("distributed."):  # e.g. KilledWorker
            return Lost("crash", str(error or "the scheduler is gone"))
        return Lost("error", "".join(format_exception(error, limit=TRACEBACK)))

    def _restart(self, key):
        """Restart the worker that computes a call that hangs."""
        with suppress(Exception):  # without a nanny the worker first finishes its task
            busy = [address for address, keys in self.client.processing().items() if key in keys]
            self.client.restart_workers(busy, timeout=PATIENCE, raise_for_error=False)

    def stop(self) -> None:
        """Let a call go on: dask runs it to its end, or until the place is ended."""

    def end(self) -> None:
        """Abandon the place and its call."""
        self.ended.set()


def whole(function: Callable, *arguments: Any) -> tuple[list[Any], Any]:
    """Return (items, value) of a call: a generator's items and return value, or none and the result itself."""
    items, result = [], function(*arguments)
    while isgenerator(result):
        try:
            items.append(next(result))
        except StopIteration as end:
            result = end.value
    return items, result
