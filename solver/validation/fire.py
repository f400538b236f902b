"""Two other motions to the same rests, to compare run times with: mass-weighted GFMD and FIRE.

Mass-weighted GFMD: every mode of the free layer moves equally fast (Zhou, Moseler & Mueser 2019,
doi:10.1103/PhysRevB.99.144103). FIRE, the fast inertial relaxation engine (Bitzek et al. 2006,
doi:10.1103/PhysRevLett.97.170201), with the same masses: modes move without friction while the power F.v is positive,
their velocity turned towards the force; otherwise they stop. NP1 has no potential, so nothing but that power decides.
Inertia is not damped: where a branch ends, FIRE may come to rest on another one than the damped motion.
"""

import numpy as np
from numba import njit

from ..continuation.gfmd import Gfmd
from ..continuation.motion import Motion

# Bitzek et al. 2006: steps before the time step grows, its growth and fall, mixing at the start and its fall.
N_MIN, F_INC, F_DEC, ALPHA, F_ALPHA = 5, 1.1, 0.5, 0.1, 0.99
START = 0.1  # of the longest stable step: Bitzek's dt_max is 10 of their first steps
SAFETY = 0.5  # of the longest stable step
PROBES = 6  # power iterations from a random direction; later ones go on from the last


class MassWeighted(Gfmd):
    """u'' = r - 2 u', r = U + C T(u) - u, for every mode: critical for all modes of the free layer at once."""

    def __init__(self, problem, damping, closed):
        super().__init__(problem, damping, closed)
        self._direction = None

    def _motion(self, dynamics, y, load):
        return _Weighted(dynamics, y, load, 1.0, self.closed)

    def _stiffness(self, dynamics, v, active):
        """Spectral radius of dr/du, by power iteration."""
        product, probes = self.problem.linearised(v, active).tangent, 1
        if self._direction is None or self._direction.size != v.size:
            self._direction, probes = np.random.default_rng(0).normal(size=v.size), PROBES
        for _ in range(probes):
            there = product(self._direction / max(np.linalg.norm(self._direction), 1e-300))
            self._direction = there
        return max(1.0, np.linalg.norm(self._direction))


class _Weighted(Motion):
    """The motion with mass K; `soften` takes the spectral radius of dr/du."""

    def soften(self, stiffness, pace=1.0):
        step = pace * SAFETY * 2.0 / np.sqrt(stiffness)
        if self._power is not None:
            self.change *= step / self.step
        whole, k, c = 1.0 + step, self.dynamics.stiffness, self.dynamics.compliance
        self.step, self._power = step, True
        self._keep = np.array([np.full(k.shape[1], (1.0 - step) / whole)] * 2 + [np.zeros(k.shape[1])])
        self._push = c * [[1.0], [1.0], [-1.0]] * (step * step / whole)


class Fire(MassWeighted):
    """Advances States by FIRE."""

    def _motion(self, dynamics, y, load):
        return _Engine(dynamics, y, load, 1.0, self.closed)


class _Engine(Motion):
    """FIRE in place of damped motion; `change` is the velocity."""

    def __init__(self, dynamics, y, *args):
        super().__init__(dynamics, y, *args)
        self._engine = None  # step, longest step, alpha, steps since the power was last negative
        signs = np.array([[1.0], [1.0], [-1.0]])  # as in `_product`
        self._both = dynamics.stiffness * signs, np.ascontiguousarray(dynamics.compliance)
        self._residual = np.empty_like(y)
        self._weight = np.full(y.shape[1], 2.0)  # of a mode and its conjugate in a sum over all wavenumbers
        self._weight[0] = 1.0
        if dynamics.problem.contact.nodes % 2 == 0:
            self._weight[-1] = 1.0

    def soften(self, stiffness, pace=1.0):
        limit = pace * SAFETY * 2.0 / np.sqrt(stiffness)
        if self._engine is None:
            self._engine = np.array([START * limit, limit, ALPHA, 0.0])
        self._engine[1] = limit
        self._engine[0] = min(self._engine[0], limit)

    def advance(self, active, steps):
        for _ in range(steps):
            force = self.dynamics.force(self.y, active, self.load)
            _fire(self.y, self.change, force, *self._both, self._weight, self._engine, self._residual)


@njit(cache=True, nogil=True)
def _product(c, x, z, q):
    """The matrix of mode q, c: (3, modes) rows xx, zz, c with xz = i c, zx = -i c, times (x, z)."""
    cx, cz, cc = c[0, q], c[1, q], c[2, q]
    return (
        complex(cx * x.real - cc * z.imag, cx * x.imag + cc * z.real),
        complex(cz * z.real + cc * x.imag, cz * z.imag - cc * x.real),
    )


@njit(cache=True, nogil=True)
def _residual_at(u, traction, c, q):
    """(r_x, r_z) = U + C T - u of mode q, of the force T + K U."""
    r_x, r_z = _product(c, traction[0, q], traction[1, q], q)
    r_x -= u[0, q]
    r_z -= u[1, q]
    return r_x, r_z


@njit(cache=True, nogil=True)
def _dot(a, b):
    return a.real * b.real + a.imag * b.imag


@njit(cache=True, nogil=True)
def _sums(u, v, traction, k, c, weight, r):
    """Fill r with C F, F = T - K (u - U); returns F.v, v.K v and F.C F, sums over all modes."""
    power = speed = force = 0.0
    for q in range(u.shape[1]):
        r_x, r_z = _residual_at(u, traction, c, q)
        f_x, f_z = _product(k, r_x, r_z, q)
        p_x, p_z = _product(k, v[0, q], v[1, q], q)
        power += weight[q] * (_dot(f_x, v[0, q]) + _dot(f_z, v[1, q]))
        speed += weight[q] * (_dot(p_x, v[0, q]) + _dot(p_z, v[1, q]))
        force += weight[q] * (_dot(f_x, r_x) + _dot(f_z, r_z))
        r[0, q], r[1, q] = r_x, r_z
    return power, speed, force


@njit(cache=True, nogil=True)
def _fire(u, v, traction, k, c, weight, engine, r):
    """One step of all modes, semi-implicit Euler; v: velocity; engine: as in `Fire`, in place; r: scratch."""
    power, speed, force = _sums(u, v, traction, k, c, weight, r)
    keep, turn = 0.0, 0.0
    if power > 0.0:
        keep, turn = 1.0 - engine[2], engine[2] * np.sqrt(speed / force)
        engine[3] += 1
        if engine[3] > N_MIN:
            engine[0] = min(engine[0] * F_INC, engine[1])
            engine[2] *= F_ALPHA
    elif speed > 0.0:
        engine[0] *= F_DEC
        engine[2] = ALPHA
        engine[3] = 0
    for q in range(u.shape[1]):
        for i in range(2):
            v[i, q] = keep * v[i, q] + (turn + engine[0]) * r[i, q]
            u[i, q] += engine[0] * v[i, q]
