"""The map from coarse to fine: levels of Tiles, and what came of them."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...scene import SceneError
from .point import Point
from .tile import Tile

COARSEST = 16  # points of the first level, at most, which are all run: a picture within about 2 s on two cores


@dataclass(frozen=True)
class Map:
    """A grid of Points over two parameters of a Scene: which Tiles make it. Holds nothing of the results.

    Level 0 covers the map with a few points; each other level halves their distance. A consumer works off the Tiles of
    a level in any order, in any process, and asks for those of the next with what came of them.
    """

    scene: object
    x: object
    y: object

    def __post_init__(self):
        if self.x.name == self.y.name:
            raise SceneError("axis", self.y.name, "allowed: two different parameters", "choose another")

    @property
    def size(self):
        """Points of the whole map."""
        return self.x.count * self.y.count

    @property
    def levels(self):
        """How many there are."""
        stride, lines = 1, (range(self.x.count), range(self.y.count))
        while len(lines[0]) * len(lines[1]) > COARSEST:
            stride *= 2
            lines = _lines(self.x.count, stride), _lines(self.y.count, stride)
        return stride.bit_length()

    def cells(self, level):
        """[((place, weights), ...)] of a level: what its Tiles ask for, if nothing of it is known yet."""
        stride = self._stride(level)
        return list(_asked_first(self, stride) if level == 0 else _asked_between(self, stride))

    def tiles(self, level, known):
        """The Tiles of a level; known: {(i, j): (Point, Skeleton or None)} of all levels before."""
        return [tile for tile in (self.tile(level, cell, known) for cell in self.cells(level)) if tile.asked]

    def tile(self, level, cell, known):
        """The Tile of a cell; what is known of it is not asked for again, but serves as a neighbour."""
        asked = tuple((place, weights) for place, weights in cell if place not in known)
        around = corners(cell) | {place for place, _ in cell}
        there = tuple(known[place] for place in sorted(around) if place in known)
        return Tile(self.scene, self.x, self.y, asked, there, level < self.levels - 1)

    def _stride(self, level):
        return 2 ** (self.levels - 1 - level)

    def array(self, points, of):
        """(y.count, x.count) of a column of Points, nan where there is none; `of` "regime" gives codes, -1 unknown."""
        out = np.full((self.y.count, self.x.count), -1 if of == "regime" else np.nan)
        for point in points:
            value = point.code if of == "regime" else getattr(point, of)
            out[point.j, point.i] = np.nan if value is None else value
        return out.astype(int) if of == "regime" else out

    def lost(self, tile, reason):
        """The Points of a Tile that has no outcome, as pairs."""
        return [(replace(Point(reason=reason), i=i, j=j), None) for (i, j), _ in tile.asked]


def corners(cell):
    """{(i, j)} that must be known before the points of a cell can be asked for."""
    return {place for _, weights in cell for place, _ in weights} - {place for place, _ in cell}


def _lines(count, stride):
    """Places of a level along an axis: every `stride`-th and the last."""
    return sorted({*range(0, count, stride), count - 1})


def _asked_first(grid, stride):
    """Of every Tile of the first level, one point: with nobody around, it is run."""
    for i in _lines(grid.x.count, stride):
        for j in _lines(grid.y.count, stride):
            yield (((i, j), ()),)


def _asked_between(grid, stride):
    """Of every Tile of a later level: the new points of a cell of the level before, but those of its far sides.

    The far sides are the near ones of the next cells, unless there is none.
    """
    columns, rows = _lines(grid.x.count, 2 * stride), _lines(grid.y.count, 2 * stride)
    for a, b in pairwise(columns):
        for c, d in pairwise(rows):
            xs = [i for i in _lines(grid.x.count, stride) if a <= i < b or i == b == columns[-1]]
            ys = [j for j in _lines(grid.y.count, stride) if c <= j < d or j == d == rows[-1]]
            new = [(i, j) for i in xs for j in ys if not (i in (a, b) and j in (c, d))]
            new.sort(key=lambda place: place[0] not in (a, b) and place[1] not in (c, d))  # the middle last
            yield tuple((place, _weights(place, (a, b), (c, d))) for place in new)


def _weights(place, xs, ys):
    """((corner of a cell, its weight in the bilinear interpolation there), ...), those that are not 0."""
    parts = [
        [(end, abs(at - other) / abs(ends[1] - ends[0])) for end, other in (ends, ends[::-1])]
        for at, ends in zip(place, (xs, ys), strict=True)
    ]
    return tuple(((i, j), p * q) for i, p in parts[0] for j, q in parts[1] if p * q > 0.0)
