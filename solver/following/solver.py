"""Solves one problem for states and folds; each solve uses the secant pairs of those before it."""

import numpy as np

from ..continuation.corrector import Corrector
from ..continuation.fold import Fold, FoldOptions, fold_near
from ..continuation.problem import Problem
from ..continuation.rest import Judge
from ..continuation.state import Crowded as HiddenWave
from ..continuation.state import State
from .branch import TOLERANCE, Crowded, NotFollowed

FEW = 3  # unknowns of one node that represents all; it cannot represent waves
SURPRISE = 0.3  # units from its guess, beyond which a state may lie on another branch: as long as a step of the arc
# The load of a fold to the tolerance of states; its state such that F_s is right to 1e-5 (at 3e-3 units a weak one was
# off by 1.3e-3). Looser solves save 4 % of a move's evaluations. Nodes may cross the window's edge three times.
FOLDS = FoldOptions(load=TOLERANCE, state=1e-4, accuracy=3e-2, window=3)


class Solver:
    """Solves a `continuation.problem.Problem`; its failures are NotFollowed.

    Attributes: moving, how many unknowns move on with the load, which come first; residual, nm, the largest of all
    solutions.
    """

    def __init__(self, problem: Problem, damping: float = 1.0, tolerance: float = TOLERANCE) -> None:
        """damping: of the motion, over critical; tolerance: of residuals, nm, unless the problem's is larger."""
        problem.tolerance = max(tolerance, problem.tolerance)
        self.problem, self.corrector, self.damping = problem, Corrector(problem), damping
        self.moving = int(np.count_nonzero(problem.direction))
        self.secants, self._begun, self.residual = self.corrector.secants(), False, 0.0

    def state(
        self, guess: np.ndarray, active: np.ndarray, load: float, what: str, surprise: float = SURPRISE
    ) -> tuple[np.ndarray, np.ndarray]:
        """(v, active) of the state at fixed load near a guess; raises NotFollowed beyond `surprise` units of it."""
        if not self._begun:
            self.corrector.begin(State.at_rest(load, guess, active))
            self._begun = True
        v = guess.copy()
        settled = self.corrector.settle(v, self.problem.active(v, load, active), load, self.secants)
        if settled is None:
            raise NotFollowed(f"the corrector fails at {what}", nearer=True)
        if np.abs(v - guess).max() > surprise * self.problem.unit:
            raise NotFollowed(f"{what} lies on another branch", nearer=True)
        self._check(v, settled, load, self.corrector.worst, what)
        return v, settled

    def fold(self, guess: Fold, what: str) -> Fold:
        """The Fold next to a guess; raises NotFollowed where there is none."""
        fold = fold_near(self.problem, guess, FOLDS)
        if fold is None:
            raise NotFollowed(f"{what} is no longer a fold, or has moved too far", nearer=True)
        self._check(fold.v, fold.active, fold.load, fold.residual, what)
        return fold

    def _check(self, v, active, load, residual, what):
        problem, self.residual = self.problem, max(self.residual, float(residual))
        if problem.crowded(v, active, load):
            raise Crowded(f"{what} needs a wider patch")
        if problem.size <= FEW:
            try:
                Judge(self.damping).rightmost(problem, v, active)
            except HiddenWave:
                raise NotFollowed(f"a wave grows at {what}") from None
