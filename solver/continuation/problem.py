"""The contracts of the problems and methods of this folder; tests/solver/test_contract.py tests every one on them.

A Problem is R(v; s) = 0 in unknowns v (size,) under a load s, in which R is linear. Its Dynamics are a motion that
comes to rest in these equilibria. A Linearised describes small disturbances of one of them. Lengths are in nm, moduli
in GPa, and each mode has unit mass. `mechanics.equilibrium` and tests/shared/toys.py fulfil the contract. A Stepper
advances a state along the load: `quasistatic`, `gfmd` and those of tests/shared/transients.py.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from .state import Increment, State


class Linearised(Protocol):
    """An equilibrium linearised: a disturbance x, N real numbers of unit mass, obeys x'' = (J - K) x - gamma x'."""

    size: int  # N

    @property
    def noise(self) -> np.ndarray:
        """(N,), a random force to which modes of any stiffness respond alike. Needed for N > `rest.MOST`."""

    def product(self, x, layered=None) -> np.ndarray:
        """(J - K) x, (N,), a new array; layered: K x, or None."""

    def tangent(self, w) -> np.ndarray:
        """dR/dv w, (size of the problem,), a new array."""

    def transposed(self, w) -> np.ndarray:
        """(dR/dv)^T w, (size of the problem,), a new array."""

    def mirrored(self, w) -> np.ndarray:
        """The left null vector of dR/dv for the right one w, if J were symmetric; of any length."""

    def slopes(self, right, left) -> np.ndarray:
        """The derivative of <left, dR/dv right> by the unknowns, (size of the problem,), a new array."""

    @property
    def acting(self) -> np.ndarray:
        """Indices (k,) of unknowns, in order; R depends on each of the others only by -1 in its own row, nearly."""

    def matrix(self) -> np.ndarray | None:
        """dR/dv of the `acting` unknowns, (k, k), or None where it is too large to be factorised."""

    def inverse(self, solve: Callable, f) -> tuple[np.ndarray, np.ndarray]:
        """(x, K x), (N,) each, with (K - J) x = f. solve: the function from dR/dv w to w; K x is exact even if `solve`
        is not. Needed for N > `rest.MOST`."""

    def seen(self, x) -> np.ndarray:
        """The unknowns (size of the problem,) of x, with the sign in which the surface leaves an unstable state.

        By a rule, not by the state: that cannot tell the two ways apart where it is symmetric.
        """

    def safe_damping(self) -> float:
        """The damping over critical above which no wave flutters; for `rest.MOST` < N <= `rest.DENSE_WAVES`."""

    def waves(self) -> tuple | None:
        """(mu (2, waves) of all modes, shown) if every mode is a wave, else None. shown(i, q): the x of mu[i, q],
        complex (N,)."""


class Dynamics(Protocol):
    """The motion u'' = K (U - u) + T(u) - gamma u' in coordinates y, complex (2, modes)."""

    stiffness: np.ndarray  # (3, modes), GPa/nm, rows xx, zz, c of the blocks [[xx, -i c], [i c, zz]] of K
    critical: float  # the friction gamma, 1/time, that is critical for the slowest mode

    def start(self, v, s) -> np.ndarray:
        """y, a new array, of the state v (size of the problem,) at rest under the load s."""

    def unknowns(self, y) -> np.ndarray:
        """v (size of the problem,) of y, a new array."""

    def force(self, y, s) -> np.ndarray:
        """T + K U in the coordinates y, complex (2, modes), a buffer."""

    def compiled(self, s) -> tuple | None:
        """The force under the load s for compiled loops, until the next call: (function, context, out), or None.

        The function (context, y, out) fills out, complex (2, modes), and no other array; arguments are addresses.
        """

    def evaluated(self, times: int) -> None:
        """As of Problem."""

    def interface(self, v) -> float:
        """The largest stiffness of the interaction in v, GPa/nm: a bound on |dT/du| by row sums."""


class Problem(Protocol):
    """An equilibrium of nodes that interact with a lattice."""

    size: int
    unit: float  # nm, over which the interaction changes
    tolerance: float  # nm, of max |R|
    direction: np.ndarray  # dR/ds (size,), constant; v + k a direction is v moved on by k periods a of the lattice

    def residual(self, v, s, out) -> float:
        """Fill out (size,) with R, nm; returns its largest magnitude."""

    def compiled(self, s) -> tuple[int, int] | None:
        """The residual under the load s for compiled loops, until the next call: (function, context), addresses.

        The function (context, v, out) fills out (size,); `vectors.evaluate` calls it. None: there is no such function.
        """

    def evaluated(self, times: int) -> None:
        """Count evaluations by `compiled`; it may raise to end the increment."""

    def hold(self, v, s) -> None:
        """Raise NotConverged if the state v of a motion under the load s can lead to no equilibrium."""

    def undeformed(self, s) -> np.ndarray:
        """The unknowns (size,) of a surface without interaction at load s, nm."""

    def solved_to(self, tolerance: float) -> "Problem":
        """The same problem with another tolerance, nm."""

    def sites(self, v, w) -> float:
        """Sites of the lattice between v and w, of the unknown that moves farthest along it."""

    def alike(self, v) -> bool:
        """Whether all nodes are alike in v, so that no wave starts to grow without a disturbance."""

    def linearised(self, v) -> Linearised:
        """The problem linearised at an equilibrium; it stays valid after later calls."""

    def motion(self) -> Dynamics:
        """The motion that comes to rest in the equilibria."""


class Stepper(Protocol):
    """What a run asks of a method: it advances States of one problem along its load.

    It is made of a problem, the damping of the transient over critical, and the stiffness of closed springs, GPa/nm
    (see `motion.Motion`).

    1. The state that an increment returns has a residual within the problem's tolerance.
    2. Its load is the target. It is higher only after a slip, where no equilibrium is reached before.
    3. A jump to another equilibrium is a slip of the increment, at a load from the state's up to the target's.
    4. Slips come in the order of their loads; the branch of each begins in the state `after` the one before.
    5. Where no equilibrium is reached, NotConverged is raised.
    6. The given state stays valid: from it the increment can be made again.
    7. Between increments it keeps nothing but scratch: the state alone determines the next one.
    """

    @property
    def problem(self) -> Problem:
        """The problem that it advances."""

    def increment(self, state: "State", target: float) -> "Increment":
        """The Increment from `state` to load `target`, nm, which is higher than the state's; raises NotConverged."""
