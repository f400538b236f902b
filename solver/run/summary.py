"""What Frames show: a run in a few numbers, and the surface away from the contact."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mechanics.layer import Convolution, Modes
from ..scene import Scene
from .frame import Frame, kind, largest_safe_damping, slides_in
from .load_steps import ROUND_OFF, load_steps_of


def whole_surface(scene: Scene, frame: Frame) -> NDArray[np.float64]:
    """Computes the displacement of the whole surface from the traction on the patch.

    Parameters: scene: that of the frame; frame: with its fields.
    Returns u (2, nodes), nm.

    Example: `whole_surface(Scene(), simulate(Scene()).frames[-1])`
    """
    layer = Convolution(Modes.of(scene), scene.nodes)
    layer.field[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    layer.apply()
    return layer.product + np.array([[frame.U_x], [-frame.delta]])


def fields_of(scene: Scene, frames: Sequence[Frame]) -> dict[str, NDArray[np.float64]]:
    """x (m,) nm, u (nm) and T (GPa) (frames, 2, m). At nodes outside a frame's patch u is nan and T is 0."""
    first = min((frame.first for frame in frames), default=0)
    last = max((frame.first + frame.u.shape[1] for frame in frames), default=0)
    u = np.full((len(frames), 2, last - first), np.nan)
    T = np.zeros_like(u)
    for k, frame in enumerate(frames):
        patch = slice(frame.first - first, frame.first - first + frame.u.shape[1])
        u[k, :, patch], T[k, :, patch] = frame.u, frame.T
    return {"x": np.arange(first, last) * scene.spacing, "u": u, "T": T}


def summarize(scene: Scene, frames: Sequence[Frame]) -> dict[str, Any]:
    """Describes a run in a few numbers, as `run --json` writes them.

    Parameters: scene: that of the end of the run; frames: all of them, in order.
    Returns a dict: A_0 and the number of slips after the approach, U_s (nm), F_s and A_s at the first slip of a stage
    that moves U_x, None where it does not exist. Forces are over w E.

    Example: `summarize(Scene(), simulate(Scene()).frames)["U_s"]`

    A jump where a held load takes over ("control") counts among the slips, but is not the first one. L_min, the least
    load of a retraction, exists only with a stage 'unload'.
    """
    events = [event.as_dict() for f in frames for event in f.slips]
    sliding = (event.as_dict() for f in frames for event in slides_in(f))
    first: dict[str, Any] = next(sliding, {})
    after = [f for f in frames if f.stage != "approach"]
    summary = {
        "converged": _converged(scene, frames),
        "evaluations": sum(f.evaluations for f in frames),
        "events": events,
        "safe_damping": (safe := largest_safe_damping(frames)),
        "may_flutter": sum(f.may_flutter for f in frames) if safe > scene.damping else 0,
        "sensitive": sum(f.sensitive for f in frames),
        "A_0": after[0].A_bar if after else None,
        "slips": sum(len(f.slips) for f in after),
        "U_s": first.get("U_x"),
        "F_s": first.get("F_bar"),
        "A_s": first.get("A_bar"),
    }
    if retraction := [f.L_bar for f in after if kind(f.stage) == "unload"]:
        summary["L_min"] = min(retraction)
    return summary


def _converged(scene, frames):
    """Whether the Frames reach the end of the path, each within its tolerance."""
    last = load_steps_of(scene)[-1]
    if not frames or frames[-1].stage != last.stage:
        return False
    ended = last.loading.load_of(frames[-1]) >= last.at(last.increments) - ROUND_OFF * last.increment
    return ended and all(f.residual <= scene.tolerance for f in frames)


def left_out(frames: Sequence[Frame]) -> dict[str, int]:
    """What a run did not compute: nodes of the cell that its last frame leaves out, and increments that it repeated."""
    if not frames:
        return {"nodes": 0, "increments": 0}
    last = frames[-1]
    kept = 1 if last.u.strides[1] == 0 else last.u.shape[1]  # one node may stand for all: see `frame.on_nodes`
    return {"nodes": last.scene.nodes - kept, "increments": sum(frame.repeated for frame in frames)}
