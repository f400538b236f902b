"""FIRE, the fast inertial relaxation engine, on surface modes with mass K (Bitzek et al. 2006,
doi:10.1103/PhysRevLett.97.170201; for boundary elements Zhou, Moseler & Mueser 2019, doi:10.1103/PhysRevB.99.144103).

Modes move without friction while the power F.v is positive, their velocity turned towards the force; otherwise they
stop. NP1 has no potential, so nothing but that power decides. Inertia is not damped: where a branch ends, FIRE may come
to rest on another one than the damped motion.
"""

import numpy as np
from numba import njit

from .gfmd import MassWeighted, product_at, residual_at

# Bitzek et al. 2006: steps before the time step grows, its growth and fall, mixing at the start and its fall.
N_MIN, F_INC, F_DEC, ALPHA, F_ALPHA = 5, 1.1, 0.5, 0.1, 0.99
START = 0.1  # of the longest stable step: Bitzek's dt_max is 10 of their first steps


class Fire(MassWeighted):
    """Advances States of one scene by FIRE; under the contract of `Gfmd`."""

    def __init__(self, scene, first, size, leave_out=frozenset()):
        super().__init__(scene, first, size, leave_out)
        self._engine = np.empty(4)  # step, longest step, alpha, steps since the power was last negative
        self._stiffness = self._modes.stiffness * [[1.0], [1.0], [-1.0]]  # signs as in `product_at`
        self._residual = np.empty_like(self._spectrum)
        self._weight = np.full(self._modes.k_xx.size, 2.0)  # of a mode and its conjugate in a sum over all wavenumbers
        self._weight[0] = 1.0
        if scene.nodes % 2 == 0:
            self._weight[-1] = 1.0

    def _begin(self, modes, limit):
        self._motion = np.zeros_like(modes)  # here the velocity
        self._engine[:] = START * limit, limit, ALPHA, 0

    def _limit(self, limit):
        self._engine[1] = limit
        self._engine[0] = min(self._engine[0], limit)

    def _move(self, modes, top):
        both = self._stiffness, self._modes.compliance
        _fire(modes, self._motion, self._spectrum, *both, top, self._weight, self._engine, self._residual)


@njit(cache=True, nogil=True)
def _dot(a, b):
    return a.real * b.real + a.imag * b.imag


@njit(cache=True, nogil=True)
def _sums(u, v, traction, k, c, top, weight, r):
    """Fill r with C F, F = T - K (u - U); returns F.v, v.K v and F.C F, sums over all modes."""
    power = speed = force = 0.0
    for q in range(u.shape[1]):
        r_x, r_z = residual_at(u, traction, c, top, q)
        f_x, f_z = product_at(k, r_x, r_z, q)
        p_x, p_z = product_at(k, v[0, q], v[1, q], q)
        power += weight[q] * (_dot(f_x, v[0, q]) + _dot(f_z, v[1, q]))
        speed += weight[q] * (_dot(p_x, v[0, q]) + _dot(p_z, v[1, q]))
        force += weight[q] * (_dot(f_x, r_x) + _dot(f_z, r_z))
        r[0, q], r[1, q] = r_x, r_z
    return power, speed, force


@njit(cache=True, nogil=True)
def _fire(u, v, traction, k, c, top, weight, engine, r):
    """One step of all modes, semi-implicit Euler; v: velocity; engine: as in `Fire`, in place; r: scratch."""
    power, speed, force = _sums(u, v, traction, k, c, top, weight, r)
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
