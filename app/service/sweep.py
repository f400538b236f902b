"""Many small calls for the workers in the background: what one visitor has asked for is there for all."""

import logging
import pickle
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass
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
MADE = RuntimeError("the server could not compute it; its log says why")


@dataclass
class Asked:
    """A call on its way: its task, who waits for it, how often a slice was lost, what it has come to."""

    owner: Any
    hearers: list
    task: Any = None
    lost: int = 0
    kept: tuple = ()


class Results:
    """Results by call, those used last; a call that several visitors want at the same time is made once."""

    def __init__(self, capacity=CAPACITY):
        self._kept = LRUCache(capacity, lambda made: len(pickle.dumps(made)))  # (call, result) by call
        self._asked, self._lock = {}, RLock()

    def clear(self):
        """As if nothing had been asked for."""
        with self._lock:
            self._kept.clear()
            self._asked.clear()

    def ask(self, pool, call, hear, owner=None):
        """Have call = (function, *arguments) made; `hear(call, result)` is called once, in whatever thread.

        Returns the result at once if it is known, and then hear is not called. A result may be an Exception.
        """
        with self._lock:
            made = self._kept.get(call)
            if made is not None:
                return made[1]
            if call in self._asked:
                self._asked[call].hearers.append(hear)
            else:
                self._asked[call] = Asked(owner, [hear])
                self._submit(pool, call)
        return None

    def leave(self, pool, call, hear):
        """Do not wait any longer; when nobody does, the call is not made."""
        with self._lock:
            asked = self._asked.get(call)
            if asked is not None:
                if hear in asked.hearers:
                    asked.hearers.remove(hear)
                if not asked.hearers:
                    del self._asked[call]
                    pool.abandon(asked.task)

    def _submit(self, pool, call):
        asked = self._asked[call]
        asked.task = pool.submit(*call, *asked.kept, owner=asked.owner, rank=LATER)
        asked.task.add_done_callback(lambda task: self._made(pool, call, task))

    def _made(self, pool, call, task):
        with self._lock:
            asked = self._asked.get(call)
            if asked is None or asked.task is not task:
                return
            try:
                result = task.result()
            except (Lost, CancelledError) as error:
                result = MADE if getattr(error, "kind", "") == "error" else error
            if isinstance(result, Part):
                asked.kept = (result.kept,)
                return self._submit(pool, call)
            if isinstance(result, OutOfTime) or getattr(result, "kind", "") == "crash":  # the machine was busy
                asked.lost += 1
                if asked.lost < LIVES:
                    return self._submit(pool, call)
            if not isinstance(result, (Lost, CancelledError, OutOfTime)):  # it may be another one next time
                with suppress(ValueError):  # of what is larger than all that is kept
                    self._kept[call] = call, result
            del self._asked[call]
        for hear in asked.hearers:
            hear(call, result)


results = Results()


class Sweep:
    """The calls of one page: `take(call, result)` under the lock of the visitor's document, as each is made."""

    def __init__(self, session, take, shared=results):
        self.session, self.take, self.shared = session, take, shared
        self.waiting, self.count = set(), 0

    @property
    def part(self):
        """The part that is done, 0..1; None when nothing is left to do."""
        return 1.0 - len(self.waiting) / self.count if self.waiting else None

    def add(self, calls):
        """Ask for calls; what is known already is taken at once."""
        if not self.waiting:
            self.count = 0
        for call in calls:
            if call in self.waiting:
                continue
            known = self.shared.ask(self.session.pool, call, self._hear, owner=id(self.session))
            if known is None:
                self.waiting.add(call)
                self.count += 1
            else:
                self.take(call, known)

    def cancel(self):
        """Wait for nothing any longer."""
        self.drop(list(self.waiting))

    def drop(self, calls):
        """Wait for some no longer."""
        for call in self.waiting.intersection(calls):
            self.waiting.discard(call)
            self.shared.leave(self.session.pool, call, self._hear)

    def _hear(self, call, result):
        self.session.doc.add_next_tick_callback(lambda: self._take(call, result))

    def _take(self, call, result):
        if call in self.waiting:
            self.waiting.discard(call)
            self.take(call, result)
