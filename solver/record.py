"""Sliding repeats itself: translation by a lattice site is an exact symmetry, so one period of a run tells the rest.

If u is an equilibrium at U_x, then u + (k a, 0) is one at U_x + k a. Once a slip by k sites has landed on a state that
was passed before, k sites back, every later state is a recorded one moved on; its residual is evaluated, to be sure.
"""

from bisect import bisect_left
from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np

from .interpolation import combine, lagrange
from .state import Slip

SAME = 0.01  # of min(delta_n, delta_t): closer states at one load are one equilibrium; others lie part of a site off
STENCIL = 6  # recorded states through which one in between is interpolated


@dataclass
class Record:
    """The states of one branch in order of the load, from where it was entered to its fold.

    loads: nm; states: (u, active) of each. After `close`: fold, its end, and sites, how far it slips there.
    direction: of the top along x, +1 or -1.
    """

    loads: list = field(default_factory=list)
    states: list = field(default_factory=list)
    fold: Slip | None = None
    sites: int = 0
    direction: float = 1.0

    def copy(self):
        """The same states in lists of their own, so that going on with one leaves the other as it is."""
        return replace(self, loads=list(self.loads), states=list(self.states))

    def add(self, load, u, active, moved=0.0):
        """Insert a state that has moved on by that distance (nm) in order of its load, unless it is there already."""
        load = load - moved
        u = u - self._shift(moved)
        i = bisect_left(self.loads, load)
        if any(abs(other - load) < 1e-9 for other in self.loads[max(i - 1, 0) : i + 1]):
            return
        self.loads.insert(i, load)
        self.states.insert(i, (u, active))

    def state_at(self, load, moved=0.0):
        """(u, active) at `load`, moved on by that distance (nm).

        u is interpolated over the square root of the distance to the fold, as a function of which it is smooth.
        """
        load = load - moved
        i = bisect_left(self.loads, load)
        low = min(max(i - STENCIL // 2, 0), max(len(self.loads) - STENCIL, 0))
        near = slice(low, low + STENCIL)
        arcs = [-sqrt(max(self.fold.load - other, 0.0)) for other in self.loads[near]]
        weights = lagrange(arcs, -sqrt(max(self.fold.load - load, 0.0)))
        u = self._shift(moved) + combine(weights, [state for state, _ in self.states[near]])
        return u, self.states[max(i - 1, 0)][1]

    def slip(self, moved):
        """The Slip that ends the branch, moved on by that distance (nm)."""
        return replace(self.fold, load=self.fold.load + moved, before=self.fold.before + self._shift(moved))

    def _shift(self, moved):
        return np.array([[self.direction * moved], [0.0]])

    def close(self, fold, landed, spacing, unit):
        """End the branch with a Slip; True if the state landed in was passed before: then all that follows is known."""
        sites = round(float(np.max(self.direction * (landed.u[0] - fold.before[0]))) / spacing)
        home = fold.load - sites * spacing
        if sites < 1 or len(self.loads) < STENCIL or home < self.loads[0] - SAME * unit:
            return False
        self.fold, self.sites = fold, sites
        self.add(fold.load, fold.before, self.states[-1][1])
        u, _ = self.state_at(fold.load, sites * spacing)
        if np.abs(u - landed.u).max() > SAME * unit:
            return False
        first = max(0, bisect_left(self.loads, home) - STENCIL)
        del self.loads[:first], self.states[:first]
        return True
