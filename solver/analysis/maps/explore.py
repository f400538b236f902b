"""A map computed in processes, coarse to fine."""

from collections.abc import Iterable, Iterator

from ...isolated import Lost, outcomes
from .grid import Map, Place
from .point import Point
from .task import Outcome, Task, computed_point


def explored(grid: Map, workers: int | str | None = None, points: Iterable[Point] = ()) -> Iterator[Point]:
    """Yields the Points of a Map, coarse to fine.

    Parameters: workers: the number of processes (default: one for each core), or the address of a dask cluster's
    scheduler; points: known ones, which are neither computed nor yielded.
    Returns an iterator of Points, in the order of completion; `grid.table` makes a DataFrame of them. A point that
    could not be computed has a `reason`.
    Raises Lost where the cluster cannot be used.

    Example: `grid = Map(Scene(), Axis("delta_bar", -0.2, 0.3, 6), Axis("nu", 0.0, 0.4, 5))`, then
    `grid.table(explored(grid))`
    """
    known: dict[Place, Outcome] = {(point.i, point.j): (point, None) for point in points}
    asked: list[Place] = []

    def tasks() -> Iterator[Task]:  # each is made when a process is free, and so knows the points before it
        for place in [place for place in grid.places() if place not in known]:
            asked.append(place)
            yield grid.task(place, known)

    for k, result in outcomes(computed_point, tasks(), workers):
        i, j = asked[k]
        known[i, j] = (Point(i=i, j=j, reason=result.sentence), None) if isinstance(result, Lost) else result
        yield known[i, j][0]
