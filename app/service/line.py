"""Tasks for workers, and the line in which they wait: owners take turns."""

from collections import OrderedDict, deque
from concurrent.futures import Future

PATIENCE = (
    20.0  # s without a result, beyond what a task asks for, after which its process is killed: a busy server is slow
)
# what a task is for: somebody's screen; the exact run of what is on one already; a screen, but it takes long; the rest
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


class Line:
    """Waiting tasks, whose owners take turns."""

    def __init__(self):
        self._of = OrderedDict()  # owner: deque of tasks

    def __len__(self):
        return sum(map(len, self._of.values()))

    def __iter__(self):
        return (task for tasks in self._of.values() for task in tasks)

    def add(self, task):
        """At the end of its owner's tasks."""
        self._of.setdefault(task.owner, deque()).append(task)

    def take(self):
        """The task whose turn it is."""
        owner, tasks = next(iter(self._of.items()))
        task = tasks.popleft()
        self._of.move_to_end(owner)
        if not tasks:
            del self._of[owner]
        return task

    def place(self, task):
        """How many have their turn before this task; None if it does not wait here."""
        tasks = self._of.get(task.owner, ())
        if task not in tasks:
            return None
        before = tasks.index(task)
        owners = list(self._of)
        ahead = owners.index(task.owner)
        return sum(min(len(self._of[owner]), before + (k < ahead)) for k, owner in enumerate(owners))
