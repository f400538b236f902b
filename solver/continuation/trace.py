"""What a run has passed: the states of its branches and their ends and, once it repeats itself, its period.

If v is an equilibrium at load s, then v moved on by k sites is one at s + k a, and stable if v is. Once a slip has
landed in a state that was passed k sites before, one period of the run describes the rest of it. A period may hold
several slips, or none where the surface slides smoothly.
"""

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .compiled import kernel
from .state import TINY, End, Increment, Point, State

SAME_STATE = 0.01  # units of the problem: closer states are the same; others differ by a good part of a site
STENCIL = 6  # states for interpolation: with 0.1 nm between them the error meets a tolerance of 1e-8 nm
SAME_LOAD = 1e-6  # nm: closer loads are the same, far above rounding and far below an increment
STATES = 128  # states of a Trace: a period of four sites has 100; with 64, some runs take more evaluations
THINNED = 8  # a growing branch is thinned once in so many states
FEWEST_STATES = 2 * STENCIL  # states of a branch that is thinned: half of fewer would not do for interpolation


def lagrange(nodes: ArrayLike, x: ArrayLike) -> NDArray[np.float64]:
    """Weights (..., n) of the values at `nodes` (..., n) in that of their polynomial at x (...)."""
    nodes = np.asarray(nodes, float)
    return _lagrange(nodes.reshape(-1, nodes.shape[-1]), np.asarray(x, float).reshape(-1)).reshape(nodes.shape)


@kernel(error_model="numpy")  # where two nodes are one, weights are infinite
def _lagrange(nodes, x):
    """As `lagrange`, (k, n) for (k, n) and (k,): a run asks for so few weights so often that numpy's calls add up."""
    weights = np.ones_like(nodes)
    for k in range(nodes.shape[0]):
        for i in range(nodes.shape[1]):
            for j in range(nodes.shape[1]):
                if j != i:
                    weights[k, i] *= (x[k] - nodes[k, j]) / (nodes[k, i] - nodes[k, j])
    return weights


