"""What a run has passed: the states of its branches and their ends and, once it repeats itself, its period.

If v is an equilibrium at load s, then v moved on by k sites is one at s + k a, and stable if v is. Once a slip has
landed in a state that was passed k sites before, one period of the run describes the rest of it. A period may hold
several slips.
"""

from bisect import bisect_left
from dataclasses import dataclass, field, replace
from math import ceil, floor
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from .state import TINY, End


@dataclass(frozen=True)
class TraceOptions:
    """How a period is recognised, and states are interpolated."""

    same: float = 0.01  # units of the problem: closer states are the same; others differ by a good part of a site
    stencil: int = 6  # states for interpolation: with 0.1 nm between them the error meets a tolerance of 1e-8 nm


OPTIONS = TraceOptions()
NEAR = 1e-6  # nm: closer loads are the same, far above rounding and far below an increment


def lagrange(nodes: ArrayLike, x: ArrayLike) -> NDArray[np.float64]:
    """Weights (..., n) of the values at `nodes` (..., n) in that of their polynomial at x (...)."""
    nodes = np.asarray(nodes, float)
    return _lagrange(nodes.reshape(-1, nodes.shape[-1]), np.asarray(x, float).reshape(-1)).reshape(nodes.shape)


@njit(cache=True, nogil=True, error_model="numpy")  # where two nodes are one, weights are infinite
def _lagrange(nodes, x):
    """As `lagrange`, (k, n) for (k, n) and (k,): a run asks for so few weights so often that numpy's calls add up."""
    weights = np.ones_like(nodes)
    for k in range(nodes.shape[0]):
        for i in range(nodes.shape[1]):
            for j in range(nodes.shape[1]):
                if j != i:
                    weights[k, i] *= (x[k] - nodes[k, j]) / (nodes[k, i] - nodes[k, j])
    return weights


class Passed(NamedTuple):
    """An equilibrium that the run has passed."""

    load: float  # nm
    v: np.ndarray  # (size,)


