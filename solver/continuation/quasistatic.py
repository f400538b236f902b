"""The quasi-static stepper: a branch is followed to its end, and the damped motion leads on from there."""

from dataclasses import dataclass, replace

import numpy as np

from .branch import LIMITS as BRANCH
from .branch import continue_branch
from .corrector import Corrector
from .slip import motion_to_rest
from .rest import Judge
from .state import Increment, LimitPoint, NotConverged, Slip, State


@dataclass(frozen=True)
class Limits:
    """Of an increment."""

    slips: int = 100  # at most; soft layers drawn into contact make some ten
    moved: float = 0.5  # units of the problem, and twice the load's rest: a lost state that moved less has not slipped


LIMITS = Limits()


class QuasiStatic:
    """Advances States of one problem along its load; holds no state between calls but scratch.

    Attributes: problem, replaced by a grown one where the states need it; film: `slip.motion_to_rest`'s, None at first.
    """

    def __init__(self, problem, damping, closed):
        """damping: of the motion, over critical; closed: as of `motion.Motion`."""
        self.problem, self.damping, self.closed = problem, damping, closed
        self.judge, self.corrector, self.film = Judge(damping), Corrector(problem), None

    def increment(self, state, target):
        """The Increment from `state` to load `target`; raises NotConverged. May change the state's secant pairs."""
        slips = []
        while True:
            if state.unsure:
                state = self._released(state)
            state.secants = state.secants or self.corrector.secants()
            self.corrector.begin(state)
            found = continue_branch(self.corrector, self.judge, state, target)
            if isinstance(found, State):
                hidden = found.mode.hidden
                if not (hidden or self.problem.crowded(found.v, found.active, target)):
                    return Increment(found, self.corrector.worst, tuple(slips))
                state = replace(self._grown(state), unsure=hidden)
                continue
            place = self.problem.place
            landed = self._through(found)
            self._report(slips, state, found, landed, place)
            if len(slips) > LIMITS.slips:
                residual = f"residual {self.corrector.worst:.2g} nm"
                raise NotConverged(f"more than {LIMITS.slips} slips in one increment, {residual}")
            state = landed
            hidden = state.mode.hidden
            arrived = state.load == target and not (hidden or self.problem.crowded(state.v, state.active, target))
            if state.load > target or arrived:
                residual = self.problem.residual(state.v, state.active, state.load, np.empty(state.v.size))
                return Increment(state, residual, tuple(slips))

    def _released(self, state):
        """The state itself, if it rests under the loading to come; else the State in which the motion from it rests."""
        mode = self.judge.accept(self.problem, (state.load, state.v, state.active))
        if mode.rests:
            return replace(state, unsure=False, mode=mode)
        away = self.problem.oriented(mode.x)
        away *= BRANCH.start * self.problem.unit / np.abs(away).max()
        return self._through(LimitPoint(state.load, state.v, state.active, away, mode.kind))

    def _grown(self, state):
        """The same state in a problem of more unknowns, which takes the place of the present one."""
        self.problem, v, active = self.problem.grown(state.v, state.active, state.load)
        self.corrector = Corrector(self.problem)
        wide = State.at_rest(state.load, v, active)
        wide.unsure = state.unsure
        return wide

    def _through(self, end):
        """The State in which the motion from the end of a branch comes to rest."""
        problem, state = motion_to_rest(self.problem, self.judge, self.damping, end, self.closed, self.film)
        if problem is not self.problem:
            self.problem, self.corrector = problem, Corrector(problem)
        return state

    def _report(self, slips, before, end, landed, place):
        """Add the Slip from the end of a branch to the state landed in, unless the branch was lost and goes on."""
        if not end.located and landed.v.size == before.v.size:
            moved = np.abs(landed.v - before.v).max()
            if moved < LIMITS.moved * self.problem.unit + 2.0 * abs(end.load - before.load):
                return
        slips.append(Slip(end.load, end.v, end.active, end.kind, end.located, landed, place))
