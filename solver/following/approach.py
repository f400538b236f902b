"""The approach walked in long steps, from the undeformed surface or from a state that is known already."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..continuation.branch import SEARCH, continue_branch
from ..continuation.corrector import Corrector
from ..continuation.fold import fold_near
from ..continuation.landing import motion_to_rest
from ..continuation.onset import mixed
from ..continuation.rest import Judge
from ..continuation.state import PAST, End, NotConverged, Point, State
from ..continuation.trace import Branch, lagrange
from ..mechanics.equilibrium import Equilibrium

# A "unit" is the problem's `unit`.
FIRST, LONGEST, SHORTEST = 1.0, 2.0, 0.05  # units, steps of the load; shorter ones are left to `continue_branch`
STEP = 0.1  # units, step of the load of `continue_branch`, as a run's increment
OFF = 0.1  # units: a state farther from its extrapolation may lie beyond a jump, so that the step is repeated at half
CLOSE, CLOSER = 0.03, 0.01  # units: from a state nearer to it the next step is 1.4 times, or twice as long


def walk(
    problem: Equilibrium, judge: Judge, closed: float, state: State, target: float, expected: Sequence[End] = ()
) -> Iterator[State | End]:
    """Yields each State from `state` to load `target`, nm, and each End on the way, with the State after it.

    Every state is judged. closed: as of `motion.Motion`; expected: folds that may lie ahead. Raises NotConverged.
    """
    corrector = Corrector(problem)
    state, step = _begun(corrector, state), FIRST * problem.unit
    folds = [fold for end in expected if end.kind == "fold" and (fold := fold_near(problem, end, SEARCH))]
    while state.load < target:
        reached: State | End | None = None
        ahead = next((fold for fold in folds if state.load < fold.load < state.load + step), None)
        if ahead and ahead.load < target and (between := _between(corrector, judge, state, ahead)):
            yield between
            reached = ahead
        elif step > SHORTEST * problem.unit:
            reached, step = _stepped(corrector, judge, state, min(state.load + step, target), step)
            if reached is None:
                continue
        reached = reached or continue_branch(corrector, judge, state, min(state.load + STEP * problem.unit, target))
        if isinstance(reached, End):
            reached = motion_to_rest(problem, reached, judge, judge.damping, closed)
            yield reached
            state, step = _begun(corrector, rested(reached)), STEP * problem.unit
        else:
            state, step = reached, max(step, STEP * problem.unit)
            yield state


def _between(corrector, judge, state, fold):
    """The State half-way from `state` to a fold ahead; None where none lies near their interpolation: no one branch."""
    passed = [Point(*point) for point in state.past]
    branch = Branch((*passed[::-1], Point(fold.load, fold.v)), fold)
    guess = branch.at(fold.load - 0.25 * (fold.load - state.load))
    solution = corrector.solve(guess.v, guess.load, state.secants)
    if solution is None or np.abs(solution.v - guess.v).max() > OFF * corrector.problem.unit:
        return None
    mode = judge.accept(corrector.problem, solution.v, state.mode)
    return State.at_rest(guess.load, solution.v, residual=solution.residual) if mode.rests else None


def rested(reached: State | End) -> State:
    """The State that a `walk` has reached: that after an End."""
    state = reached.after if isinstance(reached, End) else reached
    assert state is not None  # `walk` yields no other End
    return state


def _begun(corrector, state):
    """The State, with the corrector prepared to go on from it."""
    corrector.begin(state)
    return state._replace(secants=state.secants or corrector.secants())


def _stepped(corrector, judge, state, target, step):
    """(the State at `target`, the next step, nm), by extrapolation; None where that does not foretell it."""
    problem, past = corrector.problem, [Point(*point) for point in state.past]
    if len(past) > 1:
        guess = mixed(lagrange([load for load, _ in past], target), past).v
    else:
        guess = state.v + (target - state.load) * problem.direction
    solution = corrector.solve(guess, target, state.secants)
    off = np.inf if solution is None else np.abs(solution.v - guess).max() / problem.unit
    mode = judge.accept(problem, solution.v, state.mode) if off < OFF else None
    if mode is None or not mode.rests:
        return None, 0.5 * step
    longer = 2.0 if off < CLOSER else 1.4 if off < CLOSE else 1.0
    more = {"secants": state.secants, "sharp": corrector.sharp, "mode": mode, "residual": solution.residual}
    reached = State(target, solution.v, [Point(target, solution.v), *past[: PAST - 1]], **more)
    return reached, min(longer * step, LONGEST * problem.unit)


def undeformed(problem: Equilibrium, load: float) -> State:
    """The State next to the undeformed surface at a load, nm; raises NotConverged where there is none."""
    solution = Corrector(problem).solve(problem.undeformed(load), load)
    if solution is None:
        raise NotConverged("there is no state apart where the approach begins")
    return State.at_rest(load, solution.v, residual=solution.residual)


def begun(branches: Sequence[Branch], load: float, size: int) -> list[Branch]:
    """The Branches of an approach up to `load`, nm; none where a state has another size."""
    passed = [branch for branch in branches if branch.start <= load]
    if not passed or passed[0].states[0].v.size != size:
        return []
    *before, last = passed
    return [*before, Branch(tuple(point for point in last.states if point.load <= load))]


def latest(branch: Branch) -> State:
    """The last State of a Branch, with those before it."""
    past: list[Any] = list(branch.states[: -PAST - 1 : -1])
    return State(past[0].load, past[0].v, past)
