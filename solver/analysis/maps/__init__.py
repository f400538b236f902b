"""The first slip over two parameters: each point is followed from its nearest neighbour, or run where that is not safe.

point    the regime of a scene and numbers of its first slip
run      such a point from a run
task     one point, followed or run
grid     axes, and the map from coarse to fine
explore  all points of a map, computed in processes
"""

from .explore import explore_map
from .grid import Axis, Map
from .point import COLUMNS, REGIMES, Point
from .task import Outcome, Task, computed_point

__all__ = ["COLUMNS", "REGIMES", "Axis", "Map", "Outcome", "Point", "Task", "computed_point", "explore_map"]
