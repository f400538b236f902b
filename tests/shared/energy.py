"""The energy balance of a run, nN: what the stage does, the layer stores, the interface takes and slips release."""

from typing import NamedTuple

import numpy as np

from solver import work_of


class Balance(NamedTuple):
    """Sums from the first frame on, each (frames,): W, E less that of the first frame, S on branches, R in slips.

    In equilibrium dE = dW + dS, where dS = sum T.du a is the work of the tractions on the surface. In a slip the stage
    rests, or moves under a constant load, and E falls by R: W = E - S + R. R is of a whole increment with a slip, and
    so depends on the increment; R - S does not.
    """

    top: np.ndarray
    stored: np.ndarray
    surface: np.ndarray
    released: np.ndarray

    @property
    def defect(self):
        """W - (E - S + R), (frames,): zero to the residual for increments of any size, as C is symmetric."""
        return self.top - self.stored + self.surface - self.released


def balance_of(frames):
    """The Balance of a whole run."""
    top, energy = work_of(frames), np.array([layer_energy(frame) for frame in frames])
    surface, released = np.zeros_like(top), np.zeros_like(top)
    for k in range(1, len(frames)):
        before, frame = frames[k - 1], frames[k]
        if frame.slips:
            released[k] = top[k] - top[k - 1] - (energy[k] - energy[k - 1])
        else:
            surface[k] = 0.5 * float(np.sum((before.T + frame.T) * (frame.u - before.u))) * frame.scene.spacing
    return Balance(top, energy - energy[:1], np.cumsum(surface), np.cumsum(released))


def layer_energy(frame):
    """1/2 sum T.(u - U) a, nN: the elastic energy of layer and drive."""
    top = np.array([[frame.U_x], [-frame.delta]])
    return 0.5 * float(np.sum(frame.T * (frame.u - top))) * frame.scene.spacing
