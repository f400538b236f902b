"""One point of a map: followed from its nearest known neighbour where that is safe, else from a run."""

from dataclasses import dataclass, field, replace

from ...continuation.state import NotConverged
from ...following.follow import follow
from ...following.moved import NotFollowed
from ...following.skeleton import Skeleton
from ...scene import Scene, SceneError
from ...threads import one_thread
from .point import NO_RESULT, Point, of_skeleton
from .run import computed

# of U_s: a followed point may lie so far outside the range of U_s of the points around it, which may be nearly equal.
# Other tests, by a plane through the points and half and twice as far, accepted the same points (tests/bench/map.py)
SMALL = 0.01

Outcome = tuple[Point, Skeleton | None]


@dataclass(frozen=True)
class Task:
    """A point to compute; picklable. Tasks of one point of one map are equal.

    values: ((parameter, value), (parameter, value)) at the point (i, j). keep: whether to return the Skeleton, which is
    large. around: known Points near it; start: the Skeleton of the nearest one, if any.
    """

    scene: Scene
    values: tuple[tuple[str, float], ...]
    i: int
    j: int
    keep: bool = True
    around: tuple[Point, ...] = field(default=(), compare=False)
    start: Skeleton | None = field(default=None, compare=False)

    def scene_there(self) -> Scene:
        """The Scene of the point; raises SceneError where there is none."""
        return self.scene.changed(**dict(self.values))


@one_thread()
def computed_point(task: Task) -> Outcome:
    """(Point, its Skeleton or None) of a Task."""
    try:
        scene = task.scene_there()
    except SceneError as error:
        return Point(i=task.i, j=task.j, reason=str(error)), None
    point, skeleton = _followed(scene, task.around, task.start) or computed(scene)
    return replace(point, i=task.i, j=task.j), skeleton if task.keep else None


def _followed(scene, around, start):
    """(Point, its Skeleton); None where a run must decide.

    Where neighbours differ in kind, a regime ends between them: following cannot show on which side a point lies, as
    where a slip lands is decided by its motion. The point must be of their kind, with U_s in their range.
    """
    kinds = {point.kind for point in around}
    if start is None or len(kinds) != 1 or around[0].regime == NO_RESULT:
        return None
    try:
        moved = follow(start, scene)
        point = Point(**of_skeleton(moved), followed=True, evaluations=moved.evaluations)
    except (NotFollowed, NotConverged):
        return None
    loads = [other.U_s for other in around]
    near = point.U_s is None or min(loads) * (1.0 - SMALL) <= point.U_s <= max(loads) * (1.0 + SMALL)
    return (point, moved) if point.kind in kinds and near else None
