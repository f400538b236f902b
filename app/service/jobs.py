"""Jobs of all visitors: equal calls are one job, and results are cached.

A coroutine awaits a job by two methods of `jobs`:

    found = await jobs.result(function, *arguments, owner=visitor)
    async for part in jobs.parts(function, *arguments, owner=visitor): ...

`function` is a pure, importable function of picklable arguments, and `owner` is anything that stands for the visitor,
such as id(document); docs of `Job` say what a function may return. Both raise the job's exception. Cancelling the
coroutine leaves the job, and a job that nobody needs is cancelled.

In a session, `Jobs.start` calls back instead: see `app/service/requests.py` and `app/session/pursuit.py`.
"""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import aclosing
from threading import RLock
from typing import Any

from app.service import metrics
from app.service.cache import Cache, size_of
from app.service.caller import Lost
from app.service.job import LATER, Job, Notify
from app.service.pool import Pool
from app.service.pool import pool as shared_pool

CAPACITY = 150e6  # bytes of cached results, about 70 runs and the tables of all pages
LARGEST = 10e6  # bytes of one cached result: a larger one would displace many that others need


class Jobs:
    """The jobs of one pool, and the cache of their results. Its methods may be called in any thread."""

    def __init__(self, pool: Pool, capacity: float = CAPACITY) -> None:
        self.pool, self._lock = pool, RLock()
        self.results = Cache(capacity)  # (call, result or exception) by call
        self._shared: dict[tuple, Job] = {}  # jobs in progress by call

    def start(
        self,
        call: tuple[Any, ...],
        notify: Notify,
        *,
        owner: object,
        rank: int = LATER,
        private: bool = False,
        **how: Any,
    ) -> Job:
        """Start a call (function, *arguments), or join the job that makes it already.

        notify(job) is called in any thread when a part or the result has come; not if the result is cached: then the
        job returned is done. private: of this visitor only, and not cached. rank, how: as for `Job`.
        """
        with self._lock:
            if not private and (kept := self.results.get(call)) is not None:
                return _ended(call, kept[1])
            job = None if private else self._shared.get(call)
            if job is None:
                job = Job(call, owner, rank, **how)
                job.listeners.append(notify)
                if not private:
                    self._shared[call] = job
                    job.add_done_callback(self._keep)
                return self.pool.submit(job)
            if notify not in job.listeners:
                job.listeners.append(notify)
            if rank < job.rank:
                self.pool.move_up(job, owner, rank)
            return job

    def keeps(self, *call: Any) -> bool:
        """Whether the result of a call is cached."""
        with self._lock:
            return call in self.results

    def leave(self, job: Job, notify: Notify) -> None:
        """Stop listening to a job. Without listeners it is cancelled."""
        with self._lock:
            if notify in job.listeners:
                job.listeners.remove(notify)
            if not job.listeners and not job.done():
                self._forget(job)
                self.pool.abandon(job)

    async def parts(self, function: Callable, *arguments: Any, owner: object, **how: Any) -> AsyncIterator[Any]:
        """Yield the parts of function(*arguments) as they come; how: as for `start`."""
        seen = 0
        async with aclosing(self._news(function, *arguments, owner=owner, **how)) as news:
            async for job in news:
                while seen < len(job.parts):
                    seen += 1
                    yield job.parts[seen - 1]

    async def result(self, function: Callable, *arguments: Any, owner: object, **how: Any) -> Any:
        """Return function(*arguments), computed by a worker; how: as for `start`."""
        async with aclosing(self._news(function, *arguments, owner=owner, **how)) as news:
            async for job in news:
                if job.done():
                    return job.result()
        return None

    async def _news(self, *call: Any, owner: object, **how: Any) -> AsyncGenerator[Job, None]:
        """Yield the job of a call whenever it has news; raises its exception."""
        loop, news = asyncio.get_running_loop(), asyncio.Event()

        def notify(job: Job) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(news.set)

        job = self.start(call, notify, owner=owner, **how)
        try:
            while not job.done():
                await news.wait()
                news.clear()
                if not job.done():
                    yield job
        finally:
            self.leave(job, notify)
        job.result()  # raises its exception
        yield job

    def _forget(self, job):
        if self._shared.get(job.call) is job:
            del self._shared[job.call]

    def _keep(self, job):
        """Cache the result of a job that is done, unless it was cancelled."""
        with self._lock:
            self._forget(job)
            if not job.cancelled() and _is_final(made := job.outcome) and size_of(made) <= LARGEST:
                self.results.put(job.call, (job.call, made))


def _ended(call: tuple[Any, ...], made: Any) -> Job:
    """Return the job of a cached result or exception."""
    job = Job(call)
    if isinstance(made, Exception):
        job.set_exception(made)
    else:
        job.parts = [made]
        job.set_result(made)
    return job


def _is_final(made: Any) -> bool:
    """Whether the same call always ends like this."""
    return not isinstance(made, Lost) and not getattr(made, "failure", "")


jobs = Jobs(shared_pool)
metrics.gauge("cache_bytes", "bytes of cached results", lambda: jobs.results.currsize)
