"""The first slip over two parameters: each point is followed from its nearest neighbour, or run where that is not safe.

point    the regime of a scene and numbers of its first slip
task     one point, followed or from a run
grid     axes, the map from coarse to fine, all its points computed in processes
"""

from .grid import Axis, Map, explore_map
from .point import COLUMNS, REGIMES, Point
from .task import Outcome, Task, computed_point

__all__ = ["COLUMNS", "REGIMES", "Axis", "Map", "Outcome", "Point", "Task", "computed_point", "explore_map"]
