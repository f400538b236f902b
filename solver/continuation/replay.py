"""Sliding repeats itself: translation by a lattice site is an exact symmetry, so one period of a run tells the rest.

If v is an equilibrium at load s, then v moved on by k sites is one at s + k a, and rests if v does. Once a slip has
landed in a state that was passed k sites before, all later states are known ones moved on by k sites, 2 k and so on.
The residual of each is evaluated, to be sure. A period may hold several slips.
"""

from bisect import bisect_left
from copy import copy
from dataclasses import dataclass, field, replace
from math import ceil, floor, sqrt

import numpy as np

from .interpolation import combine, lagrange
from .state import Increment, Slip


@dataclass(frozen=True)
class Limits:
    """Of recognising and using a period."""

    same: float = 0.01  # units of the problem; states closer than that are the same, others are part of a site off
    near: float = 1e-6  # nm; loads that close are the same, lest rounding decide
    stencil: int = 6  # known states through which one in between is interpolated


LIMITS = Limits()


@dataclass
class Branch:
    """The states of one branch in order of the load: loads, nm, and (v, active) of each; the Slip at its end."""

    loads: list = field(default_factory=list)
    states: list = field(default_factory=list)
    end: Slip | None = None

    def add(self, load, v, active):
        """Insert a state (v, active) in order of its load, nm, unless it is there already."""
        i = bisect_left(self.loads, load - LIMITS.near)
        if i == len(self.loads) or self.loads[i] > load + LIMITS.near:
            self.loads.insert(i, load)
            self.states.insert(i, (v, active))

    def state_at(self, load, stencil=LIMITS.stencil):
        """(v, active) at `load`: interpolated over the root of the load's distance to the end, smooth at a fold."""
        i = bisect_left(self.loads, load)
        low = min(max(i - stencil // 2, 0), max(len(self.loads) - stencil, 0))
        near = slice(low, low + stencil)
        arcs = [-sqrt(max(self.end.load - other, 0.0)) for other in self.loads[near]]
        weights = lagrange(arcs, -sqrt(max(self.end.load - load, 0.0)))
        return combine(weights, [v for v, _ in self.states[near]]), self.states[max(i - 1, 0)][1]


@dataclass
class Record:
    """The branches of a run in order. Once it repeats itself, those of a period: loads, nm, from `home` to `end`."""

    branches: list
    period: float | None = None
    home: float = 0.0
    end: float = 0.0
    safety: tuple = (0.0, None)  # the largest of its states', as of `rest.Mode`

    @staticmethod
    def of(state):
        """The Record of a run that begins with a State."""
        return Record([Branch([state.load], [(state.v, state.active)])])

    def copy(self):
        """The same states in lists of its own, so that adding to one Record leaves the other as it is."""
        return replace(self, branches=[replace(b, loads=list(b.loads), states=list(b.states)) for b in self.branches])

    def add(self, increment):
        """Take in what an Increment passed."""
        if increment.state.mode is not None:
            self.safety = max(self.safety, increment.state.mode.safety, key=lambda safety: safety[0])
        for slip in increment.slips:
            branch = self.branches[-1]
            branch.end = slip
            branch.add(slip.load, slip.v, slip.active)
            self.branches.append(Branch([slip.after.load], [(slip.after.v, slip.after.active)]))
        self.branches[-1].add(increment.state.load, increment.state.v, increment.state.active)

    def branch_at(self, load):
        """The ended Branch that holds that load, nm, or None."""
        for branch in reversed(self.branches):
            if branch.end is not None and branch.loads[0] - LIMITS.near <= load <= branch.end.load:
                return branch
        return None

    def resting(self, load):
        """The next known load, nm, at which the surface rests: after a slip it may be one higher than the slip's."""
        if load < self.home:
            return self.home
        after = [b.loads[0] for b in self.branches if b.loads[0] >= load]
        return load if self.branch_at(load) is not None or not after else min(after)


class Replay:
    """A stepper around another, for a load that is U_x, over sites `spacing` nm apart: what repeats is moved on."""

    def __init__(self, stepper, spacing):
        self.stepper, self.spacing = stepper, spacing

    @property
    def problem(self):
        """The stepper's."""
        return self.stepper.problem

    def increment(self, state, target):
        """As of the stepper; raises what that raises."""
        record = state.record if state.record is not None else Record.of(state)
        if record.period is not None:
            known = self._known(state, record, target)
            if known is not None:
                return known
            record = Record.of(state)
        done = self.stepper.increment(state, target)
        if done.state.v.size != record.branches[0].states[0][0].size:  # the problem has grown
            record = Record.of(done.state)
        else:
            record.add(done)
            if done.slips and all(slip.located for slip in done.slips):
                self._close(record, done.slips[-1])
        done.state.record = record
        return done

    def _close(self, record, slip):
        """Find out whether the state in which a slip landed was passed some sites before: if so, a period is known."""
        first, landed = record.branches[0].loads[0], slip.after
        same = LIMITS.same * self.problem.unit
        for sites in range(1, floor((slip.load - first + LIMITS.near) / self.spacing) + 1):
            period = sites * self.spacing
            home = landed.load - period
            branch = record.branch_at(max(home, first))
            if branch is None or len(branch.loads) < 2:
                continue
            v, _ = branch.state_at(home)
            if np.abs(v + period * self.problem.direction - landed.v).max() > same:
                continue
            place = record.branches.index(branch)
            if not all(b.end.located for b in record.branches[place:-1]):
                return
            start = max(0, bisect_left(branch.loads, home) - LIMITS.stencil)
            record.branches = [copy(b) for b in record.branches[place:-1]]
            record.branches[0] = replace(branch, loads=branch.loads[start:], states=branch.states[start:])
            record.period, record.home, record.end = period, home, slip.load
            return

    def _known(self, state, record, target):
        """The Increment to `target` from the record; None if that lacks it, or it proves to be another state."""
        turns = max(0, ceil((target - record.end) / record.period))
        shift, problem = turns * record.period, self.problem
        load = record.resting(target - shift)
        branch = record.branch_at(load)
        if branch is None:
            return None
        if load > target - shift:  # the surface does not rest before; else `target` stays as it is, to the last bit
            target = load + shift
        v, active = branch.state_at(load)
        guess = v + shift * problem.direction
        v = guess.copy()
        secants = state.secants or self.stepper.corrector.secants()
        active = self.stepper.corrector.settle(v, active, target, secants)
        moved = np.abs(v - guess).max()
        if active is None or not self._same(moved, branch, load):
            return None
        if moved > 0.0:  # interpolation did not meet the tolerance: the record takes the solution
            branch.add(load, v - shift * problem.direction, active)
        slips = tuple(self._slips(record, state.load, target))
        past = [(target, v)] if slips else [(target, v), *state.past[:4]]
        mode = state.mode
        if mode is not None and mode.safety is not record.safety:
            mode = replace(mode, safety=record.safety)
        moved = replace(state, load=target, v=v, active=active, past=past, secants=secants, mode=mode, record=record)
        moved.residual = self.stepper.corrector.worst
        return Increment(moved, slips, True)

    def _same(self, moved, branch, load):
        """Whether a state solved for, which moved so far (nm) from the interpolated one, is the same.

        Towards flutter a branch may bend sharply: as far as interpolation with fewer states differs is allowed for.
        """
        same = LIMITS.same * self.problem.unit
        if moved <= same:
            return True
        coarser = branch.state_at(load, LIMITS.stencil - 2)[0] - branch.state_at(load)[0]
        return bool(moved <= same + np.abs(coarser).max())

    def _slips(self, record, low, high):
        """The known Slips at loads above `low`, up to `high`."""
        for turns in range(ceil((low - record.end) / record.period), ceil((high - record.end) / record.period) + 1):
            shift = turns * record.period
            for branch in record.branches:
                if low < branch.end.load + shift <= high:
                    v = branch.end.v + shift * self.problem.direction
                    yield replace(branch.end, load=branch.end.load + shift, v=v)
