"""The damped motion of the surface from the end of a branch to rest, which decides what equilibrium a slip reaches.

    u'' = K (U - u) + T(u) - gamma u',  gamma = damping times that critical for the slowest mode  (paper section 2.1)

Explicit steps would have to resolve the fastest mode. Here steps of central differences give each mode the mass

    M = 1 + dt^2/4 (K + sigma),  friction gamma M^1/2.

This is Newmark's average acceleration for the layer and an interface of stiffness sigma. Modes slow against dt decide
where a slip ends: they move as with unit mass. Fast modes follow them. The mass is diagonal in Fourier space, so it
costs nothing. Steps are stable while the interface is softer than sigma + 4/dt^2. Where the layer is soft against dt,
M = 1 + dt^2/12 K gives the frequencies of its modes to the fourth order in dt.

Infinite damping is the overdamped limit of uniform mobility, gamma u' = K (U - u) + T(u), by linearly implicit steps.
Source: Newmark 1959; mass as in Zhou, Moseler & Mueser 2019, doi:10.1103/PhysRevB.99.144103.
"""

from copy import copy
from functools import cached_property
from math import ceil, log2, sqrt

import numpy as np

from .compiled import call, kernel

# With half and twice of each, slips land alike (tests/bench/constants.py). A "closed" node touches springs in
# registry, where they are stiffest.
STEP = 0.4  # over period/(2 pi) of a closed node; from 0.5 on, weakly damped slips stop too early
# Largest stiffness of the interface, over that where steps become unstable: until the next check it may stiffen by two
# thirds. 0.3 takes 3 % more evaluations.
SAFE = 0.6


class Motion:
    """Coordinates y, complex (2, modes), and their change per step, from rest, under a `load`, nm, that may change."""

    least = 1.0  # stiffness of the interface, over the closed one, below which steps grow no more

    def __init__(self, dynamics, y, load, damping, closed):
        """closed: stiffness of closed springs (see STEP), GPa/nm; damping: over critical."""
        self.dynamics, self.y, self.change = dynamics, y, np.zeros_like(y)
        self.closed, self.friction = closed, damping * dynamics.critical
        # shorter below critical damping, where errors of energy decide by how many sites the surface slips. Not longer
        # above it: nodes of the contact still move as fast, and slips of one site landed elsewhere
        self._step = STEP / sqrt(closed) * min(damping, 1.0)
        self.load = load
        self._power: tuple | None = None
        self._mass, self._starts = None, True
        self._tables: dict[tuple, tuple] = {}  # of powers of two of the stiffness: a slip takes fewer than 16

    def copy(self) -> "Motion":
        """An independent copy, which may go on with other steps."""
        other = copy(self)
        other.y, other.change, other._tables = self.y.copy(), self.change.copy(), {}
        return other

    def soften(self, stiffness, pace=1.0) -> None:
        """Adapt masses and steps to an interaction of that largest stiffness, GPa/nm; kinetic energy is kept.

        pace: factor of the usual steps.
        """
        power = ceil(log2(max(stiffness, self.least * self.closed) / SAFE)), pace
        if self._power is not None and self._power[1] == pace and 0 <= self._power[0] - power[0] <= 2:
            return  # frequent changes would add energy
        if power not in self._tables:
            self._tables[power] = self._of_stiffness(*power)
        mass, self._keep, self._push, self.step = self._tables[power]
        if self._power is not None:
            root_energy = _applied(of_blocks(self._mass, np.sqrt), self.change)
            self.change = _applied(of_blocks(mass, lambda m: m**-0.5), root_energy)
        self._power, self._mass = power, mass
        self.time = 1.0 / sqrt(float(mass[:2].min()))  # per step; with masses above one, of the slowest modes

    def _of_stiffness(self, power, pace):
        """(mass / step^2, keep, push, step): the next change is keep change + push force; rows xx, zz, c each."""
        step = pace * self._step
        if 2.0 / 3.0 * self._stiffest() + 2.0**power * SAFE <= SAFE * 4.0 / step**2:
            return self._newmark(step, lambda k: 1.0 + step * step / 12.0 * k)
        sigma = max(0.0, 2.0**power - 4.0 / step**2) + self.closed
        return self._newmark(step, lambda k: 1.0 + 0.25 * step * step * (k + sigma))

    def _stiffest(self):
        """A bound on the stiffness of any mode of the layer, GPa/nm."""
        k = self.dynamics.stiffness
        return float((np.maximum(k[0], k[1]) + np.abs(k[2])).max())

    def _newmark(self, step, mass):
        """As `_of_stiffness`; mass: a function of a mode's stiffness."""
        k = self.dynamics.stiffness

        def friction(x):
            return 0.5 * self.friction * step * np.sqrt(mass(x))

        keep = of_blocks(k, lambda x: (mass(x) - friction(x)) / (mass(x) + friction(x)))
        push = of_blocks(k, lambda x: step * step / (mass(x) + friction(x)))
        return of_blocks(k, lambda x: mass(x) / step**2), keep, push, step

    def advance(self, steps) -> None:
        """Make `steps` steps; a force evaluation each."""
        first = steps if not self._starts else 1
        self._make(first)
        if self._starts:  # from rest, the first change is half that of a step
            self.change *= 0.5
            self.y -= self.change
            self._starts = False
            self._make(steps - first)

    def _make(self, steps):
        """Make `steps` like steps, in one compiled loop if the dynamics can."""
        tables = self.dynamics.stiffness, self._keep, self._push
        compiled = self.dynamics.compiled(self.load)
        if compiled:
            _steps(*compiled, steps, self.y, self.change, *tables)
            self.dynamics.evaluated(steps)
            return
        for _ in range(steps):
            _step(self.y, self.change, self.dynamics.force(self.y, self.load), *tables)

    def swing(self) -> np.ndarray:
        """Amplitudes in y that the modes would reach by their velocities against the layer alone: K^-1/2 u'."""
        return _applied(self._softness, self.change) / self.step

    @cached_property
    def _softness(self):
        """K^-1/2; it stays the same during a motion."""
        least = 0.25 * self.dynamics.critical**2  # k_min, also for the uniform mode, which a held load leaves free
        return of_blocks(self.dynamics.stiffness, lambda k: np.maximum(k, least) ** -0.5)


