"""What is read from Frames: a run in a few numbers, and the surface away from the contact."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mechanics.layer import Convolution, Modes
from ..scene import PARAMETERS, Scene
from .frame import Frame, load_of
from .load_steps import load_steps_of


def whole_surface(scene: Scene, frame: Frame) -> NDArray[np.float64]:
    """Displacement of every surface node of the layer, (2, nodes) nm, from the traction on the patch."""
    layer = Convolution(Modes.of(scene), scene.nodes)
    layer.field[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    layer.apply()
    return layer.product + np.array([[frame.U_x], [-frame.delta]])


def changing(frames):
    """Names of the parameters that are not the same in all Frames: in those of a run that was carried on, a few."""
    scenes = list({id(frame.scene): frame.scene for frame in frames}.values())
    return tuple(name for name in PARAMETERS if any(getattr(s, name) != getattr(scenes[0], name) for s in scenes))


def summarize(scene: Scene, frames: Sequence[Frame]) -> dict[str, Any]:
    """A run in a few numbers: A_0 and slips after the approach; U_s (nm), F_s and A_s at the first slip in shear.

    Each is None where there is none. A jump where a held load takes over ("control") counts among the slips, but is not
    the first one. L_min, the least load during retraction, is there in a run with unloading only. Forces are over w E
    of their own increment. scene: that of the end of the run. Of one that was carried on, `events` name what changes
    along it, `E_s` is the E of F_s, and `changes` says from which increment of all on it has what.
    """
    names = changing(frames)
    after = [f for f in frames if f.stage != "approach"]
    sheared = ((f, event) for f in after if f.stage == "shear" for event in f.slips if event.kind != "control")
    found, event = next(sheared, (None, None))
    told = {
        "converged": _converged(scene, frames),
        "evaluations": sum(f.evaluations for f in frames),
        "events": [one.as_dict() | _values(f, names) for f in frames for one in f.slips],
        "safe_damping": max((f.safe_damping for f in frames), default=0.0),
        "may_flutter": sum(f.may_flutter for f in frames),
        "A_0": after[0].A_bar if after else None,
        "slips": sum(len(f.slips) for f in after),
        "U_s": event and event.load,
        "F_s": event and event.F_bar,
        "A_s": event and event.A_bar,
    }
    if pull_off := [f.L_bar for f in after if f.stage == "unload"]:
        told["L_min"] = min(pull_off)
    if names:
        told |= {"E_s": found and found.scene.E, "changes": _changes(frames, names)}
    return told


def _converged(scene, frames):
    """Whether the Frames lead to the end of the path, each to its tolerance."""
    last = load_steps_of(scene)[-1]
    if not frames or frames[-1].stage != last.stage:
        return False
    ended = load_of(frames[-1], last.stage) >= last.at(last.increments) - 1e-9 * last.increment
    return ended and all(f.residual <= f.scene.tolerance for f in frames)


def _values(frame, names):
    return {name: getattr(frame.scene, name) for name in names}


def _changes(frames, names):
    """[{increment, stage, U_x and the parameters of these names}] of each Frame from which on these are others."""
    begun = [k for k, f in enumerate(frames) if k == 0 or f.scene != frames[k - 1].scene]
    return [{"increment": k, "stage": frames[k].stage, "U_x": frames[k].U_x} | _values(frames[k], names) for k in begun]
