"""One point of a map: followed from its nearest known neighbour where that is safe, else from a run."""

from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from ...continuation.state import NotConverged, PulledOff
from ...following.follow import follow
from ...following.from_run import skeleton_from
from ...following.moved import NotFollowed
from ...following.skeleton import Skeleton
from ...run.frame import slips_in
from ...run.loadpath import time_limit, until
from ...run.summary import summarize
from ...scene import Scene, SceneError
from ...threads import computation
from .point import DETACHES, NEVER_TOUCHES, NO_RESULT, STICKS, Point, at_slip, of_skeleton, touches

# of U_s: a followed point may lie so far outside the range of U_s of the points around it, which may be nearly equal.
# Other tests, by a plane through the points and half and twice as far, accepted the same points (tests/bench/map.py)
SMALL = 0.01
EVALUATIONS = 300_000  # force evaluations, a hundred times those of the default: beyond, a point is given up

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
    limit: float | None = None  # s of processor time of a run; None: as of `simulate`

    def scene_there(self) -> Scene:
        """The Scene of the point; raises SceneError where there is none."""
        return self.scene.changed(**dict(self.values))


@computation
def computed_point(task: Task) -> Outcome:
    """(Point, its Skeleton or None) of a Task."""
    try:
        scene = task.scene_there()
    except SceneError as error:
        return Point(i=task.i, j=task.j, reason=str(error)), None
    point, skeleton = _followed(scene, task.around, task.start) or computed(scene, task.limit)
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


def computed(scene: Scene, limit: float | None = None) -> tuple[Point, Skeleton | None]:
    """(Point, Skeleton or None) of a scene, from its start; limit: processor time, s."""
    frames, skeleton, slips, spent, reason, off = [], None, 0, 0, "", False
    smooth = False  # whether the run had no slip over one lattice period
    try:
        for frame, checkpoint in until(scene, limit=time_limit(scene, limit)):
            frames.append(frame)
            spent += frame.evaluations
            if spent > EVALUATIONS:
                reason = f"no slip within {EVALUATIONS} force evaluations; raise E, or lower u_x_max"
                break
            if frame.stage != "shear":
                continue
            slips += len(slips_in(frame))
            # two slips after the first, while the run does not repeat itself: of sliding runs 3 in 4 repeat after one,
            # and nearly all others after two or three
            if (frame.index == 0 and not touches(frame)) or slips > 2 or (slips and frame.repeated):
                break
            if not slips and not smooth and frame.U_x >= scene.spacing:
                smooth, skeleton = True, _skeleton(scene, checkpoint)
                if skeleton is not None:
                    break
    except NotConverged as failure:
        reason, off = str(failure), isinstance(failure, PulledOff)
    sheared = [f for f in frames if f.stage == "shear"]
    if skeleton is None and sheared and touches(sheared[0]):
        skeleton = _skeleton(scene, checkpoint)
    if scene.path == "unload" and not reason:
        summary, lifted = summarize(frames), [frame for frame in frames if frame.stage == "unload"]
        regime = NEVER_TOUCHES if not touches(lifted[0]) else STICKS if touches(lifted[-1]) else DETACHES
        numbers = {"regime": regime} | {name: summary[name] for name in ("A_0", "L_min", "L_off")}
    else:
        numbers = _of_shear(sheared, skeleton, reason, off)
    return Point(**numbers, evaluations=spent), skeleton


def _skeleton(scene, checkpoint):
    """The Skeleton of a run so far, or None."""
    with suppress(NotFollowed):
        return skeleton_from(scene, checkpoint)


def _of_shear(sheared, skeleton, reason, off):
    """Fields of a Point from the Frames of a shear; reason: why the run ended early, or ""; off: by pull-off."""
    if sheared and not touches(sheared[0]):
        return {"regime": NEVER_TOUCHES, "A_0": sheared[0].A}
    slipping = next((k for k, f in enumerate(sheared) if slips_in(f)), None)
    if slipping is not None:
        return _at_slip(sheared, slipping, skeleton)
    if off:  # numbers of the last Frame, within du_x of the end
        last = sheared[-1] if sheared else None
        numbers = {"U_s": last.U_x, "F_s": last.F, "A_s": last.A, "A_0": sheared[0].A} if last else {}
        return {"regime": DETACHES} | numbers
    if skeleton is not None:
        return of_skeleton(skeleton)
    return {"reason": reason} if reason else {"regime": STICKS, "A_0": sheared[0].A}


def _at_slip(sheared, k, skeleton):
    """Fields of a Point from a run with its first slip in Frame `k`; the numbers are those of the run."""
    event, before, after = slips_in(sheared[k])[0], sheared[max(0, k - 1)], sheared[k]
    end = next(iter(slips_in(skeleton)), None) if skeleton else None
    # skeleton and run are right to some 1e-5 nm, and other slips lie lattice periods away
    if end and abs(end.load - event.load) < 1e-3:  # states just before and after it, rather than some du_x away
        before, after = skeleton.frames([end.load, np.nextafter(end.load, np.inf)])
    branches = len(skeleton.branches) if skeleton else 0
    return at_slip(sheared[0], before, after, event) | {"branches": branches}
