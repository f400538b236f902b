"""Tasks for workers, and a queue that serves the owners of tasks in turn."""

from collections import OrderedDict, deque
from concurrent.futures import Future

PATIENCE = 20.0  # s beyond a task's own limit; then its process is killed. A busy server is slow
NOBODY = "the server"  # owner of the tasks that no visitor waits for
# Purpose of a task: the screen; the exact run of a picture; an expensive one for the screen; anything else
SCREEN, EXACT, HEAVY, LATER = range(RANKS := 4)


class Task(Future):
    """A call that a worker makes for an owner.

    Its exception is a `solver.isolated.Lost` if the worker ended before the call. The call may then be repeated, unless
    the kind is "error". `slot` is the slot that runs or ran it; `abandoned` is true when nobody waits for it.
    """

    def __init__(self, call, owner=None, rank=SCREEN, limit=PATIENCE):
        super().__init__()
        self.call, self.owner, self.rank, self.limit = call, owner, rank, limit
        self.slot, self.abandoned = None, False


class FairQueue:
    """Waiting tasks: lower ranks come first, and the owners take turns in each rank."""

    def __init__(self):
        self._of = tuple(OrderedDict() for _ in range(RANKS))  # {owner: deque of tasks}, by rank

    def __iter__(self):
        return (task for owners in self._of for tasks in owners.values() for task in tasks)

    def add(self, task):
        """Append a task to the tasks of its owner."""
        self._of[task.rank].setdefault(task.owner, deque()).append(task)

    def take(self, most=LATER):
        """Remove and return the next task of this rank or a lower one, or None."""
        owners = next(filter(None, self._of[: most + 1]), None)
        if owners is None:
            return None
        owner, tasks = next(iter(owners.items()))
        owners.move_to_end(owner)
        task = tasks.popleft()
        if not tasks:
            del owners[owner]
        return task

    def position(self, task):
        """Number of tasks before this one; None if it does not wait here."""
        owners = self._of[task.rank]
        tasks = owners.get(task.owner, ())
        if task not in tasks:
            return None
        before, ahead = tasks.index(task), list(owners).index(task.owner)
        sooner = sum(len(tasks) for others in self._of[: task.rank] for tasks in others.values())
        return sooner + sum(min(len(tasks), before + (k < ahead)) for k, tasks in enumerate(owners.values()))
