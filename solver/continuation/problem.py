"""What the methods of this folder are applied to: the contract, on which tests/test_contract.py tests every problem.

A Problem is an equilibrium R(v; s) = 0 in unknowns v (size,) under a load s, in which R is linear, together with a
motion, its Dynamics, whose rests are the equilibria. Small disturbances of an equilibrium are seen by its Linearised.
Lengths in nm, moduli in GPa, each mode of unit mass. `mechanics.equilibrium` and tests/toys.py fulfil the contract.
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np


class Linearised(Protocol):
    """An equilibrium linearised: a disturbance x, N real numbers of unit mass, obeys x'' = (J - K) x - gamma x'."""

    size: int  # N

    @property
    def noise(self) -> np.ndarray:
        """(N,), a force at random that modes of any stiffness answer alike. For N > `RestOptions.most`"""

    def product(self, x, layered=None) -> np.ndarray:
        """(J - K) x, (N,), a new array; layered: K x, where that is known."""

    def tangent(self, w) -> np.ndarray:
        """dR/dv w, (size of the problem,), a new array."""

    def transposed(self, w) -> np.ndarray:
        """(dR/dv)^T w, (size of the problem,), a new array."""

    def mirrored(self, w) -> np.ndarray:
        """The left null vector of dR/dv, of any length, that a symmetric interaction has for the right one w."""

    def slopes(self, right, left) -> np.ndarray:
        """<left, dR/dv right> differentiated by the unknowns, (size of the problem,), a new array."""

    def matrix(self) -> np.ndarray | None:
        """dR/dv, dense, or None where it is too large to be factorised."""

    def inverse(self, solve: Callable, f) -> tuple[np.ndarray, np.ndarray]:
        """(x, K x), (N,) each, with (K - J) x = f; solve: the function that gives w for dR/dv w. K x is exact even if
        `solve` is not. For N > `RestOptions.most`."""

    def seen(self, x) -> np.ndarray:
        """The unknowns (size of the problem,) of x, of the sign in which a state that does not rest is left."""

    def safe_damping(self) -> float:
        """The damping over critical above which no wave can flutter; for `RestOptions.most` < N <= `dense_waves`."""

    def waves(self) -> tuple | None:
        """(mu (2, waves) of all modes, shown) if every mode is a wave, with shown(i, q) the x of one, complex (N,), or
        None if these unknowns cannot show it. Else None."""


class Dynamics(Protocol):
    """u'' = K (U - u) + T(u) - gamma u' in coordinates y, complex (2, modes)."""

    stiffness: np.ndarray  # (3, modes), GPa/nm, rows xx, zz, c of the blocks [[xx, -i c], [i c, zz]] of K
    critical: float  # the friction gamma, 1/time, that is critical for the slowest mode

    def start(self, v, active, s) -> np.ndarray:
        """y, a new array, at rest in v (size of the problem,) under the load s."""

    def unknowns(self, y) -> np.ndarray:
        """v (size of the problem,) of y, a new array."""

    def force(self, y, active, s) -> np.ndarray:
        """T + K U in the coordinates y, complex (2, modes), a buffer."""

    def interface(self, v, active) -> float:
        """The largest stiffness of the interaction in v, GPa/nm: a bound on dT/du by row sums."""


class Problem(Protocol):
    """An equilibrium, whose nodes interact where `active`, bool."""

    size: int
    unit: float  # nm, over which the interaction changes
    tolerance: float  # nm, of max |R|
    direction: np.ndarray  # dR/ds (size,), constant; v + k a direction is v moved on by k periods a of the lattice

    def residual(self, v, active, s, out) -> float:
        """Fill out (size,) with R, nm; returns its largest magnitude."""

    def active(self, v, s, before=None, settled=None) -> np.ndarray:
        """The nodes that interact in v. Given those `before`: these themselves while no node has clearly crossed the
        edge of the interaction, else a new set, those of `settled` (bool) as they are. May raise NotConverged."""

    def preconditioner(self, v, active) -> Callable | None:
        """A function close to the inverse of -dR/dv, or None where forming it would take too long."""

    def grown(self, v, active, s, hidden=False) -> tuple | None:
        """(problem, v, active) with more unknowns, if these are needed, or asked for by `hidden`; else None."""

    @property
    def uniform(self) -> bool:
        """Whether one node stands for all, so that waves do not show."""

    def sites(self, v, w) -> float:
        """By how many sites of the lattice the unknown that moves farthest along it lies elsewhere in w than in v."""

    def alike(self, v) -> bool:
        """Whether all nodes are alike in v, so that no wave begins to grow without a disturbance."""

    def loose(self, v, active) -> bool:
        """Whether single nodes have several equilibria next to v, so that small errors decide where each rests."""

    def linearised(self, v, active) -> Linearised:
        """The problem linearised at an equilibrium; a later call leaves it valid."""

    def motion(self) -> Dynamics:
        """The motion whose rests are the equilibria."""
