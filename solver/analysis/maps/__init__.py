"""The first slip over two parameters: each point is followed from its neighbours, or run where that is not safe.

point    the regime of a scene and numbers of its first slip
run      such a point from a run
grid     axes, the map from coarse to fine, and its tiles
explore  all points of a map, computed in processes
"""

from .explore import explored
from .grid import Axis, Map, Tile, points_of, worked_off
from .point import COLUMNS, REGIMES, Point

__all__ = ["COLUMNS", "REGIMES", "Axis", "Map", "Point", "Tile", "explored", "points_of", "worked_off"]
