"""What a run has passed: the states of its branches and their ends and, once it repeats itself, its period.

If v is an equilibrium at load s, then v moved on by k sites is one at s + k a, and stable if v is. Once a slip has
landed in a state that was passed k sites before, one period of the run describes the rest of it. A period may hold
several slips.
"""

from bisect import bisect_left
from dataclasses import dataclass, field, replace
from math import ceil, floor, sqrt
from typing import Any, NamedTuple

import numpy as np

from .interpolation import lagrange
from .state import End


@dataclass(frozen=True)
class TraceOptions:
    """How a period is recognised, and states are interpolated."""

    same: float = 0.01  # units of the problem: closer states are the same; others differ by a good part of a site
    near: float = 1e-6  # nm: closer loads are the same, far above rounding and far below an increment
    stencil: int = 6  # states for interpolation: with 0.1 nm between them the error meets a tolerance of 1e-8 nm


OPTIONS = TraceOptions()


class Passed(NamedTuple):
    """An equilibrium that the run has passed."""

    load: float  # nm
    v: np.ndarray  # (size,)
    active: np.ndarray


@dataclass(frozen=True, eq=False)
class TracedBranch:
    """The states of one branch in order of the load, and its End, whose state is the last one."""

    states: tuple[Passed, ...] = field(repr=False)
    end: Any = None  # an End, or None before it

    @property
    def start(self) -> float:
        """Load of the first state, nm."""
        return self.states[0].load

    def added(self, state: Passed) -> "TracedBranch":
        """The same with one more state, unless there is one at its load."""
        i = bisect_left(self.states, state.load - OPTIONS.near, key=lambda passed: passed.load)
        if i < len(self.states) and self.states[i].load <= state.load + OPTIONS.near:
            return self
        return TracedBranch((*self.states[:i], state, *self.states[i:]), self.end)

    def ended(self, slip: End) -> "TracedBranch":
        """The same up to its end; no other state has that load."""
        before = tuple(state for state in self.states if state.load < slip.load - OPTIONS.near)
        return TracedBranch((*before, Passed(slip.load, slip.v, slip.active)), slip._replace(after=None))

    def moved(self, distance: float, direction: np.ndarray) -> "TracedBranch":
        """The same, moved on by a whole number of sites, nm; direction: the problem's."""
        states = tuple(Passed(load + distance, v + distance * direction, active) for load, v, active in self.states)
        end = self.end and self.end._replace(load=self.end.load + distance, v=states[-1].v)
        return TracedBranch(states, end)

    def at(self, load: float, stencil: int = OPTIONS.stencil) -> Passed:
        """The state at `load`, nm, interpolated over the root of the distance to the end, smooth at a fold."""
        i = bisect_left(self.states, load, key=lambda passed: passed.load)
        low = min(max(i - stencil // 2, 0), max(len(self.states) - stencil, 0))
        near = self.states[low : low + stencil]
        weights = lagrange([self._arc(state.load) for state in near], self._arc(load))
        return Passed(load, np.asarray(weights) @ np.array([v for _, v, _ in near]), self.states[max(i - 1, 0)].active)

    def _arc(self, load):
        return load if self.end is None else -sqrt(max(self.end.load - load, 0.0))


@dataclass(frozen=True, eq=False)
class Trace:
    """The branches of a run in order; the last one has no end yet, unless the run repeats itself.

    Then `period`, nm, is known: the last slip lands where the run was at the load `home`, nm, moved on by a period.
    """

    branches: tuple[TracedBranch, ...]
    period: Any = None  # nm, or None before it is known
    home: float = 0.0

    @staticmethod
    def of(state) -> "Trace":
        """That of a run which begins with a State."""
        return Trace((TracedBranch((_passed(state),)),))

    @property
    def end(self) -> float:
        """Load of the last slip, nm."""
        return self.branches[-1].end.load

    def extended(self, increment) -> "Trace":
        """With what an Increment passed."""
        *before, last = self.branches
        for slip in increment.slips:
            before.append(last.ended(slip))
            last = TracedBranch((_passed(slip.after),))
        return Trace((*before, last.added(_passed(increment.state))), self.period, self.home)

    def added(self, branch: TracedBranch, state: Passed) -> "Trace":
        """With one more state of one of its branches."""
        k = self.branches.index(branch)
        return Trace((*self.branches[:k], branch.added(state), *self.branches[k + 1 :]), self.period, self.home)

    def adopted(self, wide, problem) -> "Trace":
        """In the unknowns of a problem `wide`, which has more of them than the `problem` of the trace."""
        branches = []
        for branch in self.branches:
            states = tuple(Passed(s, *wide.adopted(problem, v, active, s)) for s, v, active in branch.states)
            end = branch.end and branch.end._replace(v=states[-1].v, active=states[-1].active)
            branches.append(TracedBranch(states, end))
        return replace(self, branches=tuple(branches))

    def closed(self, problem, spacing: float) -> "Trace":
        """With its period, if the state in which the last slip has landed was passed some sites before.

        spacing: of sites, nm.
        """
        landed, first = self.branches[-1].states[0], self.branches[0].start
        slip, same = self.branches[-2].end, OPTIONS.same * problem.unit
        for sites in range(1, floor((slip.load - first + OPTIONS.near) / spacing) + 1):
            period = sites * spacing
            home = landed.load - period
            branch = self.branch_at(max(home, first))
            if branch is None or len(branch.states) < 2:
                continue
            if np.abs(branch.at(home).v + period * problem.direction - landed.v).max() <= same:
                k = self.branches.index(branch)
                if not all(passed.end.located for passed in self.branches[k:-1]):
                    return self
                if home < first:  # the slip lands in a state from before the run began
                    branch = branch.added(Passed(home, landed.v - period * problem.direction, landed.active))
                return Trace((*self.branches[:k], branch, *self.branches[k + 1 : -1]), period, home)
        return self

    def branch_at(self, load: float) -> TracedBranch | None:
        """The ended branch that holds that load, nm."""
        for branch in reversed(self.branches):
            if branch.end is not None and branch.start - OPTIONS.near <= load <= branch.end.load:
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
        found, first = [], self.branches.index(self.branch_at(max(self.home, self.branches[0].start)))
        for turns in range(ceil((low - self.end) / self.period), ceil((high - self.end) / self.period) + 1):
            for branch in self.branches[first:]:
                shift = turns * self.period
                if low < branch.end.load + shift <= high:
                    v = branch.end.v + shift * direction
                    found.append(branch.end._replace(load=branch.end.load + shift, v=v))
        return found


def _passed(state) -> Passed:
    return Passed(state.load, state.v, state.active)
