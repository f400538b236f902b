"""The springs and the layer in extended precision: reference quantities that share no code with `mechanics`.

The springs are summed site by site in NumPy. The layer's stiffness is the textbook quotient of hyperbolic functions.
Its transforms cover the whole cell.
"""

from functools import lru_cache
from math import ceil
from typing import NamedTuple

import numpy as np

from solver.run.frame import Frame
from solver.scene import Scene

LONG = np.longdouble  # 64 bits of mantissa on x86; where it has 53, the checks are as exact as the solver
HALF_PLANE = 40.0  # q h, beyond which the quotients are constant: exp(-2 q h) (q h)^2 < 1e-31
PI = LONG("3.14159265358979323846264")


class Patch(NamedTuple):
    """The nodes of a frame: the slice of the cell, u (2, m) and gap (m,) in nm."""

    part: slice
    u: np.ndarray
    gap: np.ndarray


class Layer(NamedTuple):
    """(K_xx, K_zz, K_c), GPa/nm, and (C_xx, C_zz, C_c), nm/GPa, of all modes, (3, nodes//2 + 1) each."""

    stiffness: np.ndarray
    compliance: np.ndarray


def patch_of(scene: Scene, frame: Frame) -> Patch:
    """The Patch of a Frame."""
    part = slice(frame.first, frame.first + frame.u.shape[1])
    u = frame.u.astype(LONG)
    return Patch(part, u, scene.profile[part] + u[1])


def springs(scene: Scene, ux, gap) -> tuple[np.ndarray, np.ndarray]:
    """T (2, m) GPa, paper Eq. 2-4, of nodes displaced by ux (m,) at that gap (m,), nm; and the springs' size (m,), GPa.

    The size is the same sum with |dn| + 1 and |dt| + 1 for the factors that pass through zero. It is at least that of
    one spring at dt = 0: a node between two sites may have springs only at the edge of the window.
    """
    count, shear, _, size = _sums(scene, ux)
    dn, t, n = _strengths(scene, gap)
    c = _opening(scene)
    gross = 2 * t * (1 + c * np.abs(dn)) * np.maximum(size, 1) + n * (np.abs(dn) + 1) * np.maximum(count, 1)
    return np.array([2 * t * (1 + c * dn) * shear, -n * dn * count]), gross


def tangent(scene: Scene, ux, gap) -> np.ndarray:
    """dT_c/du_d of each node, (2, 2, m) GPa/nm; arguments as in `springs`."""
    count, shear, turn, _ = _sums(scene, ux)
    dn, t, n = _strengths(scene, gap)
    d_t, d_n, c = LONG(scene.delta_t), LONG(scene.delta_n), _opening(scene)
    t_x, t_z = t * (1 + c * dn), t * (1 - c + c * dn)
    return np.array(
        [[2 * t_x * turn / d_t, -2 * t_z * shear / d_n], [-2 * n * dn * shear / d_t, n * (dn - 1) * count / d_n]]
    )


def _sums(scene, ux):
    """Sums over the sites of 1, dt, 2 dt^2 - 1 and |dt| + 1, each times exp(-dt^2), (4, m)."""
    a, ux = LONG(scene.spacing), np.asarray(ux, LONG)
    reach = ceil(scene.window_t * scene.delta_t / scene.spacing) + 1
    sites = np.rint(ux / a) + np.arange(-reach, reach + 1)[:, None]
    dt = (sites * a - ux) / LONG(scene.delta_t)
    bell = np.where(np.abs(dt) <= scene.window_t, np.exp(-dt * dt), LONG(0))
    return np.array([(factor * bell).sum(axis=0) for factor in (1, dt, 2 * dt * dt - 1, np.abs(dt) + 1)])


def _opening(scene):
    """c in the factor 1 + c dn/delta_n of T_x."""
    return LONG({"np1": 0, "xu-needleman": 1}[scene.law])


def _strengths(scene, gap):
    """dn, and phi/delta exp(-dn), GPa, of the tangential and the normal spring; (m,) each."""
    dn = np.asarray(gap, LONG) / LONG(scene.delta_n)
    force = np.exp(-dn)
    return dn, LONG(scene.phi_t) / LONG(scene.delta_t) * force, LONG(scene.phi_n) / LONG(scene.delta_n) * force


def stiffness(q, height, E, nu, kind=LONG, deepest=HALF_PLANE) -> np.ndarray:
    """(K_xx, K_zz, K_c), GPa/nm, at q > 0 (1/nm) of a layer of that height (nm), by the textbook formulas.

    kind: the arithmetic. deepest: the largest q h in the quotients; inf: as printed, inf or nan where that overflows.
    """
    q, h, E, nu = np.asarray(q, kind), kind(height), kind(E), kind(nu)
    G, kappa, y = E / (2 * (1 + nu)), 3 - 4 * nu, np.minimum(q * h, kind(deepest))
    with np.errstate(all="ignore"):
        s, c = np.sinh(y), np.cosh(y)
        d = kappa**2 * s**2 - y**2
        k_xx, k_zz = (4 * G * (1 - nu) * q * (kappa * s * c + sign * y) / d for sign in (-1, 1))
        return np.array([k_xx, k_zz, 2 * G * q * (kappa * (1 - 2 * nu) * s**2 - y**2) / d])


def inverse(blocks) -> np.ndarray:
    """(zz, xx, c)/(xx zz - c^2) of rows xx, zz, c: `stiffness` to compliance and back."""
    xx, zz, c = blocks
    return np.array([zz, xx, c]) / (xx * zz - c**2)


def layer(scene: Scene) -> Layer:
    """The Layer of a scene, with its drive."""
    drive = scene.drive_t, scene.drive_n
    return _layer(scene.nodes, scene.width, scene.height * LONG(scene.width), scene.E, scene.nu, drive)


@lru_cache(maxsize=4)
def _layer(nodes, width, h, E, nu, drive):
    q = 2 * PI * np.arange(1, nodes // 2 + 1, dtype=LONG) / LONG(width)
    k, G, nu = np.empty((3, nodes // 2 + 1), LONG), LONG(E) / (2 * (1 + LONG(nu))), LONG(nu)
    k[:, 1:] = stiffness(q, h, E, nu)
    k[:, 0] = G / h, 2 * G * (1 - nu) / ((1 - 2 * nu) * h), 0
    k[:2, 0] = 1 / (1 / k[:2, 0] + 1000 / np.array(drive, LONG))  # springs in series, MPa/nm
    k[2, -1] *= nodes % 2  # the coupling of the Nyquist mode has no real phase
    return Layer(k, inverse(k))


def displacement(scene: Scene, T) -> tuple[np.ndarray, float]:
    """C T (2, nodes), nm, of T (2, nodes), GPa; and the sum of |C| |T| over all modes, nm, which bounds it."""
    c_xx, c_zz, c_c = layer(scene).compliance
    x, z = np.fft.rfft(T, axis=1)
    out = np.fft.irfft(np.array([c_xx * x + 1j * c_c * z, c_zz * z - 1j * c_c * x]), scene.nodes, axis=1)
    terms = (c_xx + np.abs(c_c)) * np.abs(x) + (c_zz + np.abs(c_c)) * np.abs(z)
    return out, 2.0 * float(terms.sum()) / scene.nodes
