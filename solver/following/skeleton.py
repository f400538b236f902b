"""A run that slides, known by its branches until they repeat: it gives the run at any load."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..continuation.state import State
from ..continuation.trace import Branch, Trace
from ..mechanics.cohesive_law import traction
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.frame import Frame, SlipEvent, contact_area, forces, forces_and_area, frame_of
from ..run.load_steps import sideways
from ..scene import Scene

FIT = 8192  # nodes whose tractions are computed at once: the law's scratch then fits into a fast cache


@dataclass(frozen=True, eq=False)
class Held:
    """The equilibrium at the end of the approach: it carries the load that is held in shear.

    kind: that of the slip at U_x = 0 where it is unstable under that load; empty where it is stable; None if unknown.
    """

    v: NDArray[np.float64] = field(repr=False)  # (2 m,) at given indentation
    kind: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Skeleton:
    """The Trace of a whole shear, and its scene.

    Without a period, the branches reach to u_x_max. Unknowns are those of a patch from node `first` on. The trace's
    jumps are the folds of the approach, loads delta (nm). Treat it as read-only.

    Example: `skeleton_of(Scene()).slips`
    """

    scene: Scene = field(repr=False)
    first: int
    trace: Trace
    lost: bool = False  # whether there are jumps that are not among those of the trace
    evaluations: int = 0  # force evaluations spent in getting it
    residual: float = np.inf  # nm, the largest of its states
    held: Held | None = field(default=None, repr=False)  # under a held load

    def __repr__(self) -> str:
        period = f"repeats itself after {self.period:.6g} nm" if self.period else "does not repeat itself"
        count = f"{len(self.branches)} branch{'es' * (len(self.branches) != 1)}"
        return f"Skeleton of {self.scene!r}: {count}, {period}, {self.evaluations} force evaluations"

    @property
    def branches(self) -> tuple[Branch, ...]:
        """The branches in order, up to u_x_max or to where the run repeats itself."""
        return self.trace.branches

    @property
    def period(self) -> float:
        """The load, nm, after which everything repeats; 0.0 where nothing does."""
        return self.trace.period

    @property
    def sites(self) -> int:
        """The period in sites of the lattice."""
        return round(self.period / self.scene.spacing)

    @property
    def jumps_in(self) -> float | None:
        """delta_bar at which the surfaces jump into contact on approach, or None."""
        jumps = self.trace.jumps
        return jumps[0].load / self.scene.delta_0 if jumps else None

    @property
    def nodes(self) -> int:
        """Number of nodes of the patch."""
        return self.branches[0].states[0].v.size // 2

    @property
    def pressure(self) -> float | None:
        """The mean normal traction that is held, GPa, or None."""
        if self.held is None:
            return None
        return float(self.tractions(self.held.v[None])[0, 1].sum()) / self.scene.nodes

    @cached_property
    def slips(self) -> tuple[SlipEvent, ...]:
        """The SlipEvents of the shear up to u_x_max."""
        events = []
        if self.held is not None and self.held.kind:
            at_end = forces_and_area(self.scene, self.tractions(self.held.v[None])[0])
            events.append(SlipEvent(0.0, *at_end, "shear", self.held.kind, True))
        at_ends = [forces_and_area(self.scene, self.tractions(b.states[-1].v[None])[0]) for b in self.branches]
        for index, turns in self.trace.passes():
            load, slip = float(self.branches[index].end + turns * self.period), self.branches[index].slip
            if slip is None or load > self.scene.u_x_max:
                break
            events.append(SlipEvent(load, *at_ends[index], "shear", sensitive=slip.sensitive))
        return tuple(events)

    def curve(self, U_x: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """(F_bar, L_bar, A_bar), arrays, at loads U_x (k,) nm."""
        T = self.tractions(self.unknowns(U_x))
        return *forces(self.scene, T), np.array([contact_area(self.scene, T_at) for T_at in T])

    def frames(self, U_x: ArrayLike, residuals: bool = True) -> list[Frame]:
        """The Frames at loads U_x (k,) nm, with no slips in them.

        residuals: evaluate them, one force evaluation each; else `Frame.residual` is nan.
        """
        scene, problem, frames = self.scene, self.problem(), []
        r = np.empty(problem.size)
        for load, v in zip(np.atleast_1d(U_x).tolist(), self.unknowns(U_x), strict=True):
            index = round(load / (scene.du_x * scene.delta_t))
            residual = problem.residual(v, load, r) if residuals else np.nan
            frames.append(frame_of(scene, problem, State.at_rest(load, v), "shear", index, residual))
        return frames

    def problem(self) -> Equilibrium:
        """The shear, a problem on the patch."""
        contact = Contact(self.scene, self.first, self.nodes)
        return Equilibrium(contact, sideways(1.0, -self.scene.delta if self.held is None else 0.0), self.pressure)

    def unknowns(self, U_x: ArrayLike) -> NDArray[np.float64]:
        """The unknowns (k, size) at loads U_x (k,) nm: u_x, u_z of the patch and, under a held load, U_z, nm.

        Raises ValueError for loads that the run did not reach.
        """
        U_x = np.atleast_1d(np.asarray(U_x, float))
        ends, step = np.array([branch.end for branch in self.branches]), self.scene.du_x * self.scene.delta_t
        first, last = self.branches[0].start, np.inf if self.period else max(ends[-1], self.scene.u_x_max)
        if (outside := U_x[(U_x < first - step) | (U_x > last + step)]).size:
            allowed = f"allowed for this run: {first:g} .. {last:g} nm"
            raise ValueError(f"U_x = {outside[0]:g}: {allowed}; choose another, or compute a run of larger u_x_max")
        shift = np.maximum(0.0, np.ceil((U_x - ends[-1]) / self.period)) * self.period if self.period else 0.0 * U_x
        index = np.minimum(np.searchsorted(ends, U_x - shift), ends.size - 1)
        v = np.empty((U_x.size, self.branches[0].states[0].v.size))
        for k, branch in enumerate(self.branches):
            mine = index == k
            v[mine] = branch.unknowns(U_x[mine] - shift[mine])
        v[:, : self.nodes] += shift[:, None]
        return v

    def tractions(self, v: NDArray[np.float64]) -> NDArray[np.float64]:
        """T (k, 2, m), GPa, of unknowns v (k, size)."""
        return tractions(self.scene, self.first, v)


def tractions(scene: Scene, first: int, v: NDArray[np.float64]) -> NDArray[np.float64]:
    """T (k, 2, m), GPa, of unknowns v (k, size) of the patch whose first node is `first`."""
    m = v.shape[1] // 2
    profile, T = scene.profile[first : first + m], np.empty((len(v), 2, m))
    few = max(1, FIT // m)
    for k in range(0, len(v), few):
        part = v[k : k + few]
        gap = profile + part[:, m : 2 * m]
        T[k : k + few] = traction(scene, part[:, :m], gap).swapaxes(0, 1)
    return T


def skeleton_in(run: object) -> Skeleton:
    """A Skeleton itself, or that of a Result or a Certificate; raises TypeError, which names what to pass."""
    found = getattr(run, "skeleton", run)
    if isinstance(found, Skeleton):
        return found
    raise TypeError(f"skeleton = {type(run).__name__}: allowed: a Skeleton; use skeleton_of(scene)")
