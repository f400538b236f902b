"""The quasi-static stepper: a branch is followed to its end, and the damped motion leads on from there."""

from dataclasses import replace

import numpy as np

from .branch import continue_branch
from .corrector import Corrector
from .onset import START
from .rest import Judge
from .slip import motion_to_rest, widened
from .state import Crowded, Increment, LimitPoint, NotConverged, Slip, State, slipped

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
            reached = self._judged(state) if state.unsure else state
            if isinstance(reached, State):
                reached = self._continued(reached, target)
            if isinstance(reached, LimitPoint):
                before, problem = state, self.problem
                state, sensitive = self._through(reached)
                if problem is not self.problem or self._ended(before, reached, state):
                    end = reached.load, reached.v, reached.active, reached.kind, reached.located
                    slips.append((problem, Slip(*end, state, sensitive)))
                if state.unsure or state.load < target:
                    continue
            else:
                state = reached
            wide = self._grown(state)
            if wide is None or state.load > target:
                return Increment(state, tuple(self._carried(*slip) for slip in slips))
            self._solve(wide[0])
            state = wide[1]
        raise NotConverged(f"more than {SLIPS} slips in one increment, residual {self.corrector.worst:.2g} nm")

    def _continued(self, state, target):
        """The State at load `target` on the branch of `state`, or the LimitPoint before it."""
        state.secants = state.secants or self.corrector.secants()
        self.corrector.begin(state)
        return continue_branch(self.corrector, self.judge, state, target)

    def _ended(self, before, end, after):
        """Whether the branch of the State `before` ended in the LimitPoint `end`, or was merely lost, and goes on."""
        return end.located or slipped(self.problem, before, end.load, after)

    def _judged(self, state):
        """The State itself, if it is stable under the load that takes over; else the LimitPoint from which it moves."""
        mode = self.judge.accept(self.problem, state.v, state.active)
        if mode.rests:
            return replace(state, unsure=False, mode=mode)
        kind = mode.kind if mode.hidden else "control"
        return LimitPoint(state.load, state.v, state.active, self._away(mode), kind, mode.hidden)

    def _away(self, mode):
        return mode.x * (START * self.problem.unit / np.abs(mode.x).max())

    def _grown(self, state):
        """(problem of more unknowns, the same State there) if such are needed, else None."""
        grown = self.problem.grown(state.v, state.active, state.load)
        return grown and (grown[0], State.at_rest(state.load, *grown[1:]))

    def _carried(self, problem, slip):
        """A Slip of `problem` in the unknowns of the present one, which may have grown from it."""
        while problem.size < self.problem.size:
            problem, v, active = problem.grown(slip.v, slip.active, slip.load, True)
            slip = replace(slip, v=v, active=active)
        return slip

    def _through(self, end):
        """The Landing of the motion from the end of a branch, on as many unknowns as it needs."""
        if end.hidden:  # the wave that grows there shows on all nodes only
            end = self._on_more(end)
            away = self._away(self.judge.rightmost(self.problem, end.v, end.active))
            end = replace(end, away=away)
        while True:
            try:
                state, sensitive = motion_to_rest(self.problem, self.judge, self.damping, end, self.closed, self.film)
                return replace(state, unsure=state.mode.hidden), sensitive
            except Crowded:
                end = self._on_more(end)

    def _on_more(self, end):
        """The same LimitPoint of a problem of more unknowns, which is solved from now on."""
        problem, end = widened(self.problem, end)
        self._solve(problem)
        return end

    def _solve(self, problem):
        """From now on solve another problem, grown from the last one."""
        self.problem, self.corrector = problem, Corrector(problem)
