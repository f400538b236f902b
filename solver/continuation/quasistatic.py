"""The quasi-static stepper continues a branch to its end, and lets the damped motion lead on from there."""

import numpy as np

from .branch import continue_branch
from .corrector import Corrector
from .landing import motion_to_rest
from .rest import OPTIONS as REST
from .rest import Judge
from .state import Crowded, End, Increment, NotConverged, State, slipped

SLIPS = 100  # most slips of an increment; soft layers that jump into contact make some ten


class QuasiStatic:
    """Advances States of one problem along its load; keeps only scratch between calls.

    Attributes: problem, replaced by one of more unknowns where the states need it.
    """

    def __init__(self, problem, damping, closed, rest=REST):
        """damping: over critical; closed: as of `motion.Motion`; rest: RestOptions."""
        self.problem, self.damping, self.closed = problem, damping, closed
        self.judge, self.corrector = Judge(damping, rest), Corrector(problem)

    def increment(self, state, target) -> Increment:
        """The Increment from `state` to load `target`, nm; raises NotConverged."""
        while True:
            try:
                return self._increment(state, target)
            except Crowded:
                self.problem, state = state.on_wider(self.problem)
                self.corrector = Corrector(self.problem)

    def _increment(self, state, target):
        """The same on the present problem; raises Crowded."""
        slips: list[End] = []
        while len(slips) <= SLIPS:
            reached = self._judged(state) if state.unsure else state
            if isinstance(reached, State):
                reached = self._continued(reached, target)
            if isinstance(reached, End):
                before = state
                state, sensitive = motion_to_rest(self.problem, reached, self.judge, self.damping, self.closed)
                if reached.located or slipped(self.problem, before, reached.load, state):
                    slips.append(reached._replace(after=state, sensitive=sensitive))
                if state.load < target:
                    continue
            else:
                state = reached
            if self.problem.crowded(state.v, state.active, state.load):
                raise Crowded("the state needs a wider patch")
            return Increment(state, tuple(slips))
        raise NotConverged(f"more than {SLIPS} slips in one increment, residual {self.corrector.worst:.2g} nm")

    def _continued(self, state, target):
        """The State at load `target` on the branch of `state`, or the End before it."""
        secants = state.secants.copy() if state.secants else self.corrector.secants()  # solving adds to them
        state = state._replace(secants=secants)
        self.corrector.begin(state)
        return continue_branch(self.corrector, self.judge, state, target)

    def _judged(self, state):
        """The State itself, if it is stable under the load that takes over; else the End where it leaves."""
        mode = self.judge.accept(self.problem, state.v, state.active)
        if mode.rests:
            return state._replace(unsure=False, mode=mode)
        return End(state.load, state.v, state.active, mode.x / np.abs(mode.x).max(), "control")
