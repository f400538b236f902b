"""Where a run stands: an equilibrium, what the next increment may use of those before, and how one fails."""

from dataclasses import dataclass, field

import numpy as np

from .anderson import Secants


class NotConverged(RuntimeError):
    """An increment ended without an equilibrium; the message names the place, the residual and a remedy."""


class OutOfTime(NotConverged):
    """An increment took longer than it was given; a longer time may do."""


class PulledOff(NotConverged):
    """A load is held under which the contact came apart in a slip: the end of the run."""


@dataclass
class State:
    """An equilibrium, and what the next increment may use of those before it."""

    load: float  # nm
    v: np.ndarray  # (size,) unknowns
    active: np.ndarray  # nodes within the interaction window, held while an increment is solved
    past: list = field(default_factory=list)  # [(load, v)] on this branch, newest first, this one included
    secants: Secants | None = None
    sharp: tuple | None = None  # (v, active) whose tangent is inverted for solves, where these need it
    modes: object = None  # what `stability.Watch` knows of the modes that may grow
    unsure: bool = False  # whether it may be unstable, or no equilibrium, under the loading to come
    record: object = None  # what `replay.Replay` knows of the states before

    @staticmethod
    def at_rest(load, v, active):
        """The first state of a branch."""
        return State(load, v, active, [(load, v)])


@dataclass(frozen=True)
class LimitPoint:
    """The end of a branch: the load, the unknowns there, and the way in which the motion leaves."""

    load: float
    v: np.ndarray
    active: np.ndarray
    away: np.ndarray  # (size,) displacement from v at which the motion starts, at rest
    kind: str  # "fold": the load has a maximum; "flutter": an oscillation grows; "bifurcation": a mode grows at
    # another place than a fold; "lost": the branch could not be followed, the motion decides whether it ends here

    @property
    def located(self):
        """Whether the load is that of the end of the branch, and not merely of the increment in which it ended."""
        return self.kind != "lost"


@dataclass(frozen=True)
class Slip:
    """A branch that ended: where, in which way, and the unknowns there; after: the State landed in."""

    load: float
    v: np.ndarray
    active: np.ndarray
    kind: str
    located: bool
    after: State
    place: object = None  # the problem's own, which tells what v describes


@dataclass(frozen=True)
class Increment:
    """The outcome of one increment: the state reached, its residual (nm), slips on the way.

    The state is that at the load asked for, or at a higher one, if the surface came to rest there only.
    """

    state: State
    residual: float
    slips: tuple = ()
    repeated: bool = False  # a known state moved on by lattice periods, verified, not solved for