class ExplicitMotion(Motion):
    """Verlet steps of unit masses, as in the paper."""

    def _of_stiffness(self, power, pace):
        stiffest = self._stiffest() + 2.0**power * SAFE
        step = pace / sqrt(stiffest)  # half of the longest stable one: until the next check the interface may stiffen
        return self._newmark(step, np.ones_like)


class Creep(Motion):
    """The overdamped limit, without masses, by linearly implicit steps; the unit of time makes gamma one."""

    least = 2.0**-10  # under a soft drive surfaces fall from afar, where a step is T over this stiffness

    def _of_stiffness(self, power, pace):
        k, sigma = self.dynamics.stiffness, 2.0**power
        step = 0.25 * pace / sigma  # over the time in which a closed node relaxes; 0.125 takes 3 % more steps
        mass = of_blocks(k, lambda x: np.full_like(x, step**-2))
        return mass, np.zeros_like(k), of_blocks(k, lambda x: step / (1.0 + step * (x + sigma))), step

    def swing(self) -> np.ndarray:
        """Zero: without inertia, nothing goes on."""
        return np.zeros_like(self.y)


def of_blocks(k, function) -> np.ndarray:
    """A matrix function of the Hermitian 2 x 2 blocks k (3, modes), rows xx, zz, c, from its values at eigenvalues."""
    mean, half = 0.5 * (k[0] + k[1]), 0.5 * (k[0] - k[1])
    radius = np.hypot(half, k[2])
    above, below = function(mean + radius), function(mean - radius)
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.where(radius > 1e-14 * np.abs(mean), 0.5 * (above - below) / radius, 0.0)
    middle = 0.5 * (above + below)
    return np.array([middle + slope * half, middle - slope * half, slope * k[2]])


def _applied(blocks, y):
    """The product of blocks [[xx, -i c], [i c, zz]] with y (2, modes), a new array."""
    out = np.empty_like(y)
    _multiply(blocks, y, out)
    return out


@kernel(fastmath={"contract", "nsz"})
def _multiply(blocks, y, out):
    for q in range(y.shape[1]):
        out[0, q] = _i_less(0j, -blocks[0, q], y[0, q], blocks[2, q], y[1, q])
        out[1, q] = _i_less(0j, -blocks[1, q], y[1, q], -blocks[2, q], y[0, q])


@kernel(fastmath={"contract", "nsz"})
def _i_less(f, a, x, b, z):
    """f - a x - i b z, of complex f, x and z."""
    return complex(f.real - a * x.real + b * z.imag, f.imag - a * x.imag - b * z.real)


@kernel
def _steps(function, context, force, steps, y, change, k, keep, push):
    """That many steps with the force of `Dynamics.compiled`."""
    for _ in range(steps):
        call(function, context, y.ctypes.data, force.ctypes.data)
        _step(y, change, force, k, keep, push)


@kernel(fastmath={"contract", "nsz"})
def _step(y, change, force, k, keep, push):
    """One step of all modes in place, under the `force` (2, modes) of all but the layer.

    Products with i are written in real numbers: Numba would multiply by 0 + i, and not in vector instructions.
    """
    for q in range(y.shape[1]):
        x, z, d_x, d_z = y[0, q], y[1, q], change[0, q], change[1, q]
        f_x = _i_less(force[0, q], k[0, q], x, -k[2, q], z)
        f_z = _i_less(force[1, q], k[1, q], z, k[2, q], x)
        n_x = _i_less(_i_less(0j, -keep[0, q], d_x, keep[2, q], d_z), -push[0, q], f_x, push[2, q], f_z)
        n_z = _i_less(_i_less(0j, -keep[1, q], d_z, -keep[2, q], d_x), -push[1, q], f_z, -push[2, q], f_x)
        change[0, q], change[1, q] = n_x, n_z
        y[0, q], y[1, q] = x + n_x, z + n_z
