"""The axes of a map, its points computed from coarse to fine, and its results as arrays and tables."""

from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, Executor
from contextlib import nullcontext
from dataclasses import astuple, dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import plots
from ...executors import outcomes, processes
from ...following.follow import DISCRETE
from ...scene import LIMITS, PARAMETERS, Scene, SceneError
from .point import COLUMNS, QUANTITIES, Point
from .task import Outcome, Task, computed_point

if TYPE_CHECKING:
    import holoviews as hv
    import pandas as pd

COUNT = 2, 400  # values of an axis: one value is no axis, and 400 x 400 points take hours
CONTINUOUS = tuple(name for name, limits in LIMITS.items() if name not in DISCRETE and not limits.whole)
RUNS = 16  # points at first, which are all runs: their neighbours are too far to follow
AROUND = 4  # known points nearest to another: at the corners around it, or at the ends of its side
UNGUARDED = 'the processes ended at once: put the call of explore_map under `if __name__ == "__main__":`'

Place = tuple[int, int]  # (i, j) of a point: columns along x, rows along y


@dataclass(frozen=True)
class Axis:
    """Values of a continuous parameter for a Map.

    Parameters: name of the parameter; low, high: its range, in its unit; count: number of values; log: evenly spaced
    in the logarithm.
    Raises SceneError for a name or a range that is not allowed.

    Example: `Axis("delta_bar", -0.2, 0.3, 6)`
    """

    name: str
    low: float
    high: float
    count: int
    log: bool = False

    def __post_init__(self) -> None:
        if self.name not in CONTINUOUS:
            raise SceneError("axis", self.name, f"allowed: {', '.join(CONTINUOUS)}", "choose one of them")
        for value in (self.low, self.high):
            PARAMETERS[self.name].checked(self.name, value)
        if not np.isfinite(self.low) or not np.isfinite(self.high) or self.low == self.high:
            raise SceneError(self.name, f"{self.low:g}:{self.high:g}", "allowed: two finite values", "give two values")
        whole = isinstance(self.count, int | np.integer)  # type: ignore[redundant-expr]
        if not whole or not COUNT[0] <= self.count <= COUNT[1]:
            allowed = f"allowed: {COUNT[0]} .. {COUNT[1]} values, a whole number"
            raise SceneError(self.name, self.count, allowed, "give such a COUNT")
        if self.log and min(self.low, self.high) <= 0.0:
            raise SceneError(self.name, min(self.low, self.high), "allowed with log: above 0", "raise it, or omit log")

    @property
    def values(self) -> NDArray[np.float64]:
        """(count,), to 12 digits: -0.85, not -0.8500000000000001."""
        spaced = np.geomspace if self.log else np.linspace
        return np.array([float(f"{value:.12g}") for value in spaced(self.low, self.high, self.count)])


