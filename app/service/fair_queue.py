"""A queue of jobs that serves their owners in turn."""

from collections import OrderedDict, deque
from collections.abc import Collection, Iterator
from time import monotonic

from app.service.job import HEAVY, RANKS, Job

# s of waiting that equal one rank: while sliders are dragged all the time, slow runs still get turns. With 2 s, a class
# of 30 that drags on two cores gets half of the pictures, as exact runs take the workers
AGEING = 6.0


class FairQueue:
    """Waiting jobs: lower ranks come first unless a higher one has waited long; owners take turns in each rank.

    An owner whose jobs were removed keeps its turn until it comes: a newer job may have taken their place.
    """

    def __init__(self) -> None:
        self._of: tuple[OrderedDict[object, deque[Job]], ...] = tuple(OrderedDict() for _ in range(RANKS))

    def __iter__(self) -> Iterator[Job]:
        return (job for owners in self._of for jobs in owners.values() for job in jobs)

    def add(self, job: Job) -> None:
        """Append a job to those of its owner; however old it is, it does not go before those that are there."""
        job.queued = max(job.rank, HEAVY) if job.heavy else job.rank
        job.due = max(monotonic(), job.since + AGEING * job.queued)
        self._of[job.queued].setdefault(job.owner, deque()).append(job)

    def remove(self, job: Job) -> bool:
        """Remove a job; return whether it was here."""
        jobs = self._of[job.queued].get(job.owner, deque())
        if here := job in jobs:
            jobs.remove(job)
        return here

    def take(self, ranks: Collection[int] = range(RANKS)) -> Job | None:
        """Remove and return the next job of these ranks, or None."""
        first = [jobs[0] for rank in ranks if (jobs := self._next(self._of[rank]))]
        if not first:
            return None
        job = min(first, key=lambda job: job.due)
        owners = self._of[job.queued]
        owners[job.owner].popleft()
        owners.move_to_end(job.owner)
        if not owners[job.owner]:
            del owners[job.owner]
        return job

    def _next(self, owners):
        """Return the jobs of the owner whose turn it is; owners without jobs lose their turn."""
        while owners:
            owner, jobs = next(iter(owners.items()))
            if jobs:
                return jobs
            del owners[owner]
        return ()

    def position(self, job: Job) -> int | None:
        """Number of jobs before this one, unless a later one has waited longer; None if it does not wait here."""
        owners = self._of[job.queued]
        jobs = owners.get(job.owner, ())
        if job not in jobs:
            return None
        before, ahead = jobs.index(job), list(owners).index(job.owner)
        sooner = sum(len(jobs) for others in self._of[: job.queued] for jobs in others.values())
        return sooner + sum(min(len(jobs), before + (k < ahead)) for k, jobs in enumerate(owners.values()))
