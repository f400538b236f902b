"""A held load given in N/m: the indentation at which the approach reaches it."""

from dataclasses import replace

from scipy.optimize import brentq

from ..scene import LIMITS, Scene, SceneError
from ..schema import as_number
from .loadpath import load_path


def held_at(scene: Scene, load: float) -> Scene:
    """The Scene that holds a normal load (N/m) during the shear: hold 'load', at the indentation that reaches it.

    The load falls below zero as the surfaces attract each other, and rises as they are pressed together. The
    indentation is that of the first rise to `load`. Raises SceneError where the approach does not reach it.
    """
    wanted = as_number(load)
    if not abs(wanted) < float("inf"):
        raise SceneError("load", load, "allowed: a finite number of N/m, negative for a pull", "give such a number")
    most = min(LIMITS["delta_bar"].high, 0.999 * scene.height * scene.width / scene.delta_0)
    # `hold` and drive_n are checked by the last line
    approach, before, least, frame = replace(scene, path="shear", hold="delta", u_x_max=0.0), None, 0.0, None
    for frame in load_path(approach.changed(delta_bar=most)):
        if before is not None and before.L < wanted <= frame.L:
            break
        before, least = frame, min(least, frame.L)
    else:
        allowed = f"allowed: {least:.4g} .. {before.L:.4g} N/m, what the approach reaches" if before else "no approach"
        raise SceneError("load", load, allowed, "give a load in that range, or a thicker layer")
    ends = before.delta / scene.delta_0, frame.delta / scene.delta_0

    def off(delta_bar):
        *_, last = (each for each in load_path(approach.changed(delta_bar=delta_bar)) if each.stage == "approach")
        return last.L - wanted

    # over 1e-9 of delta_0 the load changes by some 1e-7 N/m, unless it jumps over the one asked for
    delta_bar = brentq(off, *ends, xtol=1e-9)
    if abs(off(delta_bar)) > 1e-6 * max(1.0, abs(wanted)):
        jump = f"the approach jumps from {before.L:.4g} to {frame.L:.4g} N/m at delta_bar = {delta_bar:.4g}"
        raise SceneError("load", load, jump, "give a load outside that jump")
    return scene.changed(delta_bar=delta_bar, hold="load")
