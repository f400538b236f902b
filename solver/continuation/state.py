"""Where a run stands: an equilibrium with what the next increment may use; slips; and how increments fail."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .anderson import Secants
from .rest import Mode

if TYPE_CHECKING:
    from .trace import Trace

MOVED = 0.5  # units of the problem, farther than which a state may be on another branch


class NotConverged(RuntimeError):
    """An increment ended without an equilibrium; the message names the place, the residual and a remedy."""


class Restless(NotConverged):
    """A motion does not come to rest; smaller increments would not change that."""


class OutOfTime(NotConverged):
    """An increment took longer than it was given; a longer time may do."""


class Crowded(NotConverged):
    """A motion needs more unknowns than the problem has; it is repeated with these."""


class PulledOff(NotConverged):
    """Under a held load the contact came apart in a slip: the end of the run."""


@dataclass
class State:
    """An equilibrium, and what the next increment may use of those before it."""

    load: float  # nm
    v: np.ndarray  # (size,) unknowns
    active: np.ndarray  # nodes within the interaction window; fixed during a solve
    past: list = field(default_factory=list)  # [(load, v)] on this branch, newest first, this one included
    secants: Secants | None = None
    sharp: tuple | None = None  # (v, active) whose inverse tangent solves use, where Anderson steps alone failed
    mode: Mode | None = None  # the one that grows fastest, as judged last
    unsure: bool = False  # it may be unstable, or no equilibrium at all, under the loading to come
    trace: "Trace | None" = None  # what the run has passed in this load step, where a `replay.Replay` keeps it
    residual: float = np.inf  # nm, where it was solved for

    @staticmethod
    def at_rest(load, v, active, **known):
        """A state with none before it on its branch."""
        return State(load, v, active, [(load, v)], **known)

    @staticmethod
    def undeformed(problem, load):
        """The state of a problem in which nothing acts on the unknowns but the load."""
        v = problem.undeformed(load)
        return State.at_rest(load, v, problem.active(v, load))


def slipped(problem, before, load, after):
    """Whether a State `after` lies farther from that `before` than a branch leads up to that load, nm."""
    moved = np.abs(after.v - before.v).max()
    return bool(moved >= MOVED * problem.unit + 2.0 * abs(load - before.load))


@dataclass(frozen=True)
class LimitPoint:
    """The end of a branch: the load, the unknowns there, and where the motion starts.

    kind: "fold", where the load has a maximum; "flutter", where an oscillation starts to grow; "bifurcation", where a
    real mode does, but not at a fold; "control", where another load takes over under which the state is unstable;
    "lost", where the branch could not be followed: the motion decides if it ends. hidden: as of `rest.Mode`.
    """

    load: float  # nm
    v: np.ndarray  # (size,)
    active: np.ndarray
    away: np.ndarray  # (size,): the motion starts from rest at v + away
    kind: str
    hidden: bool = False

    @property
    def located(self):
        """Whether `load` is that of the end itself, not of the increment in which the branch was lost."""
        return self.kind != "lost"


@dataclass(frozen=True)
class Slip:
    """A branch that ended, as a LimitPoint says, and the State in which the surface came to rest again.

    sensitive: as of `slip.Landing`.
    """

    load: float  # nm
    v: np.ndarray  # (size,)
    active: np.ndarray
    kind: str
    located: bool
    after: State | None  # None in a Trace, which has it as the first of the next branch
    sensitive: bool = False


@dataclass(frozen=True)
class Increment:
    """The outcome of one increment: the state reached, and slips on the way.

    The state's load is the one asked for, or a higher one if after a slip the surface did not rest before.
    """

    state: State
    slips: tuple = ()
    repeated: bool = False  # known from earlier, moved on by lattice periods and verified

    @property
    def residual(self):
        """The state's, nm."""
        return self.state.residual
