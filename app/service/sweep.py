"""Many small calls for the workers in the background: what one visitor has asked for is there for all."""

import logging
from collections import OrderedDict
from concurrent.futures import CancelledError
from concurrent.futures.process import BrokenProcessPool
from threading import RLock

log = logging.getLogger("app")
CAPACITY = 2000  # results kept
LIVES = 3  # how often a call may be lost with its worker


class Results:
    """Results by call, those used last; a call that several visitors want at the same time is made once."""

    def __init__(self, capacity=CAPACITY):
        self.capacity, self._kept, self._asked, self._lock = capacity, OrderedDict(), {}, RLock()

    def ask(self, pool, call, hear):
        """Have call = (function, *arguments) made; `hear(call, result)` is called once, in whatever thread.

        Returns the result at once if it is known, and then hear is not called. A result may be an Exception.
        """
        with self._lock:
            if call in self._kept:
                self._kept.move_to_end(call)
                return self._kept[call]
            if call in self._asked:
                self._asked[call][1].append(hear)
            else:
                self._asked[call] = [None, [hear], 0]
                self._submit(pool, call)
        return None

    def leave(self, pool, call, hear):
        """Do not wait any longer; when nobody does, the call is not made."""
        with self._lock:
            if call in self._asked:
                task, hearers, _ = self._asked[call]
                if hear in hearers:
                    hearers.remove(hear)
                if not hearers:
                    del self._asked[call]
                    pool.abandon(task)

    def _submit(self, pool, call):
        asked = self._asked[call]
        asked[0] = pool.submit(*call, background=True)
        asked[0].add_done_callback(lambda task: self._made(pool, call, task))

    def _made(self, pool, call, task):
        with self._lock:
            asked = self._asked.get(call)
            if asked is None or asked[0] is not task:
                return
            try:
                result = task.result()
                self._keep(call, result)
            except (BrokenProcessPool, CancelledError) as error:
                asked[2] += 1
                if asked[2] < LIVES:
                    return self._submit(pool, call)
                result = error
            except Exception as error:
                log.exception("a call in the background failed")
                result = error
            hearers = self._asked.pop(call)[1]
        for hear in hearers:
            hear(call, result)

    def _keep(self, call, result):
        self._kept[call] = result
        while len(self._kept) > self.capacity:
            self._kept.popitem(last=False)


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
            known = self.shared.ask(self.session.pool, call, self._hear)
            if known is None:
                self.waiting.add(call)
                self.count += 1
            else:
                self.take(call, known)

    def cancel(self):
        """Wait for nothing any longer."""
        waiting, self.waiting = self.waiting, set()
        for call in waiting:
            self.shared.leave(self.session.pool, call, self._hear)

    def _hear(self, call, result):
        self.session.doc.add_next_tick_callback(lambda: self._take(call, result))

    def _take(self, call, result):
        if call in self.waiting:
            self.waiting.discard(call)
            self.take(call, result)
