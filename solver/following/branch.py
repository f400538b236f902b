"""The states that describe a branch, dense towards its ends, and interpolation between them.

Towards its fold, a branch moves as the root of the distance in load, and it may begin near another fold. States are
smooth in t from 0 to 1, with load = start + (end - start) sin^2(pi t/2), where t is even at first.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BSpline, make_interp_spline

from ..continuation.fold import Fold

TOLERANCE = 1e-5  # nm, of residuals: the forces of followed runs are right to 1e-4
PADDED = 12  # states before and after a period: the ends of a quintic spline act on the next state 0.43 times as much
DEGREE = 5  # of splines through the states; with 3 a branch needs twice as many states for the same forces


class NotFollowed(Exception):
    """The run of the other scene does not continue that of the skeleton; the message gives the reason.

    Compute that run from its start. nearer: smaller changes of the parameters might lead there.
    """

    def __init__(self, reason: str, nearer: bool = False) -> None:
        super().__init__(reason)
        self.nearer = nearer


class TooNarrow(NotFollowed):
    """A node outside the patch may interact."""


@dataclass(frozen=True, eq=False)
class Branch:
    """n + 1 states from load `start` to `end`, nm, at the positions t from 0 to 1.

    periodic: smooth sliding over one period: t is linear in the load, and v less the load is periodic.
    """

    start: float
    end: float
    t: NDArray[np.float64]  # (n + 1,)
    v: NDArray[np.float64] = field(repr=False)  # (n + 1, size)
    active: Any = field(repr=False)  # bool (n + 1, m); None while a branch is made
    fold: Fold | None = field(default=None, repr=False)  # the last state, where the branch ends in one
    periodic: bool = False

    @property
    def intervals(self) -> int:
        """n."""
        return len(self.v) - 1

    @property
    def loads(self) -> NDArray[np.float64]:
        """Loads of the states, (n + 1,) nm."""
        return self.load_at(self.t)

    def load_at(self, t: ArrayLike) -> NDArray[np.float64]:
        """Loads, nm, at t."""
        part = np.asarray(t, float) if self.periodic else np.sin(0.5 * np.pi * np.asarray(t, float)) ** 2
        return self.start + (self.end - self.start) * part

    def weights(self, load: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weights (k, n + 1) of the states in those at loads (k,); beyond the ends of the branch, of its ends."""
        if self.periodic:
            return self.weights_at((np.asarray(load) - self.start) / (self.end - self.start) % 1.0)
        return self.weights_at(position_between(self.start, self.end, load))

    def weights_at(self, t: ArrayLike, derivative: int = 0) -> NDArray[np.float64]:
        """Weights (k, n + 1) of the states in those at t (k,), or in a derivative of these by t."""
        return _spline(tuple(self.t), self.periodic)(np.atleast_1d(np.asarray(t, float)), derivative)

    def without(self, out: NDArray[np.intp]) -> "Branch":
        """The same Branch without the states `out`."""
        t, v, active = (np.delete(rows, out, 0) for rows in (self.t, self.v, self.active))
        return replace(self, t=t, v=v, active=active)

    def states(self, load: NDArray[np.float64], nodes: int) -> NDArray[np.float64]:
        """Unknowns (k, size) at loads (k,), the first `nodes` of which move on with the load."""
        moving = np.zeros(self.v.shape[1])
        moving[:nodes] = 1.0
        return self.weights(load) @ (self.v - self.loads[:, None] * moving) + load[:, None] * moving


def position_between(start: float, end: float, load: ArrayLike) -> NDArray[np.float64]:
    """t of loads on a branch; 0 or 1 beyond its ends."""
    part = np.clip((np.asarray(load, float) - start) / (end - start), 0.0, 1.0)
    return np.arcsin(np.sqrt(part)) * (2.0 / np.pi)


@lru_cache(maxsize=64)
def _spline(t: tuple[float, ...], periodic: bool) -> BSpline:
    """The spline of the weights of values at these t; over a period the last weight is zero, as the first counts."""
    n, at, weights = len(t) - 1, np.array(t), np.eye(len(t))
    if periodic:
        weights[-1] = weights[0]
        few = min(PADDED, n)
        at = np.concatenate([at[-few - 1 : -1] - 1.0, at, at[1 : few + 1] + 1.0])
        weights = np.concatenate([weights[-few - 1 : -1], weights, weights[1 : few + 1]])
    return make_interp_spline(at, weights, min(DEGREE, n - 1 + n % 2))  # an odd degree, up to the number of states
