"""Where a run stands: the state an increment starts from, the load it moves along, and why an increment can fail."""

from dataclasses import dataclass, field

import numpy as np

from .secants import Secants


class NotConverged(RuntimeError):
    """An increment ended without an equilibrium; the message names the place, the residual and a remedy."""


class PulledOff(NotConverged):
    """A load is held under which the contact has come apart: the end of the run, as there is no equilibrium left."""


@dataclass(frozen=True)
class Loading:
    """A straight path of the rigid top: (U_x, U_z) = base + load * direction, nm; the load only ever increases."""

    name: str  # of the load parameter, for messages: "delta" or "U_x", with a minus where that falls
    base: tuple
    direction: tuple
    upright: bool = False  # whether U_x = 0 from the start of the run on, so that a mirrored state stays mirrored

    def at(self, load):
        """(U_x, U_z) at that load, nm."""
        return self.base[0] + load * self.direction[0], self.base[1] + load * self.direction[1]

    def coordinate(self, load):
        """U_x or delta, whichever changes along the path, at that load, nm."""
        U_x, U_z = self.at(load)
        return U_x if self.direction[0] else -U_z


def approach(scene):
    """Lowering the top: the load is delta."""
    return Loading("delta", (0.0, 0.0), (0.0, -1.0), True)


def shear(scene):
    """Pulling the top sideways at the scene's indentation: the load is U_x."""
    return Loading("U_x", (0.0, -scene.delta), (1.0, 0.0))


@dataclass(frozen=True)
class Slip:
    """An instability: a branch that ended, and where."""

    load: float  # nm: U_x or delta at which the branch ended
    before: np.ndarray  # (2, m) displacement there, nm
    traction: np.ndarray  # (2, m) traction there, GPa


@dataclass
class State:
    """An equilibrium, and what the next increment may use of those before it."""

    load: float  # nm
    u: np.ndarray  # (2, m) displacement, nm
    active: np.ndarray  # (m,) nodes within the interaction window
    past: list = field(default_factory=list)  # [(load, u)] on this branch, newest first, this one included
    secants: Secants | None = None
    record: object = None  # the Record of this branch, if sliding may repeat it
    sites: int = 0  # by which the state has moved on from the record; counts once that is closed
    doubtful: bool = False  # whether it may be unstable, or no equilibrium, under the loading to come


@dataclass(frozen=True)
class Increment:
    """The outcome of one increment: the state reached, traction (2, m) in GPa, residual in nm, slips on the way."""

    state: State
    traction: np.ndarray
    residual: float
    slips: tuple = ()
    repeated: bool = False  # a recorded state moved on, not solved for
