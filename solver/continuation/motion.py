"""The damped motion of the surface from the end of a branch to rest: what decides which equilibrium a slip reaches.

    u'' = K (U - u) + T(u) - gamma u',  gamma = damping times that critical for the slowest mode  (paper section 2.1)

Explicit steps would have to follow the fastest mode. Instead every mode of stiffness k is given the mass

    M = 1 + dt^2/4 (K + sigma),  friction gamma M^1/2,

which is Newmark's average acceleration for the layer and an interface of stiffness sigma: modes slow against dt, which
decide where a slip ends, move as before, and fast ones follow them. Diagonal in Fourier space, it costs nothing.
Stable while the interface is softer than sigma + 4/dt^2. Newmark 1959; mass as in Zhou, Moseler & Mueser 2019,
doi:10.1103/PhysRevB.99.144103.

Infinite damping: the overdamped limit of uniform mobility, gamma u' = K (U - u) + T(u), by linearly implicit steps.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, isfinite, log2, sqrt

import numpy as np
from numba import njit


@dataclass(frozen=True)
class Limits:
    """Of the motion.

    step: times the period/(2 pi) of a node on closed springs; from 1/2 on, slips of little damping stop short. weak:
    damping below which steps get shorter with it, as errors of energy decide how many sites inertia carries. sigma:
    of the interface's stiffness in the masses, over the closed one, at least. safe: of the stiffness at which steps
    grow unstable; idle: powers of two by which the stiffness may fall before they are adapted. explicit: of the longest
    stable step. creep: step of the overdamped limit, over the time in which closed springs decay.
    """

    step: float = 0.4
    weak: float = 0.6
    sigma: float = 1.0
    safe: float = 0.6
    idle: int = 2
    explicit: float = 0.5
    creep: float = 0.25


LIMITS = Limits()


class Motion:
    """y (2, modes) and its change per step, under a fixed load; begins at rest. Masses as above."""

    def __init__(self, dynamics, y, load, damping, closed):
        """closed: stiffness of the interaction at its closed place, GPa/nm; damping: over critical."""
        self.dynamics, self.y, self.change = dynamics, y, np.zeros_like(y)
        self.closed, self.friction = closed, damping * dynamics.critical
        self._step = LIMITS.step / sqrt(closed) * min(1.0, damping / LIMITS.weak)
        self._top = dynamics.top(load)
        self._power, self._mass, self._starts = None, None, True
        self._tables = lru_cache(maxsize=16)(self._of_stiffness)

    def soften(self, stiffness, pace=1.0):
        """Adapt the steps to an interaction of that largest stiffness, GPa/nm; the kinetic energy stays.

        pace: of the steps, over the usual ones.
        """
        power = ceil(log2(max(stiffness, self.closed) / LIMITS.safe)), pace
        if self._power is not None and self._power[1] == pace and 0 <= self._power[0] - power[0] <= LIMITS.idle:
            return  # steps that change to and fro would heat what moves
        mass, self._keep, self._push, self.step = self._tables(*power)
        if self._power is not None:
            self.change = _applied(
                _blocks(mass, lambda m: m**-0.5), _applied(_blocks(self._mass, np.sqrt), self.change)
            )
        self._power, self._mass = power, mass
        self.time = 1.0 / sqrt(float(mass[:2].min()))  # that a step takes for the slowest modes, which follow heavier

    def _of_stiffness(self, power, pace):
        """(mass / step^2, keep, push, step): change' = keep change + push force, in rows xx, zz, c each."""
        step, k = pace * self._step, self.dynamics.stiffness
        largest = float((np.maximum(k[0], k[1]) + np.abs(k[2])).max())
        stiffness = 2.0**power * LIMITS.safe
        if 2.0 / 3.0 * largest + stiffness <= LIMITS.safe * 4.0 / step**2:
            return self._newmark(step, lambda k: 1.0 + step * step / 12.0 * k)
        sigma = max(0.0, 2.0**power - 4.0 / step**2) + LIMITS.sigma * self.closed
        return self._newmark(step, lambda k: 1.0 + 0.25 * step * step * (k + sigma))

    def _newmark(self, step, mass):
        k = self.dynamics.stiffness

        def friction(x):
            return 0.5 * self.friction * step * np.sqrt(mass(x))

        keep = _blocks(k, lambda x: (mass(x) - friction(x)) / (mass(x) + friction(x)))
        push = _blocks(k, lambda x: step * step / (mass(x) + friction(x)))
        return _blocks(k, lambda x: mass(x) / step**2), keep, push, step

    def advance(self, active, steps):
        """So many steps."""
        for _ in range(steps):
            force = self.dynamics.force(self.y, active)
            _step(self.y, self.change, force, self.dynamics.stiffness, self._keep, self._push, self._top)
            if self._starts:  # from rest, the first change is that of half a step
                self.change *= 0.5
                self.y -= self.change
                self._starts = False

    def drive(self, load):
        """Go on under another load."""
        self._top = self.dynamics.top(load)

    def swing(self):
        """y of the amplitudes that the velocities would reach against the layer alone: K^-1/2 u'."""
        least = 0.25 * self.dynamics.critical**2  # a mode without stiffness moves as the slowest of the others
        root = _blocks(self.dynamics.stiffness, lambda k: np.maximum(k, least) ** -0.5)
        return _applied(root, self.change / self.step)


