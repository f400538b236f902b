"""A map computed in processes, coarse to fine."""

from collections.abc import Iterable, Iterator
from concurrent.futures import Executor
from contextlib import nullcontext

from ...executors import outcomes, processes
from .grid import Map, Place
from .point import Point
from .task import Outcome, Task, computed_point


def explore_map(
    grid: Map, executor: Executor | None = None, points: Iterable[Point] = (), ahead: int | None = None
) -> Iterator[Point]:
    """Yields the Points of a Map, coarse to fine.

    Parameters: executor: any of `concurrent.futures`, or of a cluster (default: a process for each core: then call it
    under `if __name__ == "__main__":`); points: known ones, which are neither computed nor yielded; ahead: how many
    points the executor computes at a time (default: the number of cores).
    Returns an iterator of Points, in the order of completion; `grid.table` makes a DataFrame of them. A point that
    could not be computed has a `reason`.
    Raises RuntimeError for an executor that was shut down.

    Example: `grid = Map(Scene(), Axis("delta_bar", -0.2, 0.3, 6), Axis("nu", 0.0, 0.4, 5))`, then
    `grid.table(explore_map(grid))`
    """
    known: dict[Place, Outcome] = {(point.i, point.j): (point, None) for point in points}

    def tasks() -> Iterator[Task]:  # each is made when a process is free, and so knows the points before it
        for place in [place for place in grid.places() if place not in known]:
            yield grid.task(place, known)

    with processes() if executor is None else nullcontext(executor) as used:
        for task, result in outcomes(computed_point, tasks(), used, ahead):
            failed = isinstance(result, Exception)
            reason = f"unexpected error {result!r}; run this scene alone to see where"
            known[task.i, task.j] = (Point(i=task.i, j=task.j, reason=reason), None) if failed else result
            yield known[task.i, task.j][0]
