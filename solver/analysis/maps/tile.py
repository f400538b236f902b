"""Points next to known ones, each followed from the nearest: a pure function of a Tile."""

from dataclasses import dataclass, field, replace

from ...continuation.state import NotConverged
from ...following.branch import NotFollowed
from ...following.follow import follow
from ...following.skeleton import Skeleton
from ...scene import Scene, SceneError
from ...threads import one_thread
from .axis import Axis
from .point import NO_RESULT, Point, of_skeleton
from .run import computed

SOURCES = 2  # neighbours that a point is followed from, at most
BEND = 0.5  # of the span of U_s among its neighbours, by which a point may lie off a plane through them
SMALL = 0.01  # of U_s, the same where they are nearly equal
SAME = 1e-4  # nm, to which two ways to a point agree on U_s


@dataclass(frozen=True)
class Tile:
    """Points asked for, and what is known around them; picklable.

    asked: ((i, j), ((i, j) of a point around it, its weight in a linear interpolation), ...), in the order in which
    they are computed; a neighbour is known or asked for before. known: Points with their Skeletons, where these are
    there. keep: whether Skeletons are wanted, which are large. Tiles that ask for the same are equal.
    """

    scene: Scene
    x: Axis
    y: Axis
    asked: tuple[tuple[tuple[int, int], tuple[tuple[tuple[int, int], float], ...]], ...]
    known: tuple[tuple[Point, Skeleton | None], ...] = field(default=(), compare=False)
    keep: bool = True

    def scene_at(self, i, j):
        """Raises SceneError where there is none."""
        return self.scene.changed(**{self.x.name: float(self.x.values[i]), self.y.name: float(self.y.values[j])})


@one_thread()
def worked_off(tile):
    """[(Point, Skeleton or None)] of all points that a Tile asks for."""
    return list(points_of(tile))


def points_of(tile):
    """Yield (Point, Skeleton or None) in order; to be left between any two of them."""
    known = {(point.i, point.j): (point, skeleton) for point, skeleton in tile.known}
    for place, weights in tile.asked:
        around = [(known[other][0], weight) for other, weight in weights]
        by_distance = sorted(known, key=lambda other: (other[0] - place[0]) ** 2 + (other[1] - place[1]) ** 2)
        skeletons = [known[other][1] for other in by_distance if known[other][1] is not None]
        point, skeleton = _point(tile, place, around, skeletons[:SOURCES])
        known[place] = replace(point, i=place[0], j=place[1]), skeleton
        yield known[place][0], skeleton if tile.keep else None


def _point(tile, place, around, skeletons):
    """(Point, Skeleton or None): followed where that can be trusted, else from a run."""
    try:
        scene = tile.scene_at(*place)
        point, skeleton, spent = _followed(scene, around, skeletons)
        if point is None:
            point, skeleton = computed(scene)
    except SceneError as error:
        return Point(reason=str(error)), None
    return replace(point, evaluations=point.evaluations + spent), skeleton


def _followed(scene, around, skeletons):
    """(Point, its Skeleton, evaluations spent in vain), the first two None where a run has to tell.

    Where neighbours differ in kind, a regime ends between them: following cannot tell on which side a point lies, as
    where a slip lands is decided by its motion. A point must be of their kind, and near a plane through them; if it is
    not near, two ways must lead to it.
    """
    spent, before = 0, None
    kinds = {point.kind for point, _ in around}
    if len(kinds) != 1 or around[0][0].regime == NO_RESULT:
        return None, None, 0
    for skeleton in skeletons:
        try:
            found = follow(skeleton, scene)
            point = Point(**of_skeleton(found), followed=True)
        except (NotFollowed, NotConverged):
            continue
        spent += found.evaluations
        if point.kind not in kinds:
            break
        again = before is not None and _same(before.U_s, point.U_s)
        if again or _near(point, around):
            return point, found, spent
        before = point
    return None, None, spent


def _same(one, other):
    return one == other or (None not in (one, other) and abs(one - other) < SAME)


def _near(point, around):
    """Whether U_s is that of the neighbours, interpolated, as far as it can be told."""
    if point.U_s is None:
        return True
    loads = [other.U_s for other, _ in around]
    expected = sum(weight * load for load, (_, weight) in zip(loads, around, strict=True))
    return abs(point.U_s - expected) <= BEND * (max(loads) - min(loads)) + SMALL * expected
