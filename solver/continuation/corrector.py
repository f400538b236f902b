"""From a guess to the equilibrium at fixed load, or at fixed arc length with the load solved for.

Anderson steps as a rule; where they fail, the same steps on top of the inverse of a tangent nearby, which then need
but a few: formed by the problem, or where that is too dear by iterations whose products are kept.
"""

from dataclasses import dataclass

import numpy as np

from .anderson import Secants, advance, dot
from .inverse import Inverse


@dataclass(frozen=True)
class Limits:
    """Of the corrector; lengths in units of the problem's `unit`.

    memory: secant pairs; with fewer, soft layers need more evaluations, with more, each takes longer than it saves.
    longest: of one step of any unknown; longer ones land on other branches.
    runaway: growth of the residual at which the steps have failed. sharp_steps: with an inverse, 2 to 10 are needed
    where there is an equilibrium, and where there is none they lead nowhere. iterated: accuracy of an inverse that is
    not formed; secants do the rest, and a better one takes longer.
    """

    memory: int = 40
    longest: float = 0.15
    runaway: float = 1e3
    sharp_steps: int = 15
    iterated: float = 0.3


LIMITS = Limits()


class Corrector:
    """Solves one problem; holds no state between calls but scratch, and `steps`, those of the last solution."""

    def __init__(self, problem):
        self.problem = problem
        self.smooth = None  # what Anderson steps do to the part of the residual that the pairs do not know
        self.steps, self.worst = 0, np.inf
        self._r = np.empty(problem.size)
        self.sharp = None  # (v, active) where the inverse at hand was formed
        self._origin = None  # (v, active) of the equilibrium found last
        self._iterated = None, None  # v, and the iterations that invert the tangent there

    def secants(self):
        """Room for secant pairs of this problem."""
        return Secants(LIMITS.memory, self.problem.size)

    @property
    def inverse(self):
        """The formed inverse of a tangent that solves start with, or None: iterations would serve no others."""
        return self.smooth if self.sharp and self.sharp[0] is not self._iterated[0] else None

    def residual(self, v, active, s):
        """Largest magnitude of R."""
        return self.problem.residual(v, active, s, self._r)

    def settle(self, v, active, s, secants, most):
        """Solve for v, in place, with the set of active nodes that it implies; that set, or None if that fails.

        Nodes that crossed the edge of the window are let in or out and the solve repeated; each node may change once,
        so that this ends (where a node's entry pushes it out again, no set is consistent).
        """
        settled, steps = None, 0
        while True:
            if not self.solve(v, active, s, secants, most):
                return None
            steps += self.steps
            again = self.problem.admitted(v, active, settled)
            if again is active:
                self.steps = steps
                return active
            changed = again != active
            settled = changed if settled is None else settled | changed
            active = again

    def solve(self, v, active, s, secants, most):
        """Solve for v, in place, at fixed load, by so many Anderson steps at most; whether that succeeded."""
        return self._solved(v, active, s, secants, most, self._anderson) is not None

    def begin(self, state):
        """Get ready to go on from a State, with the inverse that helped to reach it, if one did."""
        self.sharp, self._origin = state.sharp, (state.v, state.active)
        self.smooth = self._inverse(*self.sharp) if self.sharp else self.problem.smoother(*self._origin)

    def direction(self, state):
        """dv/ds of the branch at a State, (size,), to `inverse.ACCURACY`; large near a fold."""
        return -self._iterations(state.v, state.active).solve(self.problem.direction)

    def _iterations(self, v, active):
        tangent, smooth = self.problem.tangent(v, active), self.problem.smoother(v, active)
        return Inverse(self.problem.size).of_tangent(tangent, smooth, None)

    def _inverse(self, v, active):
        """The inverse of -dR/dv at an equilibrium, or a function close to it."""
        formed = self.problem.inverse(v, active)
        if formed is not None:
            return formed
        if self._iterated[0] is not v:
            self._iterated = v, self._iterations(v, active)
        return lambda r: -self._iterated[1].solve(r, LIMITS.iterated)

    def _solved(self, v, active, s, secants, most, steps, *arc):
        """The load at which v, changed in place, solves, or None: by `steps`, where these fail with an inverse.

        That is the one at the equilibrium found last, unless it was already.
        """
        guess, known = v.copy(), secants.copy()
        self._origin = self._origin or (guess, active)
        while True:
            found = steps(v, active, s, secants, LIMITS.sharp_steps if self.sharp else most, *arc)
            if found is not None:
                self._origin = v.copy(), active
                return found
            v[:] = guess
            secants.restore(known)
            if self.sharp and self.sharp[0] is self._origin[0]:
                return None
            self.sharp, self.smooth = self._origin, self._inverse(*self._origin)
            secants.forget()
            known = secants.copy()

    def _anderson(self, v, active, s, secants, most):
        problem, r = self.problem, self._r
        bound = LIMITS.longest * problem.unit
        self.worst = worst = problem.residual(v, active, s, r)
        first, self.steps = worst, 0
        while worst > problem.tolerance:
            if self.steps == most or not worst < LIMITS.runaway * max(first, bound):
                return None
            v_before, r_before = v.copy(), r.copy()
            advance(v, secants.move(r, self.smooth), bound)
            self.worst = worst = problem.residual(v, active, s, r)
            secants.push(v, r, v_before, r_before)
            self.steps += 1
        return s

    def solve_on_arc(self, v, active, s, secants, most, chord, arc):
        """The load s at which v, changed in place, is an equilibrium with <chord, v> = arc; None if that fails."""
        return self._solved(v, active, s, secants, most, self._anderson_on_arc, chord, arc)

    def _anderson_on_arc(self, v, active, s, secants, most, chord, arc):
        problem, r, direction = self.problem, self._r, self.problem.direction
        bound = LIMITS.longest * problem.unit
        worst = problem.residual(v, active, s, r)
        for _ in range(most):
            if worst <= problem.tolerance:
                self.worst = worst
                return s
            if not worst < LIMITS.runaway * problem.unit:
                return None
            v_before, r_before = v.copy(), r.copy()
            correction, response = secants.move(r, self.smooth), secants.move(direction, self.smooth)
            slope = dot(chord, response)
            change = (arc - dot(chord, v) - dot(chord, correction)) / slope if slope != 0.0 else 0.0
            change *= advance(v, correction + change * response, bound)
            problem.residual(v, active, s, r)
            secants.push(v, r, v_before, r_before)
            s += change
            r += change * direction
            worst = np.abs(r).max()
        return None
