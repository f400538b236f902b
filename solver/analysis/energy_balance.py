"""The work of the stage, and what it becomes: elastic energy, work on the interface, energy released in slips.

Energies are per unit of depth, in nN (1 GPa nm^2 = 1e-9 J/m). The stage does the work dW = F dU_x + L d(delta). Layer
and drive store the elastic energy E = 1/2 sum T.(u - U) a. In equilibrium dE = dW + dS, where dS = sum T.du a is the
work of the tractions on the surface; the interface takes -S. In a slip the stage rests, or moves under a constant load,
and E falls by the energy R that is released. So W = E - S + R. This defines R in an increment with a slip. In all
others it is a check: F and L, and the layer's reciprocity, must agree with T and u.

A slip does not dissipate all that it releases, as the interface returns work that it took on the branch. Over a closed
cycle, or a lattice period of steady sliding, E does not change: W = R - S is the cost of the cycle or of the slip. NP1
has no potential, so that its tractions may do work along that closed path: the flow of a slip then dissipates more than
the stage's work (tests/solver/test_energy_balance.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..run.frame import Frame


@dataclass(frozen=True)
class Work:
    """Sums from the first frame on, each (frames,), nN: W, E less that of the first frame, S on branches, R in slips.

    Between frames F, L and T are linear, with a slip at its own load: up to F and L just before it, and after it along
    the slope of the next increment. The error of W falls as the square of the increment. At the end of a branch F
    turns as a square root, and the error falls as the power 1.5. R is of a whole increment with a slip, and so depends
    on the increment; R - S does not.

    Example: `work_of(simulate(Scene()).frames).defect`
    """

    top: NDArray[np.float64]
    stored: NDArray[np.float64]
    surface: NDArray[np.float64]
    released: NDArray[np.float64]

    @property
    def defect(self) -> NDArray[np.float64]:
        """W - (E - S + R), nN, (frames,): zero to the residual for increments of any size, as C is symmetric."""
        return self.top - self.stored + self.surface - self.released


def work_of(frames: Sequence[Frame]) -> Work:
    """Computes the energy balance of a run.

    Parameters: frames: all of the run, in order, with their fields.
    Returns the Work.

    Example: `work_of(simulate(Scene()).frames).defect`
    """
    top = np.zeros(len(frames))
    surface, released = np.zeros_like(top), np.zeros_like(top)
    energy = np.array([layer_energy(frame) for frame in frames])
    for k in range(1, len(frames)):
        before, frame = frames[k - 1], frames[k]
        following = frames[k + 1] if k + 1 < len(frames) else None
        top[k] = _top(before, frame, following)
        if frame.slips:
            released[k] = top[k] - (energy[k] - energy[k - 1])
        else:
            surface[k] = _surface(before, frame)
    return Work(np.cumsum(top), energy - energy[:1], np.cumsum(surface), np.cumsum(released))


def layer_energy(frame) -> float:
    """1/2 sum T.(u - U) a, nN: the elastic energy of layer and drive."""
    top = np.array([[frame.U_x], [-frame.delta]])
    return 0.5 * float(np.sum(frame.T * (frame.u - top))) * frame.scene.spacing


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


def _surface(before, frame):
    """Work of the tractions on the surface between two frames, nN."""
    return 0.5 * float(np.sum((before.T + frame.T) * (frame.u - before.u))) * frame.scene.spacing
