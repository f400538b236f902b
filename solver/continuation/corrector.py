"""From a guess to the equilibrium at fixed load, or at fixed arc length with the load solved for.

Anderson steps solve it. Where they fail, the inverse of a tangent nearby preconditions them, so that a few suffice.
Iterations solve with that tangent, and keep their products.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np

from .anderson import REGULARISATION, Secants
from .inverse import Inverse
from .vectors import advance, dot, solve

ANY = np.empty(0)  # in place of a chord, for a fixed load

MEMORY = 20  # secant pairs; 40 save 3 % of the evaluations, but double the algebra of a step
LONGEST = 0.15  # units of the problem, largest change of an unknown in one step; longer ones land on other branches


class Solution(NamedTuple):
    """An equilibrium that was solved for."""

    v: np.ndarray  # (size,)
    load: float  # nm
    residual: float  # nm


class Corrector:
    """Solves one problem; between calls it keeps the inverse in use, and scratch.

    sharp: v (size,) of the equilibrium whose inverse tangent preconditions, or None. A State keeps it for `begin`.
    """

    def __init__(self, problem, twice=True):
        """twice: whether what Anderson steps do not solve is tried again with an inverse, as `solve` says."""
        self.problem, self.twice = problem, twice
        self.sharp = None
        self._smooth = None  # the inverse in use, or None: it treats the residual outside the span of the secant pairs
        self._origin: np.ndarray | None = None  # v of the equilibrium found last
        self._r, self._room = np.empty(problem.size), np.empty((4, problem.size))

    def secants(self) -> Secants:
        """Room for secant pairs of this problem."""
        return Secants(MEMORY, self.problem.size)

    def begin(self, state) -> None:
        """Prepare to go on from a State, with the inverse by which it was reached, if any."""
        self._origin = state.v
        self._use(state.sharp)

    def _use(self, sharp):
        """From now on use the inverse of the tangent at the equilibrium `sharp`, or none."""
        if sharp is None:
            self.sharp = self._smooth = None
        elif not self._uses(sharp):
            # the secant pairs correct an error of 0.3 at less cost
            self.sharp, self._smooth = sharp, self._iterations(sharp, 0.3)

    def _uses(self, sharp):
        return self.sharp is not None and np.array_equal(self.sharp, sharp)

    def direction(self, state, *accuracy) -> np.ndarray:
        """dv/ds of the branch at a State, (size,), to `inverse.ACCURACY` or as given; large near a fold."""
        return self._iterations(state.v, *accuracy)(self.problem.direction)

    def _iterations(self, v, *accuracy):
        """The inverse of -dR/dv by iterations."""
        inverse = Inverse(self.problem.linearised(v).tangent, self.problem.size)
        return lambda r: -inverse.solve(r, *accuracy)

    def solve(self, guess, s, secants=None, chord=None, arc=0.0) -> Solution | None:
        """The Solution next to a guess (size,) at fixed load s, nm, or None.

        With a chord, the load changes so that <chord, v> = arc, nm. If Anderson steps fail, a second attempt is
        preconditioned by the inverse tangent at the equilibrium found last. Later solves keep that preconditioner. The
        secant pairs of a failed attempt are dropped. Without any, each attempt begins with none.
        """
        self._origin = guess.copy() if self._origin is None else self._origin
        while True:
            solution = self._anderson(guess.copy(), s, secants, chord, arc)
            if solution is not None:
                self._origin = solution.v
                return solution
            if secants is not None:
                secants.forget()
            if not self.twice or self._uses(self._origin):
                return None
            self._use(self._origin)

    def _anderson(self, v, s, secants, chord, arc):
        """One attempt of `solve`, which changes v in place."""
        problem, r, direction = self.problem, self._r, self.problem.direction
        # 100 Anderson steps reached no more equilibria on 13 scenes of the slider box; with an inverse 2 to 10 suffice
        left = 60 if self.sharp is None else 15
        worst = problem.residual(v, s, r)
        if self._smooth is None and not worst <= problem.tolerance and (compiled := problem.compiled(s)):
            pairs = self.secants() if secants is None else secants
            worst, change = self._compiled(*compiled, v, worst, left, pairs, chord, arc)
            return Solution(v, s + change, worst) if worst <= problem.tolerance else None
        while not worst <= problem.tolerance:  # nan neither is nor becomes a solution
            if left == 0 or not isfinite(worst):
                return None
            secants = self.secants() if secants is None else secants
            v_before, r_before = v.copy(), r.copy()
            move, change = secants.move(r, self._smooth), 0.0
            if chord is not None:
                # v must change by move + change * response when the load does by change: chosen to stay on the arc
                response = secants.move(direction, self._smooth)
                slope = dot(chord, response)
                change = (arc - dot(chord, v) - dot(chord, move)) / slope if slope != 0.0 else 0.0
                move += change * response
            change *= advance(v, move, LONGEST * problem.unit)
            worst = problem.residual(v, s, r)
            secants.push(v, r, v_before, r_before)
            if chord is not None:
                s += change
                r += change * direction
                worst = float(np.abs(r).max())
            left -= 1
        return Solution(v, s, worst)

    def _compiled(self, function, context, v, worst, most, secants, chord, arc):
        """(largest residual, change of the load) after the steps of `_anderson` in one compiled loop, in place."""
        problem, pairs = self.problem, (secants.sums, secants.dr, secants.gram)
        bounds = problem.tolerance, most, LONGEST * problem.unit
        algebra = pairs, secants.place, REGULARISATION, secants.work
        path = ANY if chord is None else chord, arc, problem.direction
        worst, change, steps = solve(function, context, v, self._r, worst, *bounds, *algebra, *path, self._room)
        problem.evaluated(steps)
        return worst, change
