"""A job: a call for the workers, from the queue to its result."""

import logging
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from functools import reduce
from operator import add
from time import monotonic
from typing import Any

from app.service import metrics
from app.service.packing import Frames
from app.service.worker import Part

log = logging.getLogger("app")
ATTEMPTS = 3  # calls that lose their worker, before the job fails
NOBODY = "the server"  # owner of the jobs that no visitor waits for
# Purpose of a job: the screen; the exact run of a picture; any that takes long; in the background, a second at most
SCREEN, EXACT, HEAVY, LATER = range(RANKS := 4)
Notify = Callable[["Job"], None]


class Job(Future):
    """A call (function, *arguments) that a worker makes for an owner, part by part; `parts` are those that have come.

    A function returns its result; or a `Part`, and is called again with the state of it; or, if the job streams, it is
    a generator: then its items are the parts, and its return value is the result. Otherwise the result is the sum of
    all parts. The exception is what the function returned, or a `caller.Lost`.

    It can be cancelled until it is done: it never counts as running. `slot` is that of the worker which has it.
    """

    def __init__(
        self,
        call: tuple[Any, ...],
        owner: object = None,
        rank: int = SCREEN,
        seconds: float = 0.0,
        streams: bool = False,
        begin: tuple[Any, ...] = (),
    ) -> None:
        """seconds: expected of one call, at most. begin: further arguments of the first call."""
        super().__init__()
        self.call, self.owner, self.rank, self.seconds, self.streams = call, owner, rank, seconds, streams
        self.parts: list[Any] = []
        self.state = begin  # further arguments of the next call
        self.lost = 0  # calls that were repeated, as their worker ended
        self.heavy = False  # whether the next call may take long
        self.slot: Any = None
        self.listeners: list[Notify] = []  # called at each part and at the end, in any thread
        self.since = monotonic()  # s: a call has waited as long as its job
        self.queued, self.due = rank, 0.0  # of the queue: rank in it, and when its turn comes, s, monotonic

    @property
    def outcome(self) -> Any:
        """The result of a job that is done, or its exception."""
        return self.exception() or self.result()

    @property
    def waits(self) -> bool:
        """Whether it waits for a worker."""
        return self.slot is None and not self.done()

    def heard(self, part: Any) -> None:
        """Take an item of a generator."""
        self.parts.append(part)
        self.tell()

    def returned(self, made: Any) -> bool:
        """Take what a call has returned, or the Lost of its worker; return whether it must be made again.

        Then `tell` the listeners: after the job is in the queue again, as one that waits may be left.
        """
        if isinstance(made, Part):
            self.state, self.heavy = (made.state,), made.heavy
            if made.made is not None:
                self._add(made.made)
        elif getattr(made, "kind", "") == "crash" and self.lost + 1 < ATTEMPTS:
            self.lost += 1
            self.parts = [] if self.streams else self.parts
        else:
            with suppress(InvalidStateError):  # nobody waits for it any more
                self._end(made)
        return not self.done()

    def _end(self, made):
        if isinstance(made, Exception):
            self.set_exception(made)
        elif self.streams:
            self.set_result(made)
        else:
            self._add(made)
            self.set_result(reduce(add, self.parts))

    def _add(self, part):
        self.parts.append(part)
        if isinstance(part, Frames):
            metrics.count("slices")
            metrics.count("evaluations", part.evaluations)

    def tell(self) -> None:
        """Tell the listeners. An error of one is logged: it concerns neither the others nor the worker."""
        for notify in [*self.listeners]:
            try:
                notify(self)
            except Exception:
                log.exception("a listener of a job failed")
