"""Sliding that repeats itself: known states are moved on by lattice periods and verified, in place of an increment."""

from math import ceil

import numpy as np

from .corrector import Corrector
from .problem import Stepper
from .state import PAST, Increment, Point, State
from .trace import FEWEST_STATES, SAME_STATE, STENCIL, Branch, Trace


def advanced(
    stepper: Stepper, state: State, target: float, trace: Trace, spacing: float | None
) -> tuple[Increment, Trace]:
    """The Increment from `state` to load `target`, nm, and the Trace with what it passed; raises what the stepper does.

    spacing: of the sites along the load, nm; None: repeat no states, and keep nothing but the ends passed, as `jumps`.
    The residual of each state that is moved on is evaluated; a state that is not the one expected is solved for.
    """
    # FEWEST_STATES describe a short branch to a slip, which is nearly straight, but not a period of smooth sliding
    smooth = trace.branches[0].periodic
    if spacing is not None and trace.period and not (smooth and len(trace.branches[0].states) <= FEWEST_STATES):
        repeated = _repeated(stepper.problem, state, target, trace)
        if repeated is not None:
            return repeated
        if not smooth:
            trace = Trace.of(state, trace.jumps)
    done = stepper.increment(state, target)
    if spacing is None:
        ends = (slip._replace(after=None) for slip in done.slips)
        return done, Trace.of(done.state, (*trace.jumps, *ends))
    if trace.period and not done.slips:  # smooth sliding, where states are too few or the branch is too steep
        return done, _with_state(stepper.problem, trace, done.state)
    if trace.period:
        trace = Trace.of(state, trace.jumps)
    # replayed states that are interpolated that well need no solve
    trace = trace.extended(done, 0.5 * stepper.problem.tolerance)
    landed = bool(done.slips) and all(slip.located for slip in done.slips)
    closes = landed or len(trace.branches) == 1
    return done, trace.closed(stepper.problem, spacing) if closes else trace


def _with_state(problem, trace, state):
    """The Trace of smooth sliding with a State that was solved for, moved back by whole periods."""
    shift = max(0, ceil((state.load - trace.end) / trace.period)) * trace.period
    return trace.added(trace.branches[0], Point(state.load - shift, state.v - shift * problem.direction))


def _repeated(problem, state, target, trace):
    """(the Increment to `target`, the Trace); None if that lacks the state, or it proves to be another one."""
    turns = max(0, ceil((target - trace.end) / trace.period))
    shift = turns * trace.period
    load = trace.stable_from(min(target - shift, trace.end))  # rounding may lead beyond the end
    branch = trace.branch_at(load)
    if branch is None:
        return None
    if load > target - shift:  # the surface does not rest before; else `target` stays as it is, to the last bit
        target = load + shift
    passed = branch.at(load)
    guess = passed.v + shift * problem.direction
    # secant pairs of a state near a fold may lead to the branch beyond it, so that none are kept
    solution = Corrector(problem).solve(guess, target)
    if solution is None or not _same(problem, guess, solution.v, branch, load):
        return None
    v = solution.v
    if not np.array_equal(v, guess):  # interpolation did not meet the tolerance: the trace takes the solution
        trace = trace.added(branch, passed._replace(v=v - shift * problem.direction))
    slips = trace.slips_between(state.load, target, problem.direction)
    past = [(target, v)] if slips else [(target, v), *state.past[: PAST - 1]]
    reached = State(target, v, past, None, state.sharp, None, False, solution.residual, state.undecided)
    return Increment(reached, slips, True), trace


def _same(problem, guess, v, branch: Branch, load):
    """Whether v, solved for from the interpolated `guess`, is that state, and not one of another branch.

    Towards flutter a branch bends sharply, so v may differ by the estimated error of the interpolation, too.
    """
    same, off = SAME_STATE * problem.unit, np.abs(v - guess).max()
    if off <= same:
        return True
    coarser = branch.at(load, STENCIL - 2).v - branch.at(load).v
    return bool(off <= same + np.abs(coarser).max())
