"""A map computed in processes, coarse to fine."""

from collections.abc import Iterable, Iterator

from ...isolated import Lost, outcomes
from .grid import Map, Outcome, Place, worked_off
from .point import Point


def explored(grid: Map, workers: int | str | None = None, points: Iterable[Point] = ()) -> Iterator[Point]:
    """Yields the Points of a Map, coarse to fine.

    Parameters: workers: the number of processes (default: one for each core), or the address of a dask cluster's
    scheduler; points: known ones, which are neither computed nor yielded.
    Returns an iterator of Points, in the order of completion; `grid.table` makes a DataFrame of them. A point that
    could not be computed has a `reason`.
    Raises ClusterError where the cluster cannot be used.

    Example: `grid = Map(Scene(), Axis("delta_bar", -0.2, 0.3, 6), Axis("nu", 0.0, 0.4, 5))`, then
    `grid.table(explored(grid))`
    """
    reached: dict[Place, Outcome] = {(point.i, point.j): (point, None) for point in points}
    levels = (grid.tiles(level, reached) for level in range(grid.levels))  # each is made once that before is complete
    tiles = next(filter(None, levels), [])
    for count, (k, result) in enumerate(outcomes(worked_off, tiles, workers), start=1):
        for point, skeleton in grid.lost(tiles[k], result.reason) if isinstance(result, Lost) else result:
            reached[point.i, point.j] = point, skeleton
            yield point
        if count == len(tiles):
            tiles += next(filter(None, levels), [])
