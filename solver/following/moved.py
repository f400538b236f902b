"""A skeleton's states, folds and branches moved to a changed problem; knows nothing of contacts.

The fold of a branch comes first, then the states before it, one by one. Each solve uses the secant pairs of those
before it.
"""

from dataclasses import replace

import numpy as np

from ..continuation.corrector import Corrector
from ..continuation.fold import FoldOptions, fold_near
from ..continuation.problem import Problem
from ..continuation.rest import Judge
from ..continuation.state import End, Point, State
from ..continuation.trace import Branch, lagrange

TOLERANCE = 1e-5  # nm, of residuals: the forces of followed runs are right to 1e-4
SURPRISE = 0.3  # units, a step of the arc: a state farther from its guess may lie on another branch
# A fold has a load as accurate as states, and a state that makes F_s right to 1e-5: at 3e-3 units, F_s of a weak fold
# was off by 1.3e-3. Looser solves save 4 % of the evaluations of a move.
FOLDS = FoldOptions(load=TOLERANCE, state=1e-4, accuracy=3e-2)
CHANGES = 3  # The change of a state is extrapolated from so many before it; 2 and 4 take as many evaluations
FIRST_MOVES = 1.5  # units, by which the first state of a branch without a fold may move and stay on it


class NotFollowed(Exception):
    """The run of the other scene does not continue that of the skeleton; the message gives the reason.

    Compute that run from its start. nearer: smaller changes of the parameters might lead there. evaluations: force
    evaluations of the attempt.
    """

    evaluations = 0

    def __init__(self, reason: str, nearer: bool = False) -> None:
        super().__init__(reason)
        self.nearer = nearer


class Solver:
    """Solves a `continuation.problem.Problem`; its failures are NotFollowed.

    Attributes: residual, nm, the largest of all solutions.
    """

    def __init__(self, problem: Problem, damping: float = 1.0, tolerance: float = TOLERANCE) -> None:
        """damping: of the motion, over critical; tolerance: of residuals, nm, unless the problem's is larger."""
        self.problem = problem = problem.solved_to(max(tolerance, problem.tolerance))
        self.corrector, self.damping = Corrector(problem), damping
        self.secants, self._begun, self.residual = self.corrector.secants(), False, 0.0

    def state(self, guess: np.ndarray, load: float, what: str, surprise: float = SURPRISE) -> np.ndarray:
        """v of the state at fixed load near a guess; raises NotFollowed beyond `surprise` units of it."""
        if not self._begun:
            self.corrector.begin(State.at_rest(load, guess))
            self._begun = True
        solution = self.corrector.solve(guess, load, self.secants)
        if solution is None:
            raise NotFollowed(f"the corrector fails at {what}", nearer=True)
        if np.abs(solution.v - guess).max() > surprise * self.problem.unit:
            raise NotFollowed(f"{what} lies on another branch", nearer=True)
        self._check(solution.v, solution.residual, what)
        return solution.v

    def fold(self, guess: End, what: str) -> End:
        """The fold next to a guess; raises NotFollowed where there is none."""
        fold = fold_near(self.problem, guess, FOLDS)
        if fold is None:
            raise NotFollowed(f"{what} is no longer a fold, or has moved too far", nearer=True)
        self._check(fold.v, fold.residual, what)
        return fold._replace(sensitive=guess.sensitive)  # where it landed was; `certify` tells whether it is

    def _check(self, v, residual, what):
        self.residual = max(self.residual, float(residual))
        # no fold shows where the uniform branch of a flat ends
        if self.problem.alike(v) and not Judge(self.damping).rightmost(self.problem, v).rests:
            raise NotFollowed(f"a wave grows at {what}")


def moved_folds(solver: Solver, old: tuple[Branch, ...]) -> list[End | None]:
    """The folds of the new branches from those of the old; each is expected to move as the one before."""
    folds: list[End | None] = []
    change = np.zeros(solver.problem.size)
    for k, branch in enumerate(old, 1):
        fold = branch.slip
        if fold is not None:
            new = solver.fold(fold._replace(v=fold.v + change, psi=None), f"the end of branch {k}")
            change, fold = new.v - fold.v, new
        folds.append(fold)
    return folds


def moved_branch(solver: Solver, old: Branch, start: float, end: float, fold: End | None, number: int) -> Branch:
    """The Branch `old` moved to the solver's problem, from load `start` to `end`, nm, where its fold is, or None."""
    what = f"a state of branch {number}"
    if not end > start:
        raise NotFollowed(f"branch {number} has no states left", nearer=True)
    loads = start + (end - start) * ((old.loads - old.start) / (old.end - old.start))
    if fold is None:
        first = Point(start, solver.state(old.states[0].v, start, what, FIRST_MOVES))
        states = _solved(solver, old.states, loads.tolist(), first, what)
    else:
        first = Point(fold.load, fold.v)
        states = _solved(solver, old.states[::-1], loads.tolist()[::-1], first, what)[::-1]
    return replace(old, states=tuple(states), slip=fold)


def _solved(solver, old, loads, first, what):
    """The states at these loads, from those of the old branch and extrapolated changes; the `first` one is solved."""
    states, changes = [first], [first.v - old[0].v]
    for i in range(1, len(old)):
        near = changes[-CHANGES:]
        change = lagrange(range(-len(near), 0), 0) @ np.asarray(near)
        surprise = SURPRISE
        if first.load < loads[-1]:  # to no fold: smooth sliding may jerk, between other states than before
            steps = np.diff([state.v for state in old[i - 1 : i + 2]], axis=0)
            surprise = max(SURPRISE, np.abs(steps).max() / solver.problem.unit)
        v = solver.state(old[i].v + change, loads[i], what, surprise)
        states.append(Point(loads[i], v))
        changes.append(v - old[i].v)
    return states
