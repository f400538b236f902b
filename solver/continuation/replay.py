"""A stepper for sliding that repeats itself: it moves known states on by lattice periods and verifies them."""

from math import ceil

import numpy as np

from .corrector import Corrector
from .problem import Problem
from .state import Increment, State
from .trace import OPTIONS, Trace, TraceOptions


class Replay:
    """A stepper around another, for a load that is U_x, over sites `spacing` nm apart.

    The residual of each state that is moved on is evaluated; a state that is not the one expected is solved for.
    """

    def __init__(self, stepper, spacing, options: TraceOptions = OPTIONS):
        self.stepper, self.spacing, self.options = stepper, spacing, options
        self._corrector = Corrector(stepper.problem)

    @property
    def problem(self) -> Problem:
        """The stepper's."""
        return self.stepper.problem

    def increment(self, state: State, target: float) -> Increment:
        """As of the stepper; raises what that raises."""
        trace = state.trace or Trace.of(state)
        if trace.period is not None:
            repeated = self._repeated(state, trace, target)
            if repeated is not None:
                return repeated
            trace = Trace.of(state)
        done = self.stepper.increment(state, target)
        trace = trace.extended(done)
        if done.slips and all(slip.located for slip in done.slips):
            trace = trace.closed(self.problem, self.spacing, self.options)
        return done._replace(state=done.state._replace(trace=trace))

    def _repeated(self, state, trace, target):
        """The Increment to `target` from the Trace; None if that lacks it, or it proves to be another state."""
        turns = max(0, ceil((target - trace.end) / trace.period))
        shift, problem = turns * trace.period, self.problem
        load = trace.stable_from(target - shift)
        branch = trace.branch_at(load)
        if branch is None:
            return None
        if load > target - shift:  # the surface does not rest before; else `target` stays as it is, to the last bit
            target = load + shift
        passed = branch.at(load, self.options.stencil)
        guess = passed.v + shift * problem.direction
        v = guess.copy()
        if self._corrector.problem is not problem:
            self._corrector = Corrector(problem)
        secants = self._corrector.secants()  # those of a state near a fold may lead to the branch beyond it
        solved = self._corrector.solve(v, target, secants)
        moved = np.abs(v - guess).max()
        if solved is None or not self._same(moved, branch, load):
            return None
        if moved > 0.0:  # interpolation did not meet the tolerance: the trace takes the solution
            trace = trace.added(branch, passed._replace(v=v - shift * problem.direction))
        slips = tuple(trace.slips(state.load, target, problem.direction))
        past = [(target, v)] if slips else [(target, v), *state.past[:4]]
        worst = self._corrector.worst
        return Increment(State(target, v, past, secants, state.sharp, state.mode, False, trace, worst), slips, True)

    def _same(self, moved, branch, load):
        """Whether a state solved for, which moved so far (nm) from the interpolated one, is the same.

        Towards flutter a branch may bend sharply: as far as interpolation with fewer states differs is allowed for.
        """
        same = self.options.same * self.problem.unit
        if moved <= same:
            return True
        coarser = branch.at(load, self.options.stencil - 2).v - branch.at(load, self.options.stencil).v
        return bool(moved <= same + np.abs(coarser).max())
