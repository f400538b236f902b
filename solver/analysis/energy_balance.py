"""Where the work goes that the top puts in: what the layer stores, what the interface takes, what a slip releases.

Energies per unit of depth, in nN (1 GPa nm^2 = 1e-9 J/m). The top puts in dW = F dU_x + L d(delta). The layer stores
the elastic energy E = 1/2 sum T.(u - U) a. At rest, dE = dW + dS exactly, with dS = sum T.du a the signed work of the
tractions on the surface: what the interface takes is -S. In a slip the top rests, or moves under a constant load, and E
falls by what is released, R. So W = E - S + R: by definition of R in an increment with a slip, and as a check in all
others, where F and L, and the layer's reciprocity, must agree with T and u.

What a slip releases is not what it dissipates, as the interface gives back what it took on the branch. Over a closed
cycle, or a lattice period of steady sliding, E is what it was, and W = R - S is what the cycle, or the slip, has cost.
NP1 has no energy, so that its tractions may do work of their own along that closed path: with the defaults, the flow of
a slip dissipates 2% more than the top pays for (tests/test_energy_balance.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..run.frame import STAGES, Frame
from ..run.summary import whole_surface
from ..scene import Scene


@dataclass(frozen=True)
class Work:
    """Sums from the first frame on, each (frames,), nN: W, E less that of the first frame, S on branches, R in slips.

    Between frames F, L and T are taken as linear, with a slip at its own load: before it, up to F and L just before;
    after it, along the slope of the increment that follows. The error of W falls as the square of the increment, and
    at the end of a branch, where F turns as a square root, as its power 1.5. R counts an increment with a slip as a
    whole, so that it depends on the increment by a share of the branch; R - S does not.
    """

    top: NDArray[np.float64]
    stored: NDArray[np.float64]
    surface: NDArray[np.float64]
    released: NDArray[np.float64]

    @property
    def defect(self) -> NDArray[np.float64]:
        """W - (E - S + R), nN, (frames,): zero to the residual, whatever the increment, as C is symmetric."""
        return self.top - self.stored + self.surface - self.released


def work_of(scene: Scene, frames: Sequence[Frame]) -> Work:
    """The Work of a run's Frames in order, with their fields; of a run carried on, `top` alone is a balance."""
    top = np.zeros(len(frames))
    surface, released = np.zeros_like(top), np.zeros_like(top)
    energy = np.array([layer_energy(scene, frame) for frame in frames])
    for k in range(1, len(frames)):
        here, there = frames[k - 1], frames[k]
        after = frames[k + 1] if k + 1 < len(frames) else None
        top[k] = _top(here, there, after)
        if there.slips:
            released[k] = top[k] - (energy[k] - energy[k - 1])
        else:
            surface[k] = _surface(scene, here, there)
    return Work(np.cumsum(top), energy - energy[:1], np.cumsum(surface), np.cumsum(released))


def layer_energy(scene, frame) -> float:
    """1/2 sum T.(u - U) a, nN: the elastic energy of the layer."""
    top = np.array([[frame.U_x], [-frame.delta]])
    return 0.5 * float(np.sum(frame.T * (frame.u - top))) * scene.spacing


def _top(here, there, after):
    """Work of the top between two frames, nN: F dU_x + L d(delta)."""
    if STAGES[there.stage][0] == "delta":
        return _integral(here, there, after, "delta", "L")
    # a load that is held is the same before and after a slip, whatever delta does meanwhile
    return _integral(here, there, after, "U_x", "F") + _trapezoid(here, there, "delta", "L")


def _trapezoid(here, there, along, force):
    return 0.5 * (getattr(here, force) + getattr(there, force)) * (getattr(there, along) - getattr(here, along))


def _integral(here, there, after, along, force):
    """The force over the way from one frame to the next, up to every slip and on from it."""
    at, f = getattr(here, along), getattr(here, force)
    end, last = getattr(there, along), getattr(there, force)
    if end == at or not there.slips:
        return _trapezoid(here, there, along, force)
    slope = 0.0
    if after is not None and not after.slips and getattr(after, along) != end:
        slope = (getattr(after, force) - last) / (getattr(after, along) - end)
    total = 0.0
    for slip in there.slips:
        before = getattr(slip, f"{force}_bar") * there.unit
        total += 0.5 * (f + before) * (slip.load - at)
        at, f = slip.load, last - slope * (end - slip.load)
    return total + 0.5 * (f + last) * (end - at)


def _surface(scene, here, there):
    """Work of the tractions on the surface between two frames, nN."""
    if (here.first, here.u.shape) != (there.first, there.u.shape):
        here, there = _whole(scene, here), _whole(scene, there)
    else:
        here, there = (here.u, here.T), (there.u, there.T)
    return 0.5 * float(np.sum((here[1] + there[1]) * (there[0] - here[0]))) * scene.spacing


def _whole(scene, frame):
    """(u, T) of every node of the cell, (2, nodes) each."""
    T = np.zeros((2, scene.nodes))
    T[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    return whole_surface(scene, frame), T
