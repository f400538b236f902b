"""The calls to the workers that one part of a page waits for; see jobs.py."""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from app.service.job import LATER, Job

Call = tuple[Any, ...]  # (function, *arguments)


class Requests:
    """The calls that one part of a page waits for. Every method runs under the lock of the document."""

    def __init__(self, session: Any, take: Any = None) -> None:
        """take(call, result) receives the results of `add`."""
        self.session, self._take_each = session, take
        self.waiting: dict[Call, Callable[[Any], None]] = {}  # the function that receives the result
        self._jobs: dict[Call, Job] = {}
        self._count = 0

    @property
    def part(self) -> float | None:
        """The fraction done, 0..1; None when no call is left."""
        return 1.0 - len(self.waiting) / self._count if self.waiting else None

    def add(self, calls: Iterable[Call], **how: Any) -> None:
        """Request calls [(function, *arguments)] in the background. how: as for `Jobs.start`."""
        for call in calls:
            self.add_one(call, partial(self._take_each, call), **how)

    def add_one(self, call: Call, take: Callable[[Any], None], **how: Any) -> None:
        """Request one more call; take(result) receives its result or Exception, at once if cached.

        Calls already requested continue. how: as for `Jobs.start`.
        """
        if call in self.waiting:
            return
        self._count = self._count + 1 if self.waiting else 1
        self.waiting[call] = take
        job = self.session.jobs.start(call, self._on_news, owner=id(self.session), **{"rank": LATER} | how)
        if job.done():
            self._answered(call, job.outcome)
        else:
            self._jobs[call] = job

    def ask(self, call: Call, take: Callable[[Any], None], **how: Any) -> None:
        """Request one call instead of all earlier ones; take(result) receives its result, or None if it failed."""
        self.cancel()
        self.add_one(call, lambda result: take(None if isinstance(result, BaseException) else result), **how)

    def cancel(self) -> None:
        """Cancel all calls."""
        self.waiting.clear()
        while self._jobs:
            self.session.jobs.leave(self._jobs.popitem()[1], self._on_news)

    def _on_news(self, job: Job) -> None:
        if job.done() and not job.cancelled():
            self.session.later(partial(self._answered, job.call, job.outcome))

    def _answered(self, call: Call, result: Any) -> None:
        self._jobs.pop(call, None)
        if call in self.waiting:
            self.waiting.pop(call)(result)
