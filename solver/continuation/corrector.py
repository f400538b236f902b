"""From a guess to the equilibrium at fixed load, or at fixed arc length with the load solved for.

As a rule by Anderson steps; where they fail, by Anderson steps preconditioned with the inverse of a tangent nearby, of
which a few do. The problem forms that inverse; where that takes too long, iterations stand in, whose products are kept.
"""

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


class Corrector:
    """Solves one problem; between calls it keeps the inverse at hand, and scratch.

    Attributes: worst, the residual of the last solution, nm; sharp, (v, active) of the equilibrium the inverse of whose
    tangent is in use, or None: a State keeps it for `begin`; inverse, that function, (size,) to (size,), close to
    -(dR/dv)^-1, for other uses, or None if it takes iterations, which are too slow for them.
    """

    def __init__(self, problem):
        self.problem, self.worst = problem, np.inf
        self.sharp = self.inverse = None
        self._smooth = None  # the inverse in use, if any, for the part of the residual that no secant pair knows
        self._origin = None  # (v, active) of the equilibrium found last
        self._r = np.empty(problem.size)

    def secants(self):
        """Room for secant pairs of this problem."""
        return Secants(LIMITS.memory, self.problem.size)

    def begin(self, state):
        """Prepare to go on from a State, with the inverse by which it was reached, if any."""
        self._origin = state.v, state.active
        self._use(state.sharp)

    def _use(self, sharp):
        """From now on use the inverse of the tangent at the equilibrium `sharp`, (v, active), or none."""
        if sharp is None:
            self.sharp = self.inverse = self._smooth = None
        elif not self._uses(sharp):
            self.sharp, self.inverse = sharp, self.problem.preconditioner(*sharp)
            self._smooth = self.inverse or self._iterations(*sharp, LIMITS.iterated)

    def _uses(self, sharp):
        return self.sharp is not None and np.array_equal(self.sharp[0], sharp[0])

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
        return self._solved(v, active, s, secants) is not None

    def solve_on_arc(self, v, active, s, secants, chord, arc):
        """The load (nm) at which v, changed in place, is an equilibrium with <chord, v> = arc, nm; None if it fails."""
        return self._solved(v, active, s, secants, chord, arc)

    def _solved(self, v, active, s, secants, *arc):
        """The load at which v, changed in place, is an equilibrium, or None.

        Where Anderson steps fail, they are tried again with the inverse of the tangent at the equilibrium found last,
        unless that was already in use. Secant pairs of steps that led nowhere would mislead the next ones.
        """
        guess = v.copy()
        self._origin = self._origin or (guess, active)
        while True:
            found = self._anderson(v, active, s, secants, *arc)
            if found is not None:
                self._origin = v.copy(), active
                return found
            v[:] = guess
            secants.forget()
            if self._uses(self._origin):
                return None
            self._use(self._origin)

    def _anderson(self, v, active, s, secants, chord=None, arc=0.0):
        """One attempt of `_solved`; with a chord, the load changes along with v."""
        problem, r, direction = self.problem, self._r, self.problem.direction
        left = LIMITS.steps if self.sharp is None else LIMITS.sharp_steps
        self.worst = problem.residual(v, active, s, r)
        while self.worst > problem.tolerance:
            if left == 0 or not isfinite(self.worst):
                return None
            v_before, r_before = v.copy(), r.copy()
            move, change = secants.move(r, self._smooth), 0.0
            if chord is not None:
                # v must change by move + change * response when the load does by change: chosen to stay on the arc
                response = secants.move(direction, self._smooth)
                slope = dot(chord, response)
                change = (arc - dot(chord, v) - dot(chord, move)) / slope if slope != 0.0 else 0.0
                move += change * response
            change *= advance(v, move, LIMITS.longest * problem.unit)
            self.worst = problem.residual(v, active, s, r)
            secants.push(v, r, v_before, r_before)
            if chord is not None:
                s += change
                r += change * direction
                self.worst = float(np.abs(r).max())
            left -= 1
        return s
