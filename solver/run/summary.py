"""What is read from Frames: a run in a few numbers, and the surface away from the contact."""

import numpy as np

from ..mechanics.layer import Convolution, Modes
from .load_steps import load_steps_of


def whole_surface(scene, frame):
    """Displacement of every surface node of the layer, (2, nodes) nm, from the traction on the patch."""
    compliance = Convolution(Modes.of(scene).compliance, scene.nodes, scene.nodes)
    compliance.field[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    compliance.apply()
    return compliance.product + np.array([[frame.U_x], [-frame.delta]])


def summarize(scene, frames):
    """A run in a few numbers: A_0 and slips after the approach; U_s (nm), F_s and A_s at the first slip in shear.

    Each is None where there is none. L_min, the least load during retraction, is there in a run with unloading only.
    """
    after = [f for f in frames if f.stage != "approach"]
    first = next((event for f in after if f.stage == "shear" for event in f.slips), None)
    last = load_steps_of(scene)[-1]
    ended = bool(after) and after[-1].stage == last.stage and after[-1].index >= last.increments
    pull_off = [f.L_bar for f in after if f.stage == "unload"]
    return {
        "converged": ended and all(f.residual <= scene.tolerance for f in frames),
        "evaluations": sum(f.evaluations for f in frames),
        "A_0": after[0].A_bar if after else None,
        "slips": sum(len(f.slips) for f in after),
        "events": [event.as_dict() for f in frames for event in f.slips],
        "U_s": first.load if first else None,
        "F_s": first.F_bar if first else None,
        "A_s": first.A_bar if first else None,
    } | ({"L_min": min(pull_off)} if pull_off else {})
