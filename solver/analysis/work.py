"""The work of the stage, F dU_x + L d(delta), per unit of depth, in nN (1 GPa nm^2 = 1e-9 J/m).

Layer, interface and slips share it: tests/shared/energy.py has their balance. A slip does not dissipate all that it
releases, as the interface returns work that it took on the branch. Over a closed cycle, or a lattice period of steady
sliding, the layer's energy does not change, and the work is the cost of the cycle or of the slip.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..run.frame import Frame


def work_of(frames: Sequence[Frame]) -> NDArray[np.float64]:
    """Computes the work of the stage from the first frame on.

    Between frames F and L are linear, with a slip at its own load: up to F and L just before it, and after it along the
    slope of the next increment. The error falls as the square of the increment; at the end of a branch, where F turns
    as a square root, as the power 1.5.

    Parameters: frames: all of the run, in order.
    Returns the work, (frames,) nN.

    Example: `work_of(simulate(Scene()).frames)[-1]`
    """
    following = [*frames[2:], None]
    return np.cumsum([0.0] * bool(frames) + [_top(*each) for each in zip(frames, frames[1:], following, strict=False)])


def _top(before, frame, following):
    """Work of the stage between two frames, nN: F dU_x + L d(delta)."""
    if frame.stage.moves == "delta":
        return _integral(before, frame, following, "delta", "L")
    if frame.stage.kind == "move":
        return _integral(before, frame, following, "U_x", "F") + _integral(before, frame, following, "delta", "L")
    # a held load is the same before and after a slip, however delta changes
    return _integral(before, frame, following, "U_x", "F") + _trapezoid(before, frame, "delta", "L")


def _trapezoid(before, frame, along, force):
    return 0.5 * (getattr(before, force) + getattr(frame, force)) * (getattr(frame, along) - getattr(before, along))


def _integral(before, frame, following, along, force):
    """The integral of the force from one frame to the next, up to each slip and on from it."""
    load, f = getattr(before, along), getattr(before, force)
    end, last = getattr(frame, along), getattr(frame, force)
    if end == load or not frame.slips:
        return _trapezoid(before, frame, along, force)
    slope = 0.0
    if following is not None and not following.slips and getattr(following, along) != end:
        slope = (getattr(following, force) - last) / (getattr(following, along) - end)
    total = 0.0
    first, of = load, frame.stage.moves
    for slip in frame.slips:
        part = (slip.load - getattr(before, of)) / (getattr(frame, of) - getattr(before, of))
        at = first + part * (end - first)
        total += 0.5 * (f + getattr(slip, f"{force}_bar") * frame.unit) * (at - load)
        load, f = at, last - slope * (end - at)
    return total + 0.5 * (f + last) * (end - load)
