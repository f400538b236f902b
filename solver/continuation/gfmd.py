"""Damped Green's function molecular dynamics (paper section 2.1): nothing but the motion, at every increment.

The reference method. Modes of equal mass move by explicit Verlet steps from the last equilibrium, under the next load,
until max |U + C T(u) - u| is below the tolerance. Where they slip, the steps are halved until two motions land in the
same state; if none do, the slip is `sensitive`.
"""

from math import isfinite

import numpy as np

from .motion import Creep, ExplicitMotion
from .state import End, Increment, NotConverged, State, slipped

HALVED = 2, 4, 8  # divisors of the steps, in turn: after flutter half of the usual steps landed elsewhere, 3 times in 3
ALIKE = 0.05  # units of the problem: closer states are one; at another site a node is a unit off


class Gfmd:
    """Advances States of one problem by damped motion alone; the methods are those of `quasistatic.QuasiStatic`."""

    def __init__(self, problem, damping, closed, budget=1_000_000, pace=1.0):
        """budget: most steps of an increment, of some 20 us each; a slip of the default takes 3,500.

        pace: factor of the usual steps.
        """
        self.problem, self.damping, self.closed, self.budget, self.pace = problem, damping, closed, budget, pace

    def increment(self, state, target) -> Increment:
        """The Increment in which the motion from `state` comes to rest at load `target`, nm; raises NotConverged."""
        after = self._moved(state, target, self.pace)
        if not slipped(self.problem, state, target, after):
            return Increment(after)
        for finer in HALVED:
            last, after = after, self._moved(state, target, self.pace / finer)
            if agree := np.abs(after.v - last.v).max() <= ALIKE * self.problem.unit:
                break
        return Increment(after, (End(state.load, state.v, None, "lost", after=after, sensitive=not agree),))

    def _moved(self, state, target, pace):
        """The State at rest under load `target`, from rest in `state`; pace: factor of the usual steps."""
        v, load = state.v, state.load
        problem, dynamics, r = self.problem, self.problem.motion(), np.empty(self.problem.size)
        motion = self._motion(dynamics, dynamics.start(v, load), target)
        for _ in range(0, round(self.budget / min(pace, 1.0)), 20):  # so the residual adds 5 % to the cost
            motion.soften(self._stiffness(dynamics, v), pace)
            motion.advance(20)
            v = dynamics.unknowns(motion.y)
            residual = problem.residual(v, target, r)
            if residual <= problem.tolerance:
                return State.at_rest(target, v, residual=residual)
            problem.hold(v, target)
            if not isfinite(residual):
                raise NotConverged(f"the damped motion diverges, residual {residual:.2g} nm")
        raise NotConverged(f"residual {residual:.2g} nm after {self.budget} steps of damped motion")

    def _motion(self, dynamics, y, load):
        return (ExplicitMotion if isfinite(self.damping) else Creep)(dynamics, y, load, self.damping, self.closed)

    def _stiffness(self, dynamics, v):
        """Largest stiffness of the interaction, GPa/nm, which limits the steps."""
        return dynamics.interface(v)
