"""Calls of the workers for the pages: made once for all visitors who wait for them, and their results are kept."""

import logging
import pickle
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from threading import RLock
from typing import Any

from cachetools import LRUCache

from app.service.pool import LATER
from app.service.tasks import Part
from solver.continuation.state import OutOfTime
from solver.isolated import Lost

log = logging.getLogger("app")
CAPACITY = 50e6  # bytes of results kept
LIVES = 3  # how often a slice may be lost with its worker, or take too long
ERROR = RuntimeError("the server could not compute it; its log says why")


@dataclass
class Request:
    """A call on its way: who waits for it, how it is submitted (see `Pool.submit`), and how far it is."""

    hearers: list
    how: dict
    task: Any = None
    lost: int = 0  # slices
    kept: tuple = ()
    made: list = field(default_factory=list)  # parts of the result


class Shared:
    """Results by call, those used last; a call that several visitors want at the same time is made once."""

    def __init__(self, capacity=CAPACITY):
        self._kept = LRUCache(capacity, lambda made: len(pickle.dumps(made)))  # (call, result) by call
        self._requests, self._lock = {}, RLock()

    def clear(self):
        """As if nothing had been asked for."""
        with self._lock:
            self._kept.clear()
            self._requests.clear()

    def ask(self, pool, call, hear, **how):
        """Have call = (function, *arguments) made; `hear(call, result)` is called once, in whatever thread.

        Returns the result at once if it is known, and then hear is not called. A result may be an Exception.
        """
        with self._lock:
            made = self._kept.get(call)
            if made is not None:
                return made[1]
            if call in self._requests:
                self._requests[call].hearers.append(hear)
            else:
                self._requests[call] = Request([hear], how)
                self._submit(pool, call)
        return None

    def leave(self, pool, call, hear):
        """Do not wait any longer; when nobody does, the call is not made."""
        with self._lock:
            request = self._requests.get(call)
            if request is not None:
                if hear in request.hearers:
                    request.hearers.remove(hear)
                if not request.hearers:
                    del self._requests[call]
                    pool.abandon(request.task)

    def _submit(self, pool, call):
        request = self._requests[call]
        request.task = pool.submit(*call, *request.kept, **request.how)
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
                request.kept = (result.kept,)
                request.made += [] if result.made is None else [result.made]
                return self._submit(pool, call)
            if isinstance(result, OutOfTime) or getattr(result, "kind", "") == "crash":  # the machine was busy
                request.lost += 1
                if request.lost < LIVES:
                    return self._submit(pool, call)
            if request.made and not isinstance(result, Exception):
                result = sum([*request.made[1:], result], request.made[0])
            if not isinstance(result, (Lost, CancelledError, OutOfTime)):  # it may be another one next time
                with suppress(ValueError):  # of what is larger than all that is kept
                    self._kept[call] = call, result
            del self._requests[call]
        for hear in request.hearers:
            hear(call, result)


shared = Shared()


class Requests:
    """The calls that one part of a visitor's page waits for; every method runs under the lock of the document."""

    def __init__(self, session, take=None, shared=shared):
        """take(call, result) takes the results of `add`."""
        self.session, self._take_each, self.shared = session, take, shared
        self.waiting, self.count = {}, 0  # {call: what takes its result}

    @property
    def part(self):
        """The part that is done, 0..1; None when nothing is left to do."""
        return 1.0 - len(self.waiting) / self.count if self.waiting else None

    def add(self, calls):
        """Ask for calls = [(function, *arguments)], in the background."""
        for call in calls:
            self.also(call, partial(self._take_each, call), rank=LATER)

    def also(self, call, take, **how):
        """Ask for one call more, then take(result), an Exception where it failed; at once if it is known.

        A call that is waited for goes on. how: rank and seconds, as of `Pool.submit`.
        """
        known = self._ask(call, take, **how)
        if known is not None:
            self._answered(call, known)

    def ask(self, call, take, **how):
        """Ask for one call in place of all before, then take(result), None where it failed."""
        self.cancel()
        known = self._ask(call, lambda result: take(None if isinstance(result, Exception) else result), **how)
        if known is not None:
            self._hear(call, known)

    def cancel(self):
        """Wait for nothing any longer."""
        self.drop(list(self.waiting))

    def drop(self, calls):
        """Wait for some no longer."""
        for call in self.waiting.keys() & set(calls):
            del self.waiting[call]
            self.shared.leave(self.session.pool, call, self._hear)

    def _ask(self, call, take, **how):
        """The result, if it is known; else it is taken once it is there."""
        if call in self.waiting:
            return None
        self.count = self.count + 1 if self.waiting else 1
        self.waiting[call] = take
        return self.shared.ask(self.session.pool, call, self._hear, owner=id(self.session), **how)

    def _hear(self, call, result):
        self.session.doc.add_next_tick_callback(lambda: self._answered(call, result))

    def _answered(self, call, result):
        if call in self.waiting:
            self.waiting.pop(call)(result)
