"""The state of a run: an equilibrium with what the next increment may use; slips; and how increments fail."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from .anderson import Secants

ROUND_OFF = 1e-9  # relative difference that round-off may make, of eigenvalues and of loads
UNSTABLE = 1e-6  # growth, 1/time, above which an equilibrium is unstable: round-off of flats makes 1e-8
TINY = 1e-300  # nonzero, in place of a zero in a denominator
# states of a branch by whose polynomial it is extrapolated in the load; with 4 a run takes 2 % more evaluations, and
# has the same slips
PAST = 6
SHARP = 1e-9  # units; accuracy of the load at the end of a branch
MOVED = 0.5  # units of the problem; a state that moved farther in an increment may lie on another branch


class Outcome(StrEnum):
    """How a run ends; each has a sentence in `SENTENCES`."""

    FINISHED = "finished"
    PULLED_OFF = "pulled off"
    RESTLESS = "restless"
    OUT_OF_TIME = "out of time"
    OUT_OF_MEMORY = "out of memory"
    LOST = "lost"
    INTERRUPTED = "interrupted"

    @property
    def reached(self) -> bool:
        """Whether all that the path has of equilibria was computed."""
        return self in (Outcome.FINISHED, Outcome.PULLED_OFF)


SENTENCES = {
    Outcome.FINISHED: "The run reached the end of its path.",
    Outcome.PULLED_OFF: "The contact pulled off under its held load: there is no equilibrium beyond.",
    Outcome.RESTLESS: "A motion did not come to rest.",
    Outcome.OUT_OF_TIME: "An increment took longer than its limit of time.",
    Outcome.OUT_OF_MEMORY: "The increments of the run take more memory than there is.",
    Outcome.LOST: "No equilibrium was found within the tolerance.",
    Outcome.INTERRUPTED: "The run was interrupted from outside.",
}


class NotConverged(RuntimeError):
    """An increment ended without an equilibrium; the message gives the load, the residual and a remedy.

    outcome: the Outcome of the run that ends so.
    """

    outcome = Outcome.LOST

    def __init__(self, message: str = "", outcome: Outcome | None = None) -> None:
        super().__init__(message)
        self.outcome = outcome or self.outcome


class Restless(NotConverged):
    """A transient does not come to rest; smaller increments would not change that."""

    outcome = Outcome.RESTLESS


class OutOfTime(NotConverged):
    """An increment took longer than its limit of time."""

    outcome = Outcome.OUT_OF_TIME


class PulledOff(NotConverged):
    """Under a held load the contact came apart in a slip: the end of the run."""

    outcome = Outcome.PULLED_OFF


class Point(NamedTuple):
    """A point of a branch: a load and the unknowns under it."""

    load: float  # nm
    v: np.ndarray  # (size,)


@dataclass(frozen=True)
class Mode:
    """The disturbance x of an equilibrium that grows fastest; the next search starts from it."""

    growth: float  # 1/time
    mu: complex  # GPa/nm
    x: np.ndarray | None  # (size,) unknowns, of any length
    basis: tuple = ()  # pairs (x (N,), K x (N,) GPa), of unit length, with mu near zero
    v: np.ndarray | None = None  # (size,) the state that was searched
    margin: float = 0.0  # distance from a fold, in stiffness: one minus the largest eigenvalue of K^-1 J in the basis

    def __getstate__(self) -> dict[str, Any]:
        """Pickled, the basis has single precision: a search only starts from it."""
        return vars(self) | {"basis": tuple((x.astype("f4"), layered.astype("f4")) for x, layered in self.basis)}

    @property
    def rests(self) -> bool:
        """Whether the equilibrium is stable, to UNSTABLE."""
        return self.growth <= UNSTABLE

    @property
    def kind(self) -> str:
        """The kind of end at its onset, as of `state.End`, unless that is a fold."""
        return "flutter" if abs(self.mu.imag) > ROUND_OFF * abs(self.mu) else "bifurcation"


class State(NamedTuple):
    """An equilibrium, with what the next increment may use of the states before it."""

    load: float  # nm
    v: np.ndarray  # (size,) unknowns
    past: list  # [(load (nm), v (size,))], PAST at most, on this branch, newest first, this one included
    secants: Secants | None = None
    # (size,) unknowns at which the preconditioner of the corrector is formed; None: Anderson steps need none
    sharp: np.ndarray | None = None
    mode: Mode | None = None  # the one that grows fastest, as judged last
    # True after the load control changed: the next increment checks its stability first, and lets it relax
    unsure: bool = False
    residual: float = np.inf  # nm
    undecided: bool = False  # whether a slip before was `sensitive`, so that the run may stand elsewhere

    @staticmethod
    def at_rest(load, v, **more) -> "State":
        """The first state of a branch."""
        return State(load, v, [(load, v)], **more)


def slipped(problem, before, load, after) -> bool:
    """Whether a State `after` lies farther from the one `before` than a branch leads up to that load, nm."""
    moved = np.abs(after.v - before.v).max()
    # on a branch, nodes in contact move about as far as the load
    return bool(moved >= MOVED * problem.unit + 2.0 * abs(load - before.load))


class End(NamedTuple):
    """The end of a branch: its load and unknowns, the way the transient leaves it and, of a slip, where that rests.

    kind: "fold", where the load has a maximum; "flutter", where an oscillation starts to grow; "bifurcation", where a
    real mode does, but not at a fold; "control", where another load takes over under which the state is unstable;
    "lost", where the branch could not be continued: the transient decides if it ends. sensitive: motions
    with other time steps, or from another start, came to rest elsewhere, or the surface may leave a symmetric state
    either way.
    """

    load: float  # nm
    v: np.ndarray  # (size,)
    # (size,), largest component 1 or -1: the way the surface leaves, at a fold the null vector of dR/dv; 0 where the
    # branch was lost; None: not known
    phi: np.ndarray | None = None
    kind: str = "fold"
    after: State | None = None  # at rest again; None in a Trace where it is the first state of the next branch
    sensitive: bool = False
    psi: np.ndarray | None = None  # (size,) of a fold, the left null vector, <R_s, psi> = 1; None: not known
    residual: float = np.inf  # nm, of v
    growth: float = np.inf  # 1/time, of an unstable state that the surface leaves ("control"); of other ends inf

    def shifted(self, distance, direction) -> "End":
        """The same, moved on by a whole number of sites, nm; direction: the problem's."""
        return self._replace(load=self.load + distance, v=self.v + distance * direction)

    @property
    def located(self) -> bool:
        """True if `load` is the load of the end; False if the branch was lost somewhere in that increment."""
        return self.kind != "lost"


class Increment(NamedTuple):
    """The outcome of one increment: the state reached, and slips on the way.

    The state's load is the one asked for, or a higher one if after a slip the surface did not rest before.
    """

    state: State
    slips: tuple[End, ...] = ()
    repeated: bool = False  # known from earlier, moved on by lattice periods and verified
