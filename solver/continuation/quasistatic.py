"""The quasi-static stepper continues a branch to its end, and lets the damped motion lead on from there."""

import numpy as np

from .branch import continue_branch
from .corrector import Corrector
from .landing import motion_to_rest
from .rest import Judge
from .state import End, Increment, NotConverged, State, slipped


class QuasiStatic:
    """Advances States of one `problem` along its load; keeps only scratch between calls."""

    def __init__(self, problem, damping, closed, far: float | None = None):
        """damping: over critical; closed: as of `motion.Motion`; far: as of `rest.Judge`."""
        self.problem, self.damping, self.closed = problem, damping, closed
        self.judge, self.corrector = Judge(damping, far), Corrector(problem)

    def increment(self, state, target) -> Increment:
        """The Increment from `state` to load `target`, nm; raises NotConverged."""
        slips = list[End]()
        while len(slips) <= 100:  # soft layers that jump into contact make some ten
            reached = self._judged(state) if state.unsure else state
            if isinstance(reached, State):
                reached = self._continued(reached, target)
            if isinstance(reached, End):
                before = state
                how = self.judge, self.damping, self.closed, state.undecided
                slip = motion_to_rest(self.problem, reached, *how)
                assert slip.after is not None  # the motion has come to rest there
                state = slip.after._replace(undecided=state.undecided or slip.sensitive)
                if reached.located or slipped(self.problem, before, reached.load, state):
                    slips.append(slip)
                if state.load < target:
                    continue
            else:
                state = reached
            return Increment(state, tuple(slips))
        raise NotConverged(f"more than 100 slips in one increment, residual {state.residual:.2g} nm")

    def _continued(self, state, target):
        """The State at load `target` on the branch of `state`, or the End before it."""
        secants = state.secants.copy() if state.secants else self.corrector.secants()  # solving adds to them
        state = state._replace(secants=secants)
        self.corrector.begin(state)
        return continue_branch(self.corrector, self.judge, state, target)

    def _judged(self, state):
        """The State itself, if it is stable under the load that takes over; else the End where it leaves."""
        mode = self.judge.accept(self.problem, state.v)
        if mode.rests:
            return state._replace(unsure=False, mode=mode)
        return End(state.load, state.v, mode.x / np.abs(mode.x).max(), "control", growth=mode.growth)