class ExplicitMotion(Motion):
    """Verlet steps of unit masses, as the paper has them."""

    def _of_stiffness(self, power, pace):
        k = self.dynamics.stiffness
        largest = float((np.maximum(k[0], k[1]) + np.abs(k[2])).max())
        step = pace * LIMITS.explicit * 2.0 / sqrt(largest + 2.0**power * LIMITS.safe)
        return self._newmark(step, np.ones_like)


class Creep(Motion):
    """The overdamped limit: friction is one, and there are no masses."""

    def _of_stiffness(self, power, pace):
        k, sigma = self.dynamics.stiffness, 2.0**power
        step = pace * LIMITS.creep / sigma
        mass = _blocks(k, lambda x: np.full_like(x, step**-2))
        return mass, np.zeros_like(k), _blocks(k, lambda x: step / (1.0 + step * (x + sigma))), step

    def swing(self):
        """None: nothing goes on by inertia."""
        return np.zeros_like(self.y)


def motion_of(dynamics, y, load, damping, closed):
    """The motion of a slip at that damping, over critical; inf: the overdamped limit."""
    return (Motion if isfinite(damping) else Creep)(dynamics, y, load, damping, closed)


def _blocks(k, function):
    """A function of the symmetric 2 x 2 blocks k (3, modes), rows xx, zz, c."""
    mean, half = 0.5 * (k[0] + k[1]), 0.5 * (k[0] - k[1])
    radius = np.hypot(half, k[2])
    above, below = function(mean + radius), function(mean - radius)
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.where(radius > 1e-14 * np.abs(mean), 0.5 * (above - below) / radius, 0.0)
    middle = 0.5 * (above + below)
    return np.array([middle + slope * half, middle - slope * half, slope * k[2]])


def _applied(blocks, y):
    """The product of blocks [[xx, -i c], [i c, zz]] with y (2, modes)."""
    xx, zz, c = blocks
    return np.array([xx * y[0] - 1j * c * y[1], zz * y[1] + 1j * c * y[0]])


@njit(cache=True, nogil=True)
def _step(y, change, force, k, keep, push, top):
    """One step of all modes in place, from the traction `force` (2, modes)."""
    for q in range(y.shape[1]):
        x, z = y[0, q], y[1, q]
        if q == 0:
            x -= top[0]
            z -= top[1]
        f_x = force[0, q] - k[0, q] * x + 1j * k[2, q] * z
        f_z = force[1, q] - k[1, q] * z - 1j * k[2, q] * x
        d_x, d_z = change[0, q], change[1, q]
        n_x = keep[0, q] * d_x - 1j * keep[2, q] * d_z + push[0, q] * f_x - 1j * push[2, q] * f_z
        n_z = keep[1, q] * d_z + 1j * keep[2, q] * d_x + push[1, q] * f_z + 1j * push[2, q] * f_x
        change[0, q], change[1, q] = n_x, n_z
        y[0, q] += n_x
        y[1, q] += n_z