@dataclass(frozen=True, eq=False)
class Branch:
    """The states of one branch in order of the load, and the End that is the last one; None where it does not slip.

    periodic: smooth sliding over one period: the last state is the first one, moved on.
    """

    states: tuple[Point, ...] = field(repr=False)
    slip: End | None = field(default=None, repr=False)
    periodic: bool = False

    @staticmethod
    def of(loads: ArrayLike, v: np.ndarray, **more: Any) -> "Branch":
        """The Branch of states v (n, size) at loads (n,), nm."""
        return Branch(tuple(map(Point, np.asarray(loads, float).tolist(), v)), **more)

    def __reduce__(self):
        """Pickled, unknowns are rounded to 1e-9 of their largest change between two states, in half as many bytes."""
        v = self.v
        unit = np.abs(np.diff(v, axis=0)).max(initial=1e-3) / 2**30
        steps = np.diff(np.rint(v / unit), axis=0, prepend=0.0)
        return _restored, (self.loads, unit, steps[0], steps[1:].astype(np.int32), self.slip, self.periodic)

    @property
    def start(self) -> float:
        """Load of the first state, nm."""
        return self.states[0].load

    @property
    def end(self) -> float:
        """Load of the last state, nm."""
        return self.states[-1].load

    @cached_property
    def loads(self) -> NDArray[np.float64]:
        """Loads of the states, (n,) nm."""
        return np.array([state.load for state in self.states])

    @cached_property
    def _places(self):
        """t of the states; over a period the first one counts as the last one, which is left out."""
        return self.position(self.loads)[: len(self.states) - self.periodic]

    @property
    def v(self) -> NDArray[np.float64]:
        """Unknowns of the states, (n, size)."""
        return np.array([state.v for state in self.states])

    def added(self, state: Point) -> "Branch":
        """The same with one more state, unless there is one at its load."""
        i = bisect_left(self.states, state.load - SAME_LOAD, key=lambda passed: passed.load)
        if i < len(self.states) and self.states[i].load <= state.load + SAME_LOAD:
            return self
        return replace(self, states=(*self.states[:i], state, *self.states[i:]))

    def ended(self, slip: End) -> "Branch":
        """The same up to its end; no other state has that load."""
        before = tuple(state for state in self.states if state.load < slip.load - SAME_LOAD)
        return Branch((*before, Point(slip.load, slip.v)), slip._replace(after=None))

    def without(self, out: NDArray[np.int_]) -> "Branch":
        """The same without the states of these indices."""
        left = np.delete(np.arange(len(self.states)), out)
        return replace(self, states=tuple(self.states[i] for i in left))

    def thinned(self, n: int, error: float | None = None) -> "Branch":
        """Drops states, of the first n, that the others interpolate to `error`, nm; None: the best quarter."""
        out = np.arange(1, n, 2)
        errors = np.abs(self.without(out).unknowns(self.loads[out]) - self.v[out]).max(axis=1)
        return self.without(out[np.argsort(errors)[: ceil(out.size / 2)]] if error is None else out[errors < error])

    def shifted(self, distance: float, direction: np.ndarray) -> "Branch":
        """The same, moved on by a whole number of sites, nm; direction: the problem's."""
        states = tuple(Point(load + distance, v + distance * direction) for load, v in self.states)
        return replace(self, states=states, slip=self.slip and self.slip.shifted(distance, direction))

    def position(self, load: ArrayLike) -> NDArray[np.float64]:
        """t of loads, from 0 to 1; towards a slip the root of the distance, in which states are smooth at a fold."""
        part = (np.asarray(load, float) - self.start) / max(self.end - self.start, TINY)
        if self.periodic:
            return part % 1.0
        part = np.minimum(np.maximum(part, 0.0), 1.0)  # in place of `clip`, which takes four times as long
        return part if self.slip is None else 1.0 - np.sqrt(1.0 - part)

    def load_at(self, t: NDArray[np.float64]) -> NDArray[np.float64]:
        """Loads, nm, at t."""
        part = t if self.slip is None else 1.0 - (1.0 - t) ** 2
        return self.start + (self.end - self.start) * part

    def _near(self, load, stencil):
        """(index, weights (k, s), turns (k,)): the states at loads (k,) are weights . v[index], moved on by turns."""
        t, x = self._places, self.position(load)
        n, size = t.size, min(stencil, t.size)
        first = np.searchsorted(t, x) - size // 2
        if not self.periodic:
            index = np.minimum(np.maximum(first, 0), n - size)[:, None] + np.arange(size)
            return index, lagrange(t[index], x), 0.0 * x
        index = first[:, None] + np.arange(size)
        turn = index // n
        weights = lagrange(t[index % n] + turn, x)
        whole = np.floor((load - self.start) / max(self.end - self.start, TINY))
        return index % n, weights, (weights * turn).sum(axis=1) + whole

    def at(self, load: float, stencil: int = STENCIL) -> Point:
        """The state at `load`, nm, between the ends of the branch."""
        (index,), (weights,), (turns,) = self._near(np.array([load]), stencil)
        v = weights @ np.array([self.states[i].v for i in index])
        return Point(load, v + turns * (self.states[-1].v - self.states[0].v) if self.periodic else v)

    def weights(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weights (k, n) of the states in those at loads (k,); beyond the ends of the branch, of its ends."""
        return self._weights(load)[0]

    def _weights(self, load):
        """(the `weights`, turns (k,) as of `_near`)."""
        out = np.zeros((len(load), len(self.states)))
        index, weights, turns = self._near(load, STENCIL)
        np.put_along_axis(out, index, weights, axis=1)
        return out, turns

    def unknowns(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """Unknowns (k, size) at loads (k,), nm; beyond the ends of the branch, unless it is periodic, of its ends."""
        v, (weights, turns) = self.v, self._weights(load)
        return weights @ v + np.outer(turns, v[-1] - v[0])


def _restored(loads, unit, first, steps, slip, periodic):
    """The Branch that was pickled."""
    return Branch.of(loads, unit * np.cumsum([first, *steps], axis=0), slip=slip, periodic=periodic)


@dataclass(frozen=True, eq=False)
class Trace:
    """The branches of a run in order. Then the run repeats them from branch `home` on, moved by `period`.

    period: nm, by which it is moved on; 0.0 where the run does not repeat itself, or not yet: the last branch has no
    end then. jumps: the ends passed before, under loads that no site repeats. Treat it as read-only.
    """

    branches: tuple[Branch, ...]
    home: int = 0
    period: float = 0.0
    jumps: tuple[End, ...] = field(default=(), repr=False)

    @staticmethod
    def of(state: State | Point, jumps: tuple[End, ...] = ()) -> "Trace":
        """That of a run which begins with a state."""
        return Trace((Branch((Point(*state[:2]),)),), jumps=jumps)

    @property
    def end(self) -> float:
        """Load of the last state, nm."""
        return self.branches[-1].end

    @property
    def lands(self) -> float:
        """Load, nm, at which the surface rests after the last slip of a period: that of the slip, or a higher one."""
        slip = self.branches[-1].slip
        return slip.after.load if slip and slip.after else self.end

    def extended(self, increment: Increment, error: float = 0.0) -> "Trace":
        """With what an Increment passed, without the older states of its branch that others give to `error`, nm."""
        *before, last = self.branches
        for slip in increment.slips:
            before.append(last.ended(slip))
            assert slip.after is not None
            last = Branch((Point(*slip.after[:2]),))
        last = last.added(Point(*increment.state[:2]))
        if len(last.states) % THINNED == 0:
            last = last.thinned(len(last.states) - STENCIL, error)
        return replace(self, branches=(*before, last)).bounded()

    def added(self, branch: Branch, state: Point) -> "Trace":
        """With one more state of one of its branches."""
        return self._with(branch, branch.added(state)).bounded()

    def _with(self, branch, new):
        """With another Branch in the place of one of its branches."""
        k = self.branches.index(branch)
        return replace(self, branches=(*self.branches[:k], new, *self.branches[k + 1 :]))

    def bounded(self) -> "Trace":
        """With at most STATES states: the longest branch is thinned, or if all are short, the first one left out."""
        trace = self
        while sum(len(branch.states) for branch in trace.branches) > STATES:
            longest = max(trace.branches, key=lambda branch: len(branch.states))
            if len(longest.states) >= FEWEST_STATES:
                trace = trace._with(longest, longest.thinned(len(longest.states) - 1))
            elif trace.period and not trace.home:  # all of them are needed
                break
            else:
                trace = replace(trace, branches=trace.branches[1:], home=max(trace.home - 1, 0))
        return trace

    def closed(self, problem, spacing: float) -> "Trace":
        """With its period, if the run has come to where it was some sites before; spacing: of sites, nm.

        After slips that is the state in which the last one has landed; without any, the first one.
        """
        if len(self.branches) == 1:
            return self._smooth(problem, spacing)
        landed, first = self.branches[-1].states[0], self.branches[0].start
        slip = self.branches[-2].end
        for sites in range(1, floor((slip - first + SAME_LOAD) / spacing) + 1):
            period = sites * spacing
            home = landed.load - period
            branch = self.branch_at(max(home, first))
            if branch is None or len(branch.states) < 2:
                continue
            if _apart(branch.at(home).v + period * problem.direction, landed.v) <= SAME_STATE * problem.unit:
                return self._from(branch, landed, period, problem.direction)
        return self

    def _from(self, branch, landed, period, direction):
        """The closed Trace, if the last slip has landed in a state of `branch`, moved on by a period."""
        k, home = self.branches.index(branch), landed.load - period
        if not all(passed.slip and passed.slip.located for passed in self.branches[k:-1]):
            return self
        *branches, last = self.branches[:-1]
        after = None if landed.load <= last.end + SAME_LOAD else State(landed.load, landed.v, [])
        branches.append(replace(last, slip=last.slip._replace(after=after)))
        if home < self.branches[0].start:  # the slip lands in a state from before the run began
            branches[k] = branches[k].added(Point(home, landed.v - period * direction))
        while (n := int(np.searchsorted(branches[k].loads, home)) - STENCIL) > FEWEST_STATES:  # they are not repeated
            branches[k] = branches[k].thinned(n)
        return replace(self, branches=tuple(branches), home=k, period=period)

    def _smooth(self, problem, spacing):
        """Closed by the state a site after the first one, if there was no slip in between."""
        (branch,), (load, v) = self.branches, self.branches[0].states[0]
        end = Point(load + spacing, v + spacing * problem.direction)
        if branch.end < end.load - SAME_LOAD or _apart(branch.at(end.load).v, end.v) > SAME_STATE * problem.unit:
            return self
        states = (*(state for state in branch.states if state.load < end.load - SAME_LOAD), end)
        return replace(self, branches=(Branch(states, periodic=True),), period=spacing)

    def branch_at(self, load: float) -> Branch | None:
        """The ended branch that holds that load, nm."""
        for branch in reversed(self.branches):
            if (branch.slip is not None or branch.periodic) and branch.start - SAME_LOAD <= load <= branch.end:
                return branch
        return None

    def stable_from(self, load: float) -> float:
        """The next load, nm, at which the surface rests: after a slip it may be a higher one than the slip's."""
        if load < self.lands - self.period:
            return self.lands - self.period
        after = [branch.start for branch in self.branches if branch.start >= load]
        return load if self.branch_at(load) is not None or not after else min(after)

    def passes(self) -> Iterator[tuple[int, int]]:
        """Yields (index of a branch, periods since its first pass) in the order of the run; endless if that repeats."""
        yield from ((index, 0) for index in range(len(self.branches)))
        for turns in count(1) if self.period else ():
            yield from ((index, turns) for index in range(self.home, len(self.branches)))

    def slips_between(self, low: float, high: float, direction: np.ndarray) -> tuple[End, ...]:
        """The Ends of a run that repeats itself at loads above `low`, up to `high`, nm; direction: the problem's."""
        slips, again = list[End](), self.branches[self.home :]
        for turns in range(ceil((low - self.end) / self.period), ceil((high - self.end) / self.period) + 1):
            shift = turns * self.period
            passed = (b.slip for b in again if b.slip and low < b.end + shift <= high)
            slips += [slip.shifted(shift, direction)._replace(after=None) for slip in passed]
        return tuple(slips)


def _apart(v, w):
    """The largest difference of unknowns, nm."""
    return np.abs(v - w).max()
