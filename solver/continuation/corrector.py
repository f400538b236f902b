"""From a guess to the equilibrium at fixed load, or at fixed arc length with the load solved for.

As a rule by Anderson steps; where they fail, by Anderson steps preconditioned with the inverse of a tangent nearby, of
which a few do. The problem forms that inverse; where that takes too long, iterations stand in, whose products are kept.
"""

from dataclasses import dataclass

import numpy as np

from .anderson import Secants, advance, dot
from .inverse import Inverse


@dataclass(frozen=True)
class Limits:
    """Of the corrector; a "unit" is the problem's `unit`."""

    memory: int = 40  # secant pairs; fewer: more evaluations for soft layers; more: steps cost more than they save
    longest: float = 0.15  # units, of any unknown in one step; longer steps land on other branches
    runaway: float = 1e3  # growth of the residual at which the steps have failed; on an arc, the residual in units
    sharp_steps: int = 15  # with an inverse; 2 to 10 are needed where there is an equilibrium, else more do not help
    iterated: float = 0.3  # relative error of an inverse by iterations; secants do the rest, less would take longer


LIMITS = Limits()


class Corrector:
    """Solves one problem; between calls it keeps the inverse at hand, and scratch."""

    def __init__(self, problem):
        self.problem = problem
        self.smooth = None  # for the part of the residual that no secant pair knows: `Secants.move`
        self.worst = np.inf  # residual of the last solution
        self._r = np.empty(problem.size)
        self.sharp = None  # (v, active) of the tangent whose inverse is `smooth`, if it is one
        self._origin = None  # (v, active) of the equilibrium found last
        self._iterated = None, None  # v, and the Inverse whose iterations solve with the tangent there

    def secants(self):
        """Room for secant pairs of this problem."""
        return Secants(LIMITS.memory, self.problem.size)

    @property
    def inverse(self):
        """The inverse of a tangent nearby, for other uses, or None if there is none, or if it is but iterations."""
        return self.smooth if self.sharp and self.sharp[0] is not self._iterated[0] else None

    def settle(self, v, active, s, secants, most):
        """Solve for v, in place, together with the set of active nodes; returns that set, or None if it fails.

        While nodes have crossed the edge of the window, the set is changed and the solve repeated. Each node may change
        once, so that this ends, even where becoming active pushes a node out again and no set is consistent.
        """
        settled = None
        while self.solve(v, active, s, secants, most):
            again = self.problem.admitted(v, active, settled)
            if again is active:
                return active
            changed = again != active
            settled = changed if settled is None else settled | changed
            active = again
        return None

    def solve(self, v, active, s, secants, most):
        """Solve for v, in place, at fixed load, by at most so many Anderson steps; whether that succeeded."""
        return self._solved(v, active, s, secants, most, self._anderson) is not None

    def begin(self, state):
        """Prepare to go on from a State, with the inverse by which it was reached, if any."""
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

    def _solved(self, v, active, s, secants, most, method, *arc):
        """The load at which v, changed in place by `method`, is an equilibrium, or None.

        Where the method fails, it is tried again with the inverse of the tangent at the equilibrium found last, unless
        that was already in use.
        """
        guess, known = v.copy(), secants.copy()
        self._origin = self._origin or (guess, active)
        while True:
            found = method(v, active, s, secants, LIMITS.sharp_steps if self.sharp else most, *arc)
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
        first, steps = worst, 0
        while worst > problem.tolerance:
            if steps == most or not worst < LIMITS.runaway * max(first, bound):
                return None
            v_before, r_before = v.copy(), r.copy()
            advance(v, secants.move(r, self.smooth), bound)
            self.worst = worst = problem.residual(v, active, s, r)
            secants.push(v, r, v_before, r_before)
            steps += 1
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
            # v must change by correction + change * response when the load does by change: chosen to stay on the arc
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
