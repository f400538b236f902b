"""Tasks for workers, and the queue in which they wait: owners take turns."""

from collections import OrderedDict, deque
from concurrent.futures import Future

PATIENCE = 20.0  # s beyond what a task asks for, after which its process is killed: a busy server is slow
NOBODY = "the server"  # the owner of tasks for which no visitor waits
# What a task is for: a screen; the exact run behind a picture; a screen, but it takes long; the rest
SCREEN, EXACT, HEAVY, LATER = range(RANKS := 4)


class Task(Future):
    """A call to be made by a worker, for an owner.

    Its exception is a `solver.isolated.Lost` where the worker ended before the call did; unless the kind is "error", it
    may be made again. `seat` is where it runs or ran, `abandoned` says that nobody waits for it.
    """

    def __init__(self, call, owner=None, rank=SCREEN, limit=PATIENCE):
        super().__init__()
        self.call, self.owner, self.rank, self.limit = call, owner, rank, limit
        self.seat, self.abandoned = None, False


class FairQueue:
    """Waiting tasks: those of a lower rank come first, and in each rank owners take turns."""

    def __init__(self):
        self._of = tuple(OrderedDict() for _ in range(RANKS))  # {owner: deque of tasks}, by rank

    def __iter__(self):
        return (task for owners in self._of for tasks in owners.values() for task in tasks)

    @property
    def rank(self):
        """Of the task whose turn it is; None if there is none."""
        return next((rank for rank, owners in enumerate(self._of) if owners), None)

    def add(self, task):
        """At the end of its owner's tasks."""
        self._of[task.rank].setdefault(task.owner, deque()).append(task)

    def take(self):
        """The task whose turn it is."""
        owners = self._of[self.rank]
        owner, tasks = next(iter(owners.items()))
        owners.move_to_end(owner)
        task = tasks.popleft()
        if not tasks:
            del owners[owner]
        return task

    def position(self, task):
        """How many have their turn before this task; None if it does not wait here."""
        owners = self._of[task.rank]
        tasks = owners.get(task.owner, ())
        if task not in tasks:
            return None
        before, ahead = tasks.index(task), list(owners).index(task.owner)
        sooner = sum(len(tasks) for others in self._of[: task.rank] for tasks in others.values())
        return sooner + sum(min(len(tasks), before + (k < ahead)) for k, tasks in enumerate(owners.values()))
