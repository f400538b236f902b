"""Calls to the workers for the pages. Visitors share equal calls, and the server caches the results."""

import logging
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from functools import partial
from threading import RLock
from typing import Any

from app.service.cache import Cache
from app.service.pool import LATER
from app.service.tasks import Part
from solver.continuation.state import OutOfTime
from solver.isolated import Lost

log = logging.getLogger("app")
CAPACITY = 50e6  # bytes of cached results
ATTEMPTS = 3  # attempts at a slice that loses its worker or takes too long
ERROR = RuntimeError("the server could not compute it; its log says why")


@dataclass
class Pending:
    """A call in progress: its listeners, the options of `Pool.submit`, and its partial results."""

    listeners: list
    how: dict
    task: Any = None
    lost: int = 0  # failed attempts
    state: tuple = ()
    made: list = field(default_factory=list)  # partial results


class SharedRequests:
    """Cache of results by call. When several visitors need the same call, one worker makes it once."""

    def __init__(self, capacity=CAPACITY):
        self._results = Cache(capacity)  # (call, result) by call
        self._requests, self._lock = {}, RLock()

    def clear(self):
        """Drop all results and requests."""
        with self._lock:
            self._results.clear()
            self._requests.clear()

    def ask(self, pool, call, notify, **how):
        """Request call = (function, *arguments). `notify(call, result)` is called once, in any thread.

        If the result is cached, return it and do not call `notify`. A result may be an Exception.
        """
        with self._lock:
            made = self._results.get(call)
            if made is not None:
                return made[1]
            if call in self._requests:
                self._requests[call].listeners.append(notify)
            else:
                self._requests[call] = Pending([notify], how)
                self._submit(pool, call)
        return None

    def leave(self, pool, call, notify):
        """Remove a listener. Without listeners the call is abandoned."""
        with self._lock:
            request = self._requests.get(call)
            if request is not None:
                if notify in request.listeners:
                    request.listeners.remove(notify)
                if not request.listeners:
                    del self._requests[call]
                    pool.abandon(request.task)

    def _submit(self, pool, call):
        request = self._requests[call]
        request.task = pool.submit(*call, *request.state, **request.how)
        request.task.add_done_callback(partial(self._made, pool, call))

    def _made(self, pool, call, task):
        with self._lock:
            request = self._requests.get(call)
            if request is None or request.task is not task:
                return
            try:
                result = task.result()
            except (Lost, CancelledError) as error:
                result = ERROR if getattr(error, "kind", "") == "error" else error
            if isinstance(result, Part):
                request.state = (result.state,)
                request.made += [] if result.made is None else [result.made]
                return self._submit(pool, call)
            if isinstance(result, OutOfTime) or getattr(result, "kind", "") == "crash":  # the machine is busy
                request.lost += 1
                if request.lost < ATTEMPTS:
                    return self._submit(pool, call)
            if request.made and not isinstance(result, Exception):
                result = sum([*request.made[1:], result], request.made[0])
            if not isinstance(result, (Lost, CancelledError, OutOfTime)):  # these may differ next time
                self._results.put(call, (call, result))
            del self._requests[call]
        for notify in request.listeners:
            notify(call, result)


shared_requests = SharedRequests()


class Requests:
    """The calls that one part of a page waits for. Every method runs under the lock of the document."""

    def __init__(self, session, take=None, shared=shared_requests):
        """take(call, result) receives the results of `add`."""
        self.session, self._take_each, self.shared = session, take, shared
        self.waiting, self.count = {}, 0  # {call: the function that receives its result}

    @property
    def part(self):
        """The fraction done, 0..1; None when no call is left."""
        return 1.0 - len(self.waiting) / self.count if self.waiting else None

    def add(self, calls):
        """Request calls = [(function, *arguments)] in the background."""
        for call in calls:
            self.add_one(call, partial(self._take_each, call), rank=LATER)

    def add_one(self, call, take, **how):
        """Request one more call; take(result) receives its result or Exception, at once if cached.

        Calls already requested continue. how: rank and seconds of `Pool.submit`.
        """
        if call in self.waiting:
            return
        self.count = self.count + 1 if self.waiting else 1
        self.waiting[call] = take
        cached = self.shared.ask(self.session.pool, call, self._on_result, owner=id(self.session), **how)
        if cached is not None:
            self._answered(call, cached)

    def ask(self, call, take, **how):
        """Request one call instead of all earlier ones; take(result) receives its result, or None if it failed."""
        self.cancel()
        self.add_one(call, lambda result: take(None if isinstance(result, Exception) else result), **how)

    def cancel(self, calls=None):
        """Cancel some calls, or all."""
        for call in self.waiting.keys() & set(self.waiting if calls is None else calls):
            del self.waiting[call]
            self.shared.leave(self.session.pool, call, self._on_result)

    def _on_result(self, call, result):
        self.session.doc.add_next_tick_callback(lambda: self._answered(call, result))

    def _answered(self, call, result):
        if call in self.waiting:
            self.waiting.pop(call)(result)
