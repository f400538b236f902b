"""Damped Green's function molecular dynamics (paper section 2.1): nothing but the motion, at every increment.

The reference method. Modes of equal mass move by explicit Verlet steps from the last equilibrium, under the next load,
until max |U + C T(u) - u| is below the tolerance.
"""

from math import isfinite

import numpy as np

from .motion import Creep, ExplicitMotion
from .state import End, Increment, NotConverged, State, slipped


class Gfmd:
    """Advances States of one problem by damped motion alone; the methods are those of `quasistatic.QuasiStatic`."""

    def __init__(self, problem, damping, closed, budget=1_000_000):
        """budget: most steps of an increment, of some 20 us each; a slip of the default takes 3,500."""
        self.problem, self.damping, self.closed, self.budget = problem, damping, closed, budget

    def increment(self, state, target) -> Increment:
        """The Increment in which the motion from `state` comes to rest at load `target`, nm; raises NotConverged."""
        v, residual = self._moved(state.v, state.load, target)
        after = State.at_rest(target, v, residual=residual)
        slip = End(state.load, state.v, None, "lost", after=after)
        return Increment(after, (slip,) if slipped(self.problem, state, target, after) else ())

    def _moved(self, v, load, target):
        """(v, residual) at rest under load `target`, from rest at `load`."""
        problem, dynamics, r = self.problem, self.problem.motion(), np.empty(self.problem.size)
        motion = self._motion(dynamics, dynamics.start(v, load), target)
        for _ in range(0, self.budget, 20):  # so the residual adds 5 % to the cost
            motion.soften(self._stiffness(dynamics, v))
            motion.advance(20)
            v = dynamics.unknowns(motion.y)
            residual = problem.residual(v, target, r)
            if residual <= problem.tolerance:
                return v, residual
            problem.hold(v, target)
            if not isfinite(residual):
                raise NotConverged(f"the damped motion diverges, residual {residual:.2g} nm")
        raise NotConverged(f"residual {residual:.2g} nm after {self.budget} steps of damped motion")

    def _motion(self, dynamics, y, load):
        return (ExplicitMotion if isfinite(self.damping) else Creep)(dynamics, y, load, self.damping, self.closed)

    def _stiffness(self, dynamics, v):
        """Largest stiffness of the interaction, GPa/nm, which limits the steps."""
        return dynamics.interface(v)
