"""A Point from a run, which ends just beyond its first slip."""

from contextlib import suppress

import numpy as np

from ...continuation.state import NotConverged, Outcome
from ...following.from_run import skeleton_from
from ...following.moved import NotFollowed
from ...following.skeleton import Skeleton
from ...run.frame import slips_in
from ...run.loadpath import until
from ...run.summary import summarize
from ...scene import Scene
from .point import DETACHES, NEVER_TOUCHES, STICKS, Point, at_slip, of_skeleton, touches

EVALUATIONS = 300_000  # force evaluations, a hundred times those of the default: beyond, a point is given up


def computed(scene: Scene) -> tuple[Point, Skeleton | None]:
    """(Point, Skeleton or None) of a scene, from its start."""
    frames, skeleton, slips, spent, reason, off = [], None, 0, 0, "", False
    smooth = False  # whether the run had no slip over one lattice period
    try:
        for frame, checkpoint in until(scene):
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
        reason, off = str(failure), failure.outcome is Outcome.PULLED_OFF
    sheared = [f for f in frames if f.stage == "shear"]
    if skeleton is None and sheared and touches(sheared[0]):
        skeleton = _skeleton(scene, checkpoint)
    if scene.path == "unload" and not reason:
        summary = summarize(frames)
        numbers = {"regime": STICKS, "A_0": summary["A_0"], "L_min": summary["L_min"]}
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
