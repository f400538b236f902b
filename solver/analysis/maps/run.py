"""A Point from a run, which ends just beyond its first slip."""

from contextlib import suppress
from dataclasses import replace

from ...continuation.state import NotConverged
from ...following.branch import NotFollowed
from ...following.from_run import skeleton_from
from ...run.loadpath import walk
from ...run.summary import summarize
from .point import NEVER_TOUCHES, STICKS, Point, at_slip, of_skeleton, touches

LATER = 2  # slips after the first, while the run does not repeat itself: of sliding runs, 3 in 4 repeat after one, and
# nearly all others after two or three
MOST = 300_000  # force evaluations, a hundred times those of the default: beyond, a point is given up


def computed(scene):
    """(Point, Skeleton or None) of a scene, from its start."""
    run = _Run(scene)
    reason = ""
    try:
        for frame, run.checkpoint in walk(scene):
            run.frames.append(frame)
            run.spent += frame.evaluations
            if run.told(frame):
                break
    except NotConverged as failure:
        reason = str(failure)
    return replace(run.point(reason), evaluations=run.spent), run.skeleton


class _Run:
    """The frames of a run so far."""

    def __init__(self, scene):
        self.scene, self.frames, self.spent, self.slips, self.skeleton = scene, [], 0, 0, None
        self.checkpoint = None  # after the last of them
        self._looked = False  # whether the run slides smoothly

    def told(self, frame):
        """Whether all is known that a Point says; `frame` is the last one."""
        if self.spent > MOST:
            return True
        if frame.stage != "shear":
            return False
        self.slips += len(frame.slips)
        if frame.index == 0 and not touches(frame):
            return True
        if not self.slips and not self._looked and frame.U_x >= self.scene.spacing:
            self._looked = True
            self.read()
            return self.skeleton is not None
        return self.slips > LATER or bool(self.slips and frame.repeated)

    def read(self):
        """Sets the skeleton, if there is one so far."""
        with suppress(NotFollowed):
            self.skeleton = skeleton_from(self.scene, self.checkpoint)

    def point(self, reason):
        """The Point, but for what it cost."""
        sheared = [f for f in self.frames if f.stage == "shear"]
        slipping = next((k for k, f in enumerate(sheared) if f.slips), None)
        if self.scene.path == "unload" and not reason:
            summary = summarize(self.scene, self.frames)
            return Point(regime=STICKS, A_0=summary["A_0"], L_min=summary["L_min"])
        if sheared and not touches(sheared[0]):
            return Point(regime=NEVER_TOUCHES, A_0=sheared[0].A_bar)
        if self.skeleton is None and sheared:
            self.read()
        if self.skeleton is not None:
            return Point(**of_skeleton(self.skeleton))
        if slipping is not None:
            after = sheared[slipping]
            return Point(**at_slip(sheared[0], sheared[max(0, slipping - 1)], after, after.slips[0]))
        if self.spent > MOST:
            reason = f"no slip within {MOST} force evaluations; raise E, or lower u_x_max"
        return Point(reason=reason) if reason else Point(regime=STICKS, A_0=sheared[0].A_bar)
