"""Jobs: calls to the workers, made part by part. Equal calls are one job, and results are cached for all visitors.

A coroutine awaits a job by two methods of `jobs`:

    found = await jobs.result(function, *arguments, owner=visitor)
    async for part in jobs.parts(function, *arguments, owner=visitor): ...

`function` is a pure, importable function of picklable arguments, and `owner` is anything that stands for the visitor,
such as id(document). Both raise the job's exception. Cancelling the coroutine leaves the job, and a job that nobody
needs is cancelled. A function returns its result; or a `Part`, and is called again with the state of it; or, with
streams=True, it is a generator: then its items are the parts, and its return value is the result.

In a session, `Jobs.start` calls back instead: see `app/service/requests.py` and `app/session/pursuit.py`.
"""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from concurrent.futures import CancelledError
from contextlib import aclosing
from functools import partial, reduce
from operator import add
from threading import RLock
from time import monotonic
from typing import Any

from app.service import metrics
from app.service.cache import Cache, size_of
from app.service.caller import Lost
from app.service.packing import Frames
from app.service.pool import HEAVY, LATER, Pool
from app.service.pool import pool as shared_pool
from app.service.worker import Part

CAPACITY = 150e6  # bytes of cached results, about 70 runs and the tables of all pages
LARGEST = 10e6  # bytes of one cached result: a larger one would displace many that others need
ATTEMPTS = 3  # attempts at a part that loses its worker, before the job fails
ERROR = RuntimeError("the server could not compute it; its log says why")
Notify = Callable[["Job"], None]


class Job:
    """A call in progress or ended; `parts`: what has come so far.

    result: the sum of all parts, or an Exception, once the job is done. lost: parts that were repeated.
    """

    def __init__(self, call: tuple[Any, ...], owner: object, rank: int, seconds: float, begin: tuple = ()) -> None:
        self.call, self.owner, self.rank, self.seconds = call, owner, rank, seconds
        self.parts: list[Any] = []
        self.result: Any = None
        self.lost = 0
        self.listeners: list[Notify] = []
        self.task: Any = None  # the part in the pool, or None
        self.since = monotonic()  # s: its parts are as old as it
        self.state = begin  # further arguments of the next part
        self.done = self.shared = self.streams = self.heavy = False


class Jobs:
    """The jobs of one pool, and the cache of their results. Its methods may be called in any thread."""

    def __init__(self, pool: Pool, capacity: float = CAPACITY) -> None:
        self.pool, self._lock = pool, RLock()
        self.results = Cache(capacity)  # (call, result) by call
        self._shared: dict[tuple, Job] = {}  # jobs in progress by call

    def start(
        self,
        call: tuple[Any, ...],
        notify: Notify,
        *,
        owner: object,
        rank: int = LATER,
        seconds: float = 0.0,
        private: bool = False,
        streams: bool = False,
        begin: tuple = (),
    ) -> Job:
        """Start a call (function, *arguments), or join the job that makes it already.

        notify(job) is called in any thread when a part or the result has come; not if the result is cached: then the
        job returned is done. rank, seconds: see `Pool.submit`. private: of this visitor only, and not cached. begin:
        further arguments of the first part.
        """
        with self._lock:
            if not private and (kept := self.results.get(call)) is not None:
                return _ended(call, kept[1])
            job = None if private else self._shared.get(call)
            if job is None:
                job = Job(call, owner, rank, seconds, begin)
                job.streams, job.shared = streams, not private
                if job.shared:
                    self._shared[call] = job
            if notify not in job.listeners:
                job.listeners.append(notify)
            if rank < job.rank:
                self._move_up(job, owner, rank)
            if job.task is None:
                self._submit(job)
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
            if not job.listeners and not job.done:
                self._forget(job)
                self._abandon(job)

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
                if job.done:
                    return job.result
        return None

    async def _news(self, *call: Any, owner: object, **how: Any) -> AsyncGenerator[Job, None]:
        """Yield the job of a call whenever it has news; raises its exception."""
        loop, news = asyncio.get_running_loop(), asyncio.Event()

        def notify(job: Job) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(news.set)

        job = self.start(call, notify, owner=owner, **how)
        try:
            while not job.done:
                await news.wait()
                news.clear()
                if not job.done:
                    yield job
        finally:
            self.leave(job, notify)
        if isinstance(job.result, Exception):
            raise job.result
        yield job

    # The following methods run under the lock.

    def _submit(self, job: Job) -> None:
        """Submit the next part of a job."""
        how: dict[str, Any] = {"hear": partial(self._heard, job)} if job.streams else {}
        rank = max(job.rank, HEAVY) if job.heavy else job.rank
        how |= {"owner": job.owner, "rank": rank, "seconds": job.seconds, "since": job.since}
        job.task = self.pool.submit(*job.call, *job.state, **how)
        job.task.add_done_callback(partial(self._returned, job))

    def _move_up(self, job: Job, owner: object, rank: int) -> None:
        """Give a job the rank of a visitor who needs it sooner; its task is no longer in the queue."""
        job.owner, job.rank = owner, rank
        if job.task is not None and not job.task.running():
            self._abandon(job)

    def _abandon(self, job: Job) -> None:
        task, job.task = job.task, None
        if task is not None:
            self.pool.abandon(task)

    def _forget(self, job: Job) -> None:
        if self._shared.get(job.call) is job:
            del self._shared[job.call]

    # The following methods are called in the thread of a worker.

    def _heard(self, job: Job, part: Any) -> None:
        """Take an item of a generator."""
        with self._lock:
            job.parts.append(part)
            listeners = list(job.listeners)
        for notify in listeners:
            notify(job)

    def _returned(self, job: Job, task: Any) -> None:
        """Take what a task has returned, or its error."""
        with self._lock:
            if job.task is not task:  # cancelled, or submitted again
                return
            job.task = None
            try:
                made = task.result()
            except (Exception, CancelledError) as error:  # an error in the code is in the log only
                made = ERROR if getattr(error, "kind", "") == "error" else error
            if isinstance(made, Part):
                self._continue(job, made)
            elif getattr(made, "kind", "") == "crash" and job.lost + 1 < ATTEMPTS:
                job.lost += 1
                job.parts = [] if job.streams else job.parts
                self._submit(job)
            else:
                self._finish(job, made)
            listeners = list(job.listeners)
        for notify in listeners:
            notify(job)

    def _continue(self, job: Job, part: Part) -> None:
        job.state, job.heavy = (part.state,), part.heavy
        if part.made is not None:
            job.parts.append(part.made)
            _count(part.made)
        self._submit(job)

    def _finish(self, job: Job, made: Any) -> None:
        job.done = True
        if isinstance(made, BaseException) or job.streams:
            job.result = made
        else:
            job.parts.append(made)
            _count(made)
            job.result = reduce(add, job.parts)
        self._forget(job)
        if job.shared and _is_final(job.result) and size_of(job.result) <= LARGEST:
            self.results.put(job.call, (job.call, job.result))


def _ended(call: tuple[Any, ...], result: Any) -> Job:
    """Return the job of a cached result."""
    job = Job(call, None, LATER, 0.0)
    job.result, job.parts, job.done = result, [result], True
    return job


def _is_final(made: Any) -> bool:
    """Whether the same call always ends like this."""
    return not isinstance(made, (Lost, CancelledError)) and not getattr(made, "failure", "")


def _count(made: Any) -> None:
    if isinstance(made, Frames):
        metrics.count("slices")
        metrics.count("evaluations", made.evaluations)


jobs = Jobs(shared_pool)
metrics.gauge("cache_bytes", "bytes of cached results", lambda: jobs.results.currsize)
