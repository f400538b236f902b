"""The states that carry a branch, dense towards its ends, and what lies between them.

A branch goes to a fold with the root of the distance in load, and where the one before it has left, it may come from
near another. So states stand evenly in t from 0 to 1, load = start + (end - start) sin^2(pi t/2), and are smooth in t.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..continuation.interpolation import lagrange

TOLERANCE = 1e-5  # nm, of the residual: a followed run is looked at, not kept; forces are right to 1e-4
STENCIL = 6  # states through which what lies between them is interpolated


class NotFollowed(Exception):
    """The run under other parameters is no longer that of the skeleton, or cannot be got from it; the message says why.

    It has to be computed from its start. nearer: whether states nearer to those wanted might have led there.
    """

    def __init__(self, reason: str, nearer: bool = False) -> None:
        super().__init__(reason)
        self.nearer = nearer


class Crowded(NotFollowed):
    """A node outside the patch may interact."""


@dataclass(frozen=True)
class Fold:
    """A maximum of the load along a branch. Near it load = that of the fold + bend/2 (arc)^2, with arc = v[index]."""

    load: float
    v: np.ndarray  # (size,)
    active: np.ndarray
    along: np.ndarray  # (size,) dv per arc at the fold: the null vector of the tangent, one in component `index`
    bend: float  # per nm, negative

    @property
    def index(self):
        """The unknown that moves most."""
        return int(np.abs(self.along).argmax())

    @staticmethod
    def of(load, v, active, way, bend):
        """A fold on the way `way` (size,), any length, with the second derivative of the load along that way."""
        largest = way[int(np.abs(way).argmax())]
        return Fold(load, v, active, way / largest, bend / largest**2)


@dataclass(frozen=True)
class Branch:
    """v (n + 1, size) and active (n + 1, m) of states at even t; fold: its end, the last state, or None."""

    start: float
    end: float
    v: np.ndarray
    active: np.ndarray
    fold: Fold | None = None
    periodic: bool = False  # smooth sliding: one period, states stand evenly in the load, v less the load is periodic

    @property
    def intervals(self):
        return len(self.v) - 1

    @property
    def loads(self):
        """Of the states, (n + 1,) nm."""
        return self.load_at(np.linspace(0.0, 1.0, self.intervals + 1))

    def load_at(self, t):
        return self.start + (self.end - self.start) * (t if self.periodic else np.sin(0.5 * np.pi * t) ** 2)

    def weights(self, load):
        """Of the states in those at loads (k,), (k, n + 1); beyond the ends of the branch in those at its ends."""
        if self.periodic:
            return periodic_weights((load - self.start) / (self.end - self.start), self.intervals)
        return even_weights(place(self.start, self.end, load), self.intervals)

    def thinned(self):
        """The same with every second state."""
        return replace(self, v=self.v[::2], active=self.active[::2])

    def states(self, load, nodes):
        """Unknowns (k, size) at loads (k,), the first `nodes` of which move on with the load."""
        moving = np.zeros(self.v.shape[1])
        moving[:nodes] = 1.0
        return self.weights(load) @ (self.v - self.loads[:, None] * moving) + load[:, None] * moving


def place(start, end, load):
    """t (array) of loads on a branch."""
    part = np.clip((np.asarray(load, float) - start) / (end - start), 0.0, 1.0)
    return np.arcsin(np.sqrt(part)) * (2.0 / np.pi)


def even_weights(t, intervals):
    """Weights (k, n + 1) of values at n + 1 even places of [0, 1] in that at t (k,): Lagrange's, of STENCIL of them."""
    t = np.atleast_1d(np.asarray(t, float)) * intervals
    count = min(STENCIL, intervals + 1)
    low = np.clip(np.floor(t).astype(int) - (count - 1) // 2, 0, intervals + 1 - count)
    off = (t - low)[:, None] - np.arange(count)
    weights = np.ones((t.size, count))
    for i in range(count):
        for j in range(count):
            if i != j:
                weights[:, i] *= off[:, j] / (i - j)
    out = np.zeros((t.size, intervals + 1))
    np.put_along_axis(out, low[:, None] + np.arange(count), weights, axis=1)
    return out


def periodic_weights(t, intervals):
    """Weights (k, n + 1) of the values at n + 1 even places of a period [0, 1] in the Fourier series at t (k,)."""
    off = np.asarray(t, float)[:, None] - np.arange(intervals) / intervals
    q = 2.0 * np.pi * np.arange(1, (intervals + 1) // 2)
    weights = (1.0 + 2.0 * np.cos(off[:, :, None] * q).sum(axis=2)) / intervals
    if intervals % 2 == 0:
        weights += np.cos(np.pi * intervals * off) / intervals
    return np.append(weights, np.zeros((len(weights), 1)), axis=1)


def weights_near(places, at):
    """(slice of STENCIL ascending places about `at`, their Lagrange weights in the value there)."""
    low = int(np.searchsorted(places, at)) - STENCIL // 2
    low = max(0, min(low, len(places) - STENCIL))
    near = slice(low, low + STENCIL)
    return near, lagrange(places[near], at)
