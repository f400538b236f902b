"""From a guess to the equilibrium at fixed load, or at fixed arc length with the load solved for.

As a rule by Anderson steps; where they fail, by Anderson steps preconditioned with the inverse of a tangent nearby, of
which a few do. The problem forms that inverse; where that takes too long, iterations stand in, whose products are kept.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

import numpy as np

from .anderson import Secants, advance, dot
from .inverse import Inverse


@dataclass(frozen=True)
class Limits:
    """Of the corrector; a "unit" is the problem's `unit`."""

    memory: int = 20  # secant pairs; 40 save 3 % of the evaluations, but each step's algebra takes twice as long
    longest: float = 0.15  # units, of any unknown in one step; longer steps land on other branches
    steps: int = 60  # Anderson steps, at most; 100 reached no more rests on 13 scenes of the slider box
    # with an inverse; 2 to 10 are needed where there is an equilibrium, else more do not help: 60 take 7 % more
    # evaluations of the default
    sharp_steps: int = 15
    iterated: float = 0.3  # relative error of an inverse by iterations; secants do the rest, less would take longer


LIMITS = Limits()


@dataclass
class Sharp:
    """The tangent at an equilibrium (v, active) and the function, (size,) to (size,), close to -(dR/dv)^-1 there."""

    v: np.ndarray
    active: np.ndarray
    apply: Callable
    formed: bool  # else by iterations, too slow for other uses

    def at(self, v):
        """Whether it is that of the equilibrium v (size,)."""
        return self.v.shape == v.shape and bool((self.v == v).all())


class Corrector:
    """Solves one problem; between calls it keeps the inverse at hand, and scratch."""

    def __init__(self, problem):
        self.problem = problem
        self.worst = np.inf  # residual of the last solution, nm
        self._sharp = None  # the Sharp in use, if any, for the part of the residual that no secant pair knows
        self._known = None  # the Sharp formed last
        self._origin = None  # (v, active) of the equilibrium found last
        self._r = np.empty(problem.size)

    def secants(self):
        """Room for secant pairs of this problem."""
        return Secants(LIMITS.memory, self.problem.size)

    @property
    def sharp(self):
        """(v, active) of the tangent whose inverse is in use, or None; a State keeps it for `begin`."""
        return self._sharp and (self._sharp.v, self._sharp.active)

    @property
    def inverse(self):
        """The formed inverse of a tangent nearby, for other uses, or None."""
        return self._sharp.apply if self._sharp and self._sharp.formed else None

    def begin(self, state):
        """Prepare to go on from a State, with the inverse by which it was reached, if any."""
        self._origin = state.v, state.active
        self._sharp = self._at(*state.sharp) if state.sharp else None

    def _at(self, v, active):
        """The Sharp of an equilibrium."""
        if self._known is None or not self._known.at(v):
            formed = self.problem.preconditioner(v, active)
            self._known = Sharp(v, active, formed or self._iterations(v, active, LIMITS.iterated), formed is not None)
        return self._known

    @property
    def _smooth(self):
        return self._sharp and self._sharp.apply

    def direction(self, state):
        """dv/ds of the branch at a State, (size,), to `inverse.ACCURACY`; large near a fold."""
        return self._iterations(state.v, state.active)(self.problem.direction)

    def _iterations(self, v, active, *accuracy):
        """The inverse of -dR/dv by iterations."""
        inverse = Inverse(self.problem.size).of_tangent(self.problem.linearised(v, active).tangent, None)
        return lambda r: -inverse.solve(r, *accuracy)

    def settle(self, v, active, s, secants):
        """Solve for v (size,), in place, with the set of active nodes, bool; returns that set, or None if it fails.

        While nodes have crossed the edge of the window, the set is changed and the solve repeated. Each node may change
        once, so that this ends, even where becoming active pushes a node out again and no set is consistent.
        """
        settled = None
        while self.solve(v, active, s, secants):
            again = self.problem.active(v, s, active, settled)
            if again is active:
                return active
            changed = again != active
            settled = changed if settled is None else settled | changed
            active = again
        return None

    def solve(self, v, active, s, secants):
        """Solve for v (size,), in place, at fixed load s, nm; whether that succeeded."""
        return self._solved(v, active, s, secants, self._anderson) is not None

    def solve_on_arc(self, v, active, s, secants, chord, arc):
        """The load (nm) at which v, changed in place, is an equilibrium with <chord, v> = arc, nm; None if it fails."""
        return self._solved(v, active, s, secants, self._anderson_on_arc, chord, arc)

    def _solved(self, v, active, s, secants, method, *arc):
        """The load at which v, changed in place by `method`, is an equilibrium, or None.

        Where the method fails, it is tried again with the inverse of the tangent at the equilibrium found last, unless
        that was already in use. Secant pairs of steps that led nowhere would mislead the next ones.
        """
        guess = v.copy()
        self._origin = self._origin or (guess, active)
        while True:
            found = method(v, active, s, secants, LIMITS.sharp_steps if self._sharp else LIMITS.steps, *arc)
            if found is not None:
                self._origin = v.copy(), active
                return found
            v[:] = guess
            secants.forget()
            if self._sharp and self._sharp.at(self._origin[0]):
                return None
            self._sharp = self._at(*self._origin)

    def _anderson(self, v, active, s, secants, most):
        problem, r = self.problem, self._r
        bound = LIMITS.longest * problem.unit
        self.worst = worst = problem.residual(v, active, s, r)
        steps = 0
        while worst > problem.tolerance:
            if steps == most or not isfinite(worst):
                return None
            v_before, r_before = v.copy(), r.copy()
            advance(v, secants.move(r, self._smooth), bound)
            self.worst = worst = problem.residual(v, active, s, r)
            secants.push(v, r, v_before, r_before)
            steps += 1
        return s

    def _anderson_on_arc(self, v, active, s, secants, most, chord, arc):
        problem, r, direction = self.problem, self._r, self.problem.direction
        bound = LIMITS.longest * problem.unit
        worst = problem.residual(v, active, s, r)
        for _ in range(most):
            if worst <= problem.tolerance:
                self.worst = worst
                return s
            if not isfinite(worst):
                return None
            v_before, r_before = v.copy(), r.copy()
            # v must change by correction + change * response when the load does by change: chosen to stay on the arc
            correction, response = secants.move(r, self._smooth), secants.move(direction, self._smooth)
            slope = dot(chord, response)
            change = (arc - dot(chord, v) - dot(chord, correction)) / slope if slope != 0.0 else 0.0
            change *= advance(v, correction + change * response, bound)
            problem.residual(v, active, s, r)
            secants.push(v, r, v_before, r_before)
            s += change
            r += change * direction
            worst = np.abs(r).max()
        return None