@dataclass(frozen=True, eq=False)
class Branch:
    """The states of one branch in order of the load, and the End that is the last one; None where it does not slip.

    periodic: smooth sliding over one period: v less the load is periodic.
    """

    states: tuple[Passed, ...] = field(repr=False)
    slip: End | None = field(default=None, repr=False)
    periodic: bool = False

    @staticmethod
    def of(loads: ArrayLike, v: np.ndarray, **more: Any) -> "Branch":
        """The Branch of states v (n, size) at loads (n,), nm."""
        return Branch(tuple(map(Passed, np.asarray(loads, float).tolist(), v)), **more)

    @property
    def start(self) -> float:
        """Load of the first state, nm."""
        return self.states[0].load

    @property
    def end(self) -> float:
        """Load of the last state, nm."""
        return self.states[-1].load

    @property
    def loads(self) -> NDArray[np.float64]:
        """Loads of the states, (n,) nm."""
        return np.array([state.load for state in self.states])

    @property
    def v(self) -> NDArray[np.float64]:
        """Unknowns of the states, (n, size)."""
        return np.array([state.v for state in self.states])

    def added(self, state: Passed) -> "Branch":
        """The same with one more state, unless there is one at its load."""
        i = bisect_left(self.states, state.load - NEAR, key=lambda passed: passed.load)
        if i < len(self.states) and self.states[i].load <= state.load + NEAR:
            return self
        return replace(self, states=(*self.states[:i], state, *self.states[i:]))

    def ended(self, slip: End) -> "Branch":
        """The same up to its end; no other state has that load."""
        before = tuple(state for state in self.states if state.load < slip.load - NEAR)
        return Branch((*before, Passed(slip.load, slip.v)), slip._replace(after=None))

    def moved(self, distance: float, direction: np.ndarray) -> "Branch":
        """The same, moved on by a whole number of sites, nm; direction: the problem's."""
        states = tuple(Passed(load + distance, v + distance * direction) for load, v in self.states)
        return replace(self, states=states, slip=self.slip and self.slip.moved(distance, direction))

    def position(self, load: ArrayLike) -> NDArray[np.float64]:
        """t of loads, from 0 to 1; towards a slip the root of the distance, in which states are smooth at a fold."""
        part = (np.asarray(load, float) - self.start) / max(self.end - self.start, TINY)
        if self.periodic:
            return part % 1.0
        part = np.clip(part, 0.0, 1.0)
        return part if self.slip is None else 1.0 - np.sqrt(1.0 - part)

    def load_at(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """Loads, nm, at t."""
        part = t if self.slip is None else 1.0 - (1.0 - t) ** 2
        return self.start + (self.end - self.start) * part

    def _near(self, load, stencil=OPTIONS.stencil):
        """(index (k, s), weights (k, s)) of the states from which those at loads (k,) are interpolated."""
        n = len(self.states) - self.periodic  # over a period, the first state counts as the last one
        t, x, size = self.position(self.loads)[:n], self.position(load), min(stencil, n)
        first = np.searchsorted(t, x) - size // 2
        if not self.periodic:
            first = np.clip(first, 0, n - size)
        index = first[:, None] + np.arange(size)
        return index % n, lagrange(t[index % n] + index // n, x)

    def at(self, load: float, stencil: int = OPTIONS.stencil) -> Passed:
        """The state at `load`, nm, between the ends of the branch."""
        (index,), (weights,) = self._near(np.array([load]), stencil)
        return Passed(load, weights @ np.array([self.states[i].v for i in index]))

    def weights(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weights (k, n) of the states in those at loads (k,); beyond the ends of the branch, of its ends."""
        out = np.zeros((len(load), len(self.states)))
        index, weights = self._near(load)
        np.put_along_axis(out, index, weights, axis=1)
        return out

    def unknowns(self, load: NDArray[np.float64], moving: int) -> NDArray[np.float64]:
        """Unknowns (k, size) at loads (k,), nm; the first `moving` of them move on with the load."""
        v = self.v
        v[:, :moving] -= self.loads[:, None]
        out = self.weights(load) @ v
        out[:, :moving] += load[:, None]
        return out


@dataclass(frozen=True, eq=False)
class Trace:
    """The branches of a run in order; the last one has no end yet, unless the run repeats itself.

    Then `period`, nm, is known: the last slip lands where the run was at the load `home`, nm, moved on by a period.
    """

    branches: tuple[Branch, ...]
    period: Any = None  # nm, or None before it is known
    home: float = 0.0

    @staticmethod
    def of(state) -> "Trace":
        """That of a run which begins with a State."""
        return Trace((Branch((_passed(state),)),))

    @property
    def end(self) -> float:
        """Load of the last state, nm."""
        return self.branches[-1].end

    def extended(self, increment) -> "Trace":
        """With what an Increment passed."""
        *before, last = self.branches
        for slip in increment.slips:
            before.append(last.ended(slip))
            last = Branch((_passed(slip.after),))
        return replace(self, branches=(*before, last.added(_passed(increment.state))))

    def added(self, branch: Branch, state: Passed) -> "Trace":
        """With one more state of one of its branches."""
        k = self.branches.index(branch)
        return replace(self, branches=(*self.branches[:k], branch.added(state), *self.branches[k + 1 :]))

    def closed(self, problem, spacing: float, options: TraceOptions = OPTIONS) -> "Trace":
        """With its period, if the state in which the last slip has landed was passed some sites before.

        spacing: of sites, nm.
        """
        landed, first = self.branches[-1].states[0], self.branches[0].start
        slip, same = self.branches[-2].end, options.same * problem.unit
        for sites in range(1, floor((slip - first + NEAR) / spacing) + 1):
            period = sites * spacing
            home = landed.load - period
            branch = self.branch_at(max(home, first))
            if branch is None or len(branch.states) < 2:
                continue
            if np.abs(branch.at(home, options.stencil).v + period * problem.direction - landed.v).max() <= same:
                k = self.branches.index(branch)
                if not all(passed.slip and passed.slip.located for passed in self.branches[k:-1]):
                    return self
                if home < first:  # the slip lands in a state from before the run began
                    branch = branch.added(Passed(home, landed.v - period * problem.direction))
                return Trace((*self.branches[:k], branch, *self.branches[k + 1 : -1]), period, home)
        return self

    def branch_at(self, load: float) -> Branch | None:
        """The ended branch that holds that load, nm."""
        for branch in reversed(self.branches):
            if branch.slip is not None and branch.start - NEAR <= load <= branch.end:
                return branch
        return None

    def stable_from(self, load: float) -> float:
        """The next load, nm, at which the surface rests: after a slip it may be a higher one than the slip's."""
        if load < self.home:
            return self.home
        after = [branch.start for branch in self.branches if branch.start >= load]
        return load if self.branch_at(load) is not None or not after else min(after)

    def slips(self, low: float, high: float, direction: np.ndarray) -> list[End]:
        """The Ends of a run that repeats itself at loads above `low`, up to `high`, nm; direction: the problem's."""
        slips, first = [], self.branches.index(self.branch_at(max(self.home, self.branches[0].start)))
        for turns in range(ceil((low - self.end) / self.period), ceil((high - self.end) / self.period) + 1):
            shift = turns * self.period
            passed = (b.slip for b in self.branches[first:] if b.slip and low < b.end + shift <= high)
            slips += [slip.moved(shift, direction) for slip in passed]
        return slips


def _passed(state) -> Passed:
    return Passed(state.load, state.v)