@dataclass(frozen=True)
class Map:
    """A grid of Points over two parameters of a Scene. It holds no results: see `explore_map`.

    Parameters: scene: the values of all other parameters; x, y: the Axes of the map.
    Raises SceneError where both Axes are of one parameter, or the path is one through points.

    Example: `Map(Scene(), Axis("delta_bar", -0.2, 0.3, 6), Axis("phi_ratio", 0.05, 1.0, 5))`

    A consumer takes the `places` in order. The `task` of each one starts from the nearest known point, and can be
    computed in any process.
    """

    scene: Scene
    x: Axis
    y: Axis

    def __post_init__(self) -> None:
        if self.x.name == self.y.name:
            raise SceneError("axis", self.y.name, "allowed: two different parameters", "choose another")
        if self.scene.legs:
            raise SceneError("path", "points", "allowed in a map: shear, unload or loop", "choose one of them")

    @property
    def size(self) -> int:
        """Points of the whole map."""
        return self.x.count * self.y.count

    def places(self) -> list[Place]:
        """All (i, j), each once, from coarse to fine: every part of the map soon has a point."""
        stride, listed = 1 << max(self.x.count, self.y.count).bit_length(), dict[Place, None]()
        while stride:
            columns, rows = (sorted({*range(0, axis.count, stride), axis.count - 1}) for axis in (self.x, self.y))
            listed |= dict.fromkeys(product(columns, rows))
            stride //= 2
        return list(listed)

    def task(self, place: Place, known: Mapping[Place, Outcome], limit: float | None = None) -> Task:
        """The Task of a place among the known Outcomes; limit: as of `explore_map`."""
        values = {axis.name: float(axis.values[k]) for axis, k in zip((self.x, self.y), place, strict=True)}
        near = _nearest(place, known) if len(known) >= RUNS else []
        around, start = tuple(point for point, _ in near[:AROUND]), next((kept for _, kept in near if kept), None)
        keep = not (place[0] % 2 or place[1] % 2)  # so that every other point has one with a Skeleton beside it
        return Task(self.scene, tuple(values.items()), *place, keep, around, start, limit)

    def array(self, points: Iterable[Point], of: str) -> NDArray[Any]:
        """(y.count, x.count) of a column of Points, nan where there is none; `of` "regime" gives codes, -1 unknown."""
        out = np.full((self.y.count, self.x.count), -1 if of == "regime" else np.nan)
        for point in points:
            value = point.code if of == "regime" else getattr(point, of)
            out[point.j, point.i] = np.nan if value is None else value
        return out.astype(int) if of == "regime" else out

    def table(self, points: Iterable[Point]) -> "pd.DataFrame":
        """A row per Point: i, j, the two parameters, and every other field of Point, "" for None."""
        from pandas import DataFrame  # takes longer to import than the solver

        table = DataFrame(list(map(astuple, points)), columns=COLUMNS, dtype=object)
        table = table.where(table.notna(), "")
        table.insert(2, self.x.name, self.x.values[table["i"].astype(int)])
        table.insert(3, self.y.name, self.y.values[table["j"].astype(int)])
        return table

    def plot(self, points: Iterable[Point], of: str = "U_s") -> "hv.Layout":
        """A quantity of Points over both parameters, and their regimes, as a HoloViews layout.

        of: a name in QUANTITIES. Raises ValueError for another one.

        Example: `Map(Scene(), Axis("E", 50.0, 90.0, 3), Axis("nu", 0.1, 0.4, 3)).plot([])`
        """
        if of not in QUANTITIES:
            raise ValueError(f"of = {of!r}; allowed: {', '.join(QUANTITIES)}; choose one of them")
        return plots.first_slips(self.table(points), self.x.name, self.y.name, of)


def explore_map(
    grid: Map, executor: Executor | None = None, ahead: int | None = None, limit: float | None = None
) -> Iterator[Point]:
    """Yields the Points of a Map, coarse to fine.

    Parameters: executor: any of `concurrent.futures`, or of a cluster (default: a process for each core: then call it
    under `if __name__ == "__main__":`); ahead: how many points the executor computes at a time (default: the number of
    cores); limit: processor time of a point, s (default: as of `simulate`).
    Returns an iterator of Points, in the order of completion; `grid.table` makes a DataFrame of them. A point that
    could not be computed has a `reason`.
    Raises RuntimeError for an executor that was shut down, and where processes end at once.

    Example: `grid = Map(Scene(), Axis("delta_bar", -0.2, 0.3, 6), Axis("nu", 0.0, 0.4, 5))`, then
    `grid.table(explore_map(grid))`
    """
    known = dict[Place, Outcome]()
    tasks = (
        grid.task(place, known, limit) for place in grid.places()
    )  # made when a process is free, so they know the others
    with processes() if executor is None else nullcontext(executor) as used:
        for task, result in outcomes(computed_point, tasks, used, ahead):
            failed = isinstance(result, Exception)
            if executor is None and not known and isinstance(result, BrokenExecutor):
                raise RuntimeError(UNGUARDED) from None
            reason = f"unexpected error {result!r}; run this scene alone to see where"
            known[task.i, task.j] = (Point(i=task.i, j=task.j, reason=reason), None) if failed else result
            yield known[task.i, task.j][0]


def _nearest(place, known):
    """The Outcomes of AROUND known places or more, from a square around `place`, the nearest first."""
    half, inside = 1, list[Place]()
    while len(inside) < AROUND:
        columns, rows = (range(k - half, k + half + 1) for k in place)
        inside, half = [other for other in product(columns, rows) if other in known], 2 * half
    inside.sort(key=lambda other: (other[0] - place[0]) ** 2 + (other[1] - place[1]) ** 2)
    return [known[other] for other in inside]
