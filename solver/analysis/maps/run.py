"""A Point from a run, which ends just beyond its first slip."""

from contextlib import suppress

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
    frames, skeleton, slips, spent, reason = [], None, 0, 0, ""
    smooth = False  # whether the run had no slip over one lattice period
    try:
        for frame, checkpoint in walk(scene):
            frames.append(frame)
            spent += frame.evaluations
            if spent > MOST:
                reason = f"no slip within {MOST} force evaluations; raise E, or lower u_x_max"
                break
            if frame.stage != "shear":
                continue
            slips += len(frame.slips)
            if (frame.index == 0 and not touches(frame)) or slips > LATER or (slips and frame.repeated):
                break
            if not slips and not smooth and frame.U_x >= scene.spacing:
                smooth, skeleton = True, _skeleton(scene, checkpoint)
                if skeleton is not None:
                    break
    except NotConverged as failure:
        reason = str(failure)
    sheared = [f for f in frames if f.stage == "shear"]
    if skeleton is None and sheared and touches(sheared[0]):
        skeleton = _skeleton(scene, checkpoint)
    if scene.path == "unload" and not reason:
        summary = summarize(scene, frames)
        numbers = {"regime": STICKS, "A_0": summary["A_0"], "L_min": summary["L_min"]}
    else:
        numbers = of_skeleton(skeleton) if skeleton is not None else _of_frames(sheared, reason)
    return Point(**numbers, evaluations=spent), skeleton


def _skeleton(scene, checkpoint):
    """The Skeleton of a run so far, or None."""
    with suppress(NotFollowed):
        return skeleton_from(scene, checkpoint)


def _of_frames(sheared, reason):
    """What a Point says of the Frames of a shear without a skeleton; reason: why the run ended early, or ""."""
    if sheared and not touches(sheared[0]):
        return {"regime": NEVER_TOUCHES, "A_0": sheared[0].A_bar}
    slipping = next((k for k, f in enumerate(sheared) if f.slips), None)
    if slipping is not None:
        after = sheared[slipping]
        return at_slip(sheared[0], sheared[max(0, slipping - 1)], after, after.slips[0])
    return {"reason": reason} if reason else {"regime": STICKS, "A_0": sheared[0].A_bar}
