"""The fast method below critical damping: inertia may carry one slip over several lattice sites.

Branches do not depend on damping, as they are at rest; only slips do. So they alone are left to the motion of `Gfmd`.
"""

from dataclasses import dataclass

import numpy as np

from .fast import MEMORY, Fast
from .fold import Fold
from .gfmd import Gfmd
from .secants import Secants
from .state import NotConverged, State

KICK = 0.05  # of min(delta_n, delta_t), off the fold: farther off, the energy there counts in how far a slip goes
NEAR = 1e-4  # of min(delta_n, delta_t): residual of a motion that creeps to rest, which secant steps may finish
BUDGET = 30_000  # force evaluations of one slip, times damping: some five times what slips take that come to rest


@dataclass(frozen=True)
class Rest:
    """Where a motion has come to rest, or nearly."""

    u: np.ndarray
    active: np.ndarray


class Inertial(Fast):
    """As `Fast`, each slip carried through by damped motion from rest at the fold, with the scene's damping."""

    def __init__(self, scene, first, size, leave_out=frozenset(), pressure=None):
        super().__init__(scene, first, size, leave_out, pressure)
        self._motion = Gfmd(scene, first, size, pressure=pressure, budget=int(BUDGET / scene.damping))

    def _through(self, fold, loading, limit):
        """The state in which the motion from the fold of a branch comes to rest, at the fold's load."""
        away = fold.beyond - fold.u
        length = float(np.abs(away).max())
        start = fold.u + away * min(1.0, KICK * self.unit / max(length, 1e-300))
        self.contact.mirror = False
        found = self._moved(start, loading, fold.load)
        if length > KICK * self.unit and np.abs(found.u - fold.u).max() < length:
            found = self._moved(fold.beyond.copy(), loading, fold.load)  # the end of the branch lies a little farther
        if self.stable(found.u, found.active, loading.at(fold.load)):
            return found
        return super()._through(Fold(fold.load, found.u, self.contact.traction(), found.u), loading, limit)

    def _moved(self, u, loading, load):
        """The State in which the motion from u, changed in place, comes to rest; it need not be stable."""
        motion = self._motion
        active = motion.contact.within_window(u)
        before = motion.contact.evaluations
        try:
            active = motion.come_to_rest(u, active, loading, load, load)
        except NotConverged:
            active = self.contact.within_window(u)
            if not self.contact.residual(u, active, loading.at(load), self._r) < NEAR * self.unit:
                raise
        finally:
            self.contact.evaluations += motion.contact.evaluations - before
        landed = self._land(Rest(u, active), loading, load)
        return landed or State(load, u, active, [(load, u)], Secants(MEMORY, u.size))
