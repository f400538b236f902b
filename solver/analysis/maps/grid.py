"""A map from coarse to fine: its axes, its levels of Tiles, and the Points of a Tile.

A Tile is a call for any pool of processes. It follows its points from known neighbours, or runs them.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...continuation.state import NotConverged
from ...following.follow import SAME, follow
from ...following.moved import NotFollowed
from ...following.skeleton import Skeleton
from ...scene import LIMITS, PARAMETERS, Scene, SceneError
from ...threads import one_thread
from .point import COLUMNS, NO_RESULT, Point, of_skeleton
from .run import computed

if TYPE_CHECKING:
    import pandas as pd

COUNT = 2, 400  # values of an axis: one value is no axis, and 400 x 400 points take hours
FORM = "allowed: NAME=LOW:HIGH:COUNT or NAME=LOW:HIGH:COUNT:log; give one of these"
CONTINUOUS = tuple(name for name, limits in LIMITS.items() if name not in SAME and not limits.whole)
COARSEST = 16  # most points of the first level, all of them runs: a picture within about 2 s on two cores
SOURCES = 2  # neighbours from which a point is followed, at most: two ways that agree confirm each other
# of U_s: a followed point may lie so far outside the range of U_s at the corners around it, which may be nearly equal.
# Other tests, by a plane through the corners and half and twice as far, accepted the same points (tests/bench/map.py)
SMALL = 0.01
ALIKE = 1e-4  # nm, to which U_s agrees if two ways lead to one slip: ten times the tolerance of a state

Place = tuple[int, int]  # (i, j) of a point: columns along x, rows along y
Outcome = tuple[Point, Skeleton | None]


class Cell(NamedTuple):
    """New points of a level, in the order of their computation, and the corners around them, of the level before."""

    new: tuple[Place, ...]
    corners: tuple[Place, ...] = ()


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
        if not isinstance(self.count, int | np.integer) or not COUNT[0] <= self.count <= COUNT[1]:
            allowed = f"allowed: {COUNT[0]} .. {COUNT[1]} values, a whole number"
            raise SceneError(self.name, self.count, allowed, "give such a COUNT")
        if self.log and min(self.low, self.high) <= 0.0:
            raise SceneError(self.name, min(self.low, self.high), "allowed with log: above 0", "raise it, or omit log")

    @staticmethod
    def of(text: str) -> "Axis":
        """The Axis of 'phi_ratio=0.02:2:31:log'."""
        name, _, rest = text.partition("=")
        parts = rest.split(":")
        log = parts[3:] == ["log"]
        try:
            low, high, count = parts[:3] if log else parts
            return Axis(name.strip(), float(low), float(high), int(count), log)
        except SceneError:
            raise
        except ValueError:
            raise SceneError("axis", text, FORM, f"as in {CONTINUOUS[0]}=-1:1:41") from None

    @property
    def values(self) -> NDArray[np.float64]:
        """(count,), to 12 digits: -0.85, not -0.8500000000000001."""
        spaced = np.geomspace if self.log else np.linspace
        return np.array([float(f"{value:.12g}") for value in spaced(self.low, self.high, self.count)])


@dataclass(frozen=True)
class Tile:
    """Points to compute, in this order, and known points around them; picklable.

    known: Points at the corners and among those asked for, with their Skeletons, if any. keep: whether to return
    Skeletons, which are large. Tiles that ask for the same points are equal.
    """

    scene: Scene
    x: Axis
    y: Axis
    asked: tuple[Place, ...]
    corners: tuple[Place, ...] = ()
    known: tuple[Outcome, ...] = field(default=(), compare=False)
    keep: bool = True

    def scene_at(self, place: Place) -> Scene:
        """The Scene of a point; raises SceneError where there is none."""
        values = {axis.name: float(axis.values[k]) for axis, k in zip((self.x, self.y), place, strict=True)}
        return self.scene.changed(**values)


@one_thread()
def worked_off(tile: Tile) -> list[Outcome]:
    """[(Point, Skeleton or None)] of all points that a Tile asks for."""
    return list(points_of(tile))


def points_of(tile: Tile) -> Iterator[Outcome]:
    """Yields (Point, Skeleton or None) of the points that a Tile asks for, in order; may be left after any of them."""
    known = {(point.i, point.j): (point, skeleton) for point, skeleton in tile.known}
    for place in tile.asked:
        in_line = [corner for corner in tile.corners if corner[0] == place[0] or corner[1] == place[1]]
        around = [known[corner][0] for corner in in_line or tile.corners]  # of a point on a side, its two ends
        by_distance = sorted(known, key=lambda other: (other[0] - place[0]) ** 2 + (other[1] - place[1]) ** 2)
        skeletons = [known[other][1] for other in by_distance if known[other][1] is not None]
        point, skeleton = _point(tile, place, around, skeletons[:SOURCES])
        known[place] = replace(point, i=place[0], j=place[1]), skeleton
        yield known[place][0], skeleton if tile.keep else None


def _point(tile, place, around, skeletons):
    """(Point, Skeleton or None): followed where that is safe, else from a run."""
    try:
        scene = tile.scene_at(place)
        point, skeleton, spent = _followed(scene, around, skeletons)
        if point is None:
            point, skeleton = computed(scene)
    except SceneError as error:
        return Point(reason=str(error)), None
    return replace(point, evaluations=point.evaluations + spent), skeleton


def _followed(scene, around, skeletons):
    """(Point, its Skeleton, evaluations of rejected attempts); the first two are None where a run must decide.

    Where neighbours differ in kind, a regime ends between them: following cannot show on which side a point lies, as
    where a slip lands is decided by its motion. The point must be of their kind, with U_s in their range. If U_s is
    outside, following from two neighbours must give the same one.
    """
    spent, before = 0, None
    kinds = {point.kind for point in around}
    if len(kinds) != 1 or around[0].regime == NO_RESULT:
        return None, None, 0
    for skeleton in skeletons:
        try:
            moved = follow(skeleton, scene)
            point = Point(**of_skeleton(moved), followed=True)
        except (NotFollowed, NotConverged):
            continue
        spent += moved.evaluations
        if point.kind not in kinds:
            break
        if _near(point, around) or (before is not None and abs(before.U_s - point.U_s) < ALIKE):
            return point, moved, spent
        before = point
    return None, None, spent


def _near(point, around):
    """Whether U_s is in the range of its neighbours, or nearly; True without a slip."""
    loads = [other.U_s for other in around]
    return point.U_s is None or min(loads) * (1.0 - SMALL) <= point.U_s <= max(loads) * (1.0 + SMALL)


@dataclass(frozen=True)
class Map:
    """A grid of Points over two parameters of a Scene, divided into Tiles. It holds no results: see `explored`.

    Parameters: scene: the values of all other parameters; x, y: the Axes of the map.
    Raises SceneError where both Axes are of one parameter, or the path is one through points.

    Example: `Map(Scene(), Axis("delta_bar", -0.2, 0.3, 6), Axis("phi_ratio", 0.05, 1.0, 5))`

    Level 0 covers the map with a few points; each other level halves their distance. A consumer computes the Tiles of a
    level in any order, in any process, and builds those of the next level from their results.
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

    @property
    def levels(self) -> int:
        """The number of levels."""
        stride, lines = 1, (range(self.x.count), range(self.y.count))
        while len(lines[0]) * len(lines[1]) > COARSEST:
            stride *= 2
            lines = _lines(self.x.count, stride), _lines(self.y.count, stride)
        return stride.bit_length()

    def cells(self, level: int) -> list[Cell]:
        """The Cells of a level, one per Tile; those of the first level are single points, without any around them."""
        stride = 2 ** (self.levels - 1 - level)
        if level:
            return list(_between(self, stride))
        columns, rows = _lines(self.x.count, stride), _lines(self.y.count, stride)
        return [Cell(((i, j),)) for i in columns for j in rows]

    def tiles(self, level: int, known: Mapping[Place, Outcome]) -> list[Tile]:
        """The Tiles of a level; known: the outcomes of all levels before."""
        return [tile for tile in (self.tile(level, cell, known) for cell in self.cells(level)) if tile.asked]

    def tile(self, level: int, cell: Cell, known: Mapping[Place, Outcome]) -> Tile:
        """The Tile of a Cell; it asks only for unknown points, and known ones serve as neighbours."""
        asked = tuple(place for place in cell.new if place not in known)
        neighbours = tuple(known[place] for place in sorted({*cell.corners, *cell.new}) if place in known)
        return Tile(self.scene, self.x, self.y, asked, cell.corners, neighbours, level < self.levels - 1)

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

        table = DataFrame([point.as_row() for point in points], columns=COLUMNS, dtype=object)
        table.insert(2, self.x.name, self.x.values[table["i"].astype(int)])
        table.insert(3, self.y.name, self.y.values[table["j"].astype(int)])
        return table

    def lost(self, tile: Tile, reason: str) -> list[Outcome]:
        """The outcomes of a Tile whose call failed."""
        return [(Point(reason=reason, i=i, j=j), None) for i, j in tile.asked]


def _lines(count, stride):
    """Positions of a level along an axis: every `stride`-th and the last."""
    return sorted({*range(0, count, stride), count - 1})


def _between(grid, stride):
    """Yields the Cells of a later level: the new points of each cell of the level before, except on its far sides.

    The far sides are the near ones of the next cells, unless there is none.
    """
    columns, rows = _lines(grid.x.count, 2 * stride), _lines(grid.y.count, 2 * stride)
    for a, b in pairwise(columns):
        for c, d in pairwise(rows):
            xs = [i for i in _lines(grid.x.count, stride) if a <= i < b or i == b == columns[-1]]
            ys = [j for j in _lines(grid.y.count, stride) if c <= j < d or j == d == rows[-1]]
            new = [(i, j) for i in xs for j in ys if not (i in (a, b) and j in (c, d))]
            new.sort(key=lambda place: place[0] not in (a, b) and place[1] not in (c, d))  # the middle last
            yield Cell(tuple(new), ((a, c), (a, d), (b, c), (b, d)))
