"""Tasks for workers, and a queue that serves the owners of tasks in turn."""

from collections import OrderedDict, deque
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import Future
from time import monotonic
from typing import Any

PATIENCE = 20.0  # s beyond a task's own limit; then its process is killed. A busy server is slow
NOBODY = "the server"  # owner of the tasks that no visitor waits for
# Purpose of a task: the screen; the exact run of a picture; any that takes long; in the background, a second at most
SCREEN, EXACT, HEAVY, LATER = range(RANKS := 4)
# s of waiting that equal one rank: while sliders are dragged all the time, slow runs still get turns. With 2 s, a class
# of 30 that drags on two cores gets half of the pictures, as exact runs take the workers
AGEING = 6.0


class Task(Future):
    """A call that a worker makes for an owner.

    since: when its job began to wait, s, monotonic; now by default.

    Its exception is a `caller.Lost` if the worker ended before the call. The call may then be repeated, unless
    the kind is "error". `slot` is the slot that runs or ran it; `abandoned` is true when nobody waits for it.
    """

    def __init__(
        self,
        call: tuple[Any, ...],
        owner: object = None,
        rank: int = SCREEN,
        limit: float = PATIENCE,
        since: float | None = None,
    ) -> None:
        super().__init__()
        self.call, self.owner, self.rank, self.limit = call, owner, rank, limit
        self.slot: Any = None
        self.abandoned = False
        self.hear: Callable[[Any], None] | None = None  # receives the items of a generator
        now = monotonic()
        # s: of two waiting tasks the earlier one is first. However old its job, a task does not go before those
        # that are there
        self.due = max(now, (now if since is None else since) + AGEING * rank)


class FairQueue:
    """Waiting tasks: lower ranks come first unless a higher one has waited long; owners take turns in each rank.

    An owner whose tasks were removed keeps its turn until it comes: a newer task may have taken their place.
    """

    def __init__(self) -> None:
        self._of: tuple[OrderedDict[object, deque[Task]], ...] = tuple(OrderedDict() for _ in range(RANKS))

    def __iter__(self) -> Iterator[Task]:
        return (task for owners in self._of for tasks in owners.values() for task in tasks)

    def add(self, task: Task) -> None:
        """Append a task to the tasks of its owner."""
        self._of[task.rank].setdefault(task.owner, deque()).append(task)

    def remove(self, task: Task) -> None:
        """Remove a task that was cancelled; it need not be here."""
        tasks = self._of[task.rank].get(task.owner, deque())
        if task in tasks:
            tasks.remove(task)

    def take(self, ranks: Collection[int] = range(RANKS)) -> Task | None:
        """Remove and return the next task of these ranks, or None."""
        first = [tasks[0] for rank in ranks if (tasks := self._next(self._of[rank]))]
        if not first:
            return None
        task = min(first, key=lambda task: task.due)
        owners = self._of[task.rank]
        owners[task.owner].popleft()
        owners.move_to_end(task.owner)
        if not owners[task.owner]:
            del owners[task.owner]
        return task

    def _next(self, owners):
        """Return the tasks of the owner whose turn it is; owners without tasks lose their turn."""
        while owners:
            owner, tasks = next(iter(owners.items()))
            if tasks:
                return tasks
            del owners[owner]
        return ()

    def position(self, task: Task) -> int | None:
        """Number of tasks before this one, unless a later one has waited longer; None if it does not wait here."""
        owners = self._of[task.rank]
        tasks = owners.get(task.owner, ())
        if task not in tasks:
            return None
        before, ahead = tasks.index(task), list(owners).index(task.owner)
        sooner = sum(len(tasks) for others in self._of[: task.rank] for tasks in others.values())
        return sooner + sum(min(len(tasks), before + (k < ahead)) for k, tasks in enumerate(owners.values()))
