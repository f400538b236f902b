"""The quasi-static stepper continues a branch to its end, and lets the damped motion lead on from there."""

from typing import NamedTuple

import numpy as np

from .branch import continue_branch
from .corrector import Corrector
from .landing import motion_to_rest, widened
from .onset import START
from .problem import Problem
from .rest import Judge
from .state import Crowded, End, Increment, NotConverged, State, slipped

SLIPS = 100  # most slips of an increment; soft layers that jump into contact make some ten


class Ended(NamedTuple):
    """The End of a branch, and the problem whose unknowns it is in."""

    problem: Problem
    slip: End


class QuasiStatic:
    """Advances States of one problem along its load; keeps only scratch between calls.

    Attributes: problem, replaced by one of more unknowns where the states need it.
    """

    def __init__(self, problem, damping, closed, filmed=False):
        """damping: over critical; closed: as of `motion.Motion`; filmed: keep `State.film` of slips."""
        self.problem, self.damping, self.closed, self.filmed = problem, damping, closed, filmed
        self.judge, self.corrector = Judge(damping), Corrector(problem)

    def increment(self, state, target) -> Increment:
        """The Increment from `state` to load `target`, nm; raises NotConverged."""
        slips: list[Ended] = []
        while len(slips) <= SLIPS:
            reached = self._judged(state) if state.unsure else state
            if isinstance(reached, State):
                reached = self._continued(reached, target)
            if isinstance(reached, End):
                before, problem = state, self.problem
                state, sensitive = self._through(reached)
                if problem is not self.problem or self._ended(before, reached, state):
                    slips.append(Ended(problem, reached._replace(away=None, after=state, sensitive=sensitive)))
                if state.unsure or state.load < target:
                    continue
            else:
                state = reached
            wide = self._grown(state)
            if wide is None or state.load > target:
                return Increment(state, tuple(self._in_present_unknowns(*ended) for ended in slips))
            self._solve(wide[0])
            state = wide[1]
        raise NotConverged(f"more than {SLIPS} slips in one increment, residual {self.corrector.worst:.2g} nm")

    def _continued(self, state, target):
        """The State at load `target` on the branch of `state`, or the End before it."""
        secants = state.secants.copy() if state.secants else self.corrector.secants()  # solving adds to them
        state = state._replace(secants=secants)
        self.corrector.begin(state)
        return continue_branch(self.corrector, self.judge, state, target)

    def _ended(self, before, end, after):
        """Whether the branch of the State `before` ended in the End; a lost one may go on."""
        return end.located or slipped(self.problem, before, end.load, after)

    def _judged(self, state):
        """The State itself, if it is stable under the load that takes over; else the End where it leaves."""
        mode = self.judge.accept(self.problem, state.v, state.active)
        if mode.rests:
            return state._replace(unsure=False, mode=mode)
        kind = mode.kind if mode.hidden else "control"
        return End(state.load, state.v, state.active, self._away(mode), kind, mode.hidden)

    def _away(self, mode):
        return mode.x * (START * self.problem.unit / np.abs(mode.x).max())

    def _grown(self, state):
        """(problem of more unknowns, the same State of it) if the state needs more, else None."""
        grown = self.problem.grown(state.v, state.active, state.load)
        return grown and (grown[0], State.at_rest(state.load, *grown[1:]))

    def _in_present_unknowns(self, problem, slip):
        """An End of `problem` in the unknowns of the present one, which may have more."""
        while problem.size < self.problem.size:
            problem, v, active = problem.grown(slip.v, slip.active, slip.load, True)
            slip = slip._replace(v=v, active=active)
        return slip

    def _through(self, end):
        """The Landing of the transient from the end of a branch, with as many unknowns as it needs."""
        if end.hidden:  # only all nodes show the wave that grows there
            end = self._on_more(end)
            away = self._away(self.judge.rightmost(self.problem, end.v, end.active))
            end = end._replace(away=away)
        while True:
            try:
                how = self.judge, self.damping, self.closed, self.filmed
                state, sensitive = motion_to_rest(self.problem, end, *how)
                return state._replace(unsure=state.mode.hidden), sensitive
            except Crowded:
                end = self._on_more(end)

    def _on_more(self, end):
        """Solve a problem of more unknowns from now on; the same End of it."""
        problem, end = widened(self.problem, end)
        self._solve(problem)
        return end

    def _solve(self, problem):
        """Solve another problem from now on."""
        self.problem, self.corrector = problem, Corrector(problem)
