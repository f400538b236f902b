"""The first slip over two parameters: each point followed from its neighbours, or run where that cannot be trusted.

point    what is told of a scene up to just beyond its first slip, and its regime
run      from a run, which ends there
axis     values of a parameter
tile     points next to known ones: a pure function of what it is given, for any pool
grid     the map from coarse to fine, as tiles
"""

from .axis import Axis
from .grid import Map
from .point import COLUMNS, REGIMES, Point
from .tile import Tile, points_of, worked_off

__all__ = ["COLUMNS", "REGIMES", "Axis", "Map", "Point", "Tile", "points_of", "worked_off"]
