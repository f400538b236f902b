"""The quasi-static stepper: a branch is followed to its end, and the damped motion leads on from there."""

from dataclasses import replace

import numpy as np

from .branch import LIMITS as BRANCH
from .branch import continue_branch
from .corrector import Corrector
from .rest import Judge
from .slip import motion_to_rest
from .state import Increment, LimitPoint, NotConverged, Slip, State, slipped

SLIPS = 100  # of an increment, at most; soft layers drawn into contact make some ten


class QuasiStatic:
    """Advances States of one problem along its load; holds no state between calls but scratch.

    Attributes: problem, replaced by a grown one where the states need it; film: `slip.motion_to_rest`'s, None at first.
    """

    def __init__(self, problem, damping, closed):
        """damping: of the motion, over critical; closed: as of `motion.Motion`."""
        self.problem, self.damping, self.closed = problem, damping, closed
        self.judge, self.corrector, self.film = Judge(damping), Corrector(problem), None

    def increment(self, state, target):
        """The Increment from `state` to load `target`, nm; raises NotConverged. May change the state's secant pairs."""
        slips = []  # [(the problem it began in, Slip)]
        while len(slips) <= SLIPS:
            if state.unsure:
                state = self._released(state)
            state.secants = state.secants or self.corrector.secants()
            self.corrector.begin(state)
            found = continue_branch(self.corrector, self.judge, state, target)
            if isinstance(found, LimitPoint):
                before, problem = state, self.problem
                state = self._through(found)
                if problem is not self.problem or self._ended(before, found, state):
                    slip = Slip(found.load, found.v, found.active, found.kind, found.located, state)
                    slips.append((problem, slip))
                if state.load < target:
                    continue
            else:
                state = found
            wide = self._grown(state)
            if wide is None or state.load > target:
                return Increment(state, tuple(self._carried(*slip) for slip in slips))
            self.problem, state = wide
            self.corrector = Corrector(self.problem)
        raise NotConverged(f"more than {SLIPS} slips in one increment, residual {self.corrector.worst:.2g} nm")

    def _ended(self, before, end, after):
        """Whether the branch of the State `before` ended in the LimitPoint `end`, or was merely lost, and goes on."""
        return end.located or slipped(self.problem, before, end.load, after)

    def _released(self, state):
        """The state itself, if it rests under the loading to come; else the State in which the motion from it rests."""
        mode = self.judge.accept(self.problem, state.v, state.active)
        if mode.rests:
            return replace(state, unsure=False, mode=mode)
        away = mode.x * (BRANCH.start * self.problem.unit / np.abs(mode.x).max())
        return self._through(LimitPoint(state.load, state.v, state.active, away, mode.kind))

    def _grown(self, state):
        """(problem of more unknowns, the same State there) if such are needed, else None."""
        hidden = state.mode.hidden
        grown = self.problem.grown(state.v, state.active, state.load, hidden)
        return grown and (grown[0], replace(State.at_rest(state.load, *grown[1:]), unsure=hidden))

    def _carried(self, problem, slip):
        """A Slip of `problem` in the unknowns of the present one, which may have grown from it."""
        while problem.size < self.problem.size:
            problem, v, active = problem.grown(slip.v, slip.active, slip.load, True)
            slip = replace(slip, v=v, active=active)
        return slip

    def _through(self, end):
        """The State in which the motion from the end of a branch comes to rest."""
        problem, state = motion_to_rest(self.problem, self.judge, self.damping, end, self.closed, self.film)
        if problem is not self.problem:
            self.problem, self.corrector = problem, Corrector(problem)
        return state
