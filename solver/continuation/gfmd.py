"""Damped Green's function molecular dynamics (paper section 2.1): nothing but the motion, at every increment.

The reference method. Modes of one mass move by explicit Verlet steps from the rest before, under the next load, until
max |U + C T(u) - u| is below the tolerance.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from .motion import Creep, ExplicitMotion
from .state import Increment, NotConverged, Slip, State


@dataclass(frozen=True)
class Limits:
    """check: steps between two looks at the residual. budget: force evaluations of one increment. diverged, slipped: in
    units of the problem's `unit`; a move beyond `slipped` and twice the increment of the load is a slip.
    """

    check: int = 20
    budget: int = 1_000_000
    diverged: float = 1e9
    slipped: float = 0.5


LIMITS = Limits()


class Gfmd:
    """Advances States of one problem by damped motion; the contract is that of `quasistatic.QuasiStatic`."""

    pace = 1.0  # of its time steps, over the usual ones

    def __init__(self, problem, damping, closed):
        self.problem, self.damping, self.closed = problem, damping, closed

    def start(self, load):
        """The State of unknowns that nothing acts on."""
        v = self.problem.undeformed(load)
        return State.at_rest(load, v, self.problem.active_of(v, load))

    def increment(self, state, target):
        """The Increment in which the motion from `state` comes to rest at load `target`; raises NotConverged."""
        while True:
            v, active, residual = self._settled(state, target)
            if not self.problem.crowded(v, active, target):
                break
            state = self.widened(state)
        moved, unit = np.abs(v - state.v).max(), self.problem.unit
        slipped = moved > LIMITS.slipped * unit + 2.0 * abs(target - state.load)
        after = State.at_rest(target, v, active)
        slips = (Slip(state.load, state.v, state.active, "lost", False, after, self.problem.place),) if slipped else ()
        return Increment(after, residual, slips)

    def widened(self, state):
        """The same state in a problem of more unknowns, which takes the place of the present one."""
        self.problem, v, active = self.problem.grown(state.v, state.active, state.load)
        return State.at_rest(state.load, v, active)

    def _settled(self, state, target):
        """(v, active, residual) at rest, the active nodes those of v; they change between motions only, once each."""
        v, active, load, settled = state.v, state.active, state.load, np.zeros(state.active.size, bool)
        while True:
            v, residual = self._moved(v, active, load, target)
            load, again = target, self.problem.admitted(v, active, settled)
            if again is active:
                return v, active, residual
            settled |= again != active
            active = again

    def _moved(self, v, active, load, target):
        """(v, residual) at rest under load `target`, from rest at `load`."""
        problem, dynamics, r = self.problem, self.problem.motion(), np.empty(self.problem.size)
        limit = problem.evaluations + LIMITS.budget
        motion = self._motion(dynamics, dynamics.start(v, active, load), target)
        while True:
            motion.soften(self._stiffness(dynamics, v, active), self.pace)
            motion.advance(active, LIMITS.check)
            v = dynamics.unknowns(motion.y, target)
            residual = problem.residual(v, active, target, r)
            if residual <= problem.tolerance:
                return v, residual
            problem.active_of(v, target)  # which tells where nothing interacts any longer that bears a weight
            if not residual < LIMITS.diverged * problem.unit:
                raise NotConverged(f"the damped motion diverges, residual {residual:.2g} nm")
            if problem.evaluations > limit:
                raise NotConverged(
                    f"residual {residual:.2g} nm after {LIMITS.budget} force evaluations of damped motion"
                )

    def _motion(self, dynamics, y, load):
        return (ExplicitMotion if isfinite(self.damping) else Creep)(dynamics, y, load, self.damping, self.closed)

    def _stiffness(self, dynamics, v, active):
        """Of the interaction, GPa/nm, which limits the steps."""
        return dynamics.interface(v, active)
