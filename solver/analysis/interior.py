"""Displacement and stress inside the layer, mode by mode in closed form from the traction on its lower surface.

The mode exp(i q x), y = q h, eta = q z, zeta = y - eta: displacements that vanish at the top z = h are sums of

    (u_x / i, u_z) = (zeta cosh zeta + kappa sinh zeta, -zeta sinh zeta)
                 and (zeta sinh zeta, kappa sinh zeta - zeta cosh zeta)

(Navier, plane strain, kappa = 3 - 4 nu). sigma_xz = -T_x and sigma_zz = -T_z at z = 0 give their amplitudes. At depth
these sums cancel to all digits. Written with cosh and sinh of y + zeta and of eta they do not, and scaled by exp(-2 y)
they do not overflow. q = 0 is the limit: uniform stress, displacement linear in z.
"""

from math import cosh, exp, expm1, sinh
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..continuation.compiled import kernel
from ..mechanics.layer import stiffness
from ..run.frame import Frame
from ..threads import computation


class Stress(NamedTuple):
    """Stress in the layer (GPa, tension positive) at x (m,) and z (k,), nm: xx, zz and xz (k, m).

    x counts from the middle of the cell, z from the lower surface up. Plane strain: sigma_yy = nu (xx + zz).
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    xx: NDArray[np.float64]
    zz: NDArray[np.float64]
    xz: NDArray[np.float64]

    def __repr__(self) -> str:
        return f"Stress(x: {self.x.size} nodes, z: {self.z.size} heights, 0 .. {self.z.max():g} nm; xx, zz, xz in GPa)"


@computation
def stress_in(frame: Frame, z: NDArray[np.float64] | None = None) -> Stress:
    """The Stress of a Frame at all nodes and the heights z (k,) nm, by default 101 even ones, to round-off.

    Raises ValueError for a z outside the layer.
    """
    scene, height = frame.scene, frame.scene.height * frame.scene.width
    z = np.linspace(0.0, height, 101) if z is None else np.atleast_1d(np.asarray(z, float))
    if not (z.min() >= 0.0 and z.max() <= height):
        raise ValueError(f"z = {z.min():g} .. {z.max():g}: allowed: 0 .. {height:g} nm; leave out what is outside")
    T = np.zeros((2, scene.nodes))
    T[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    T_q = np.fft.rfft(T, norm="forward")
    q = wavenumbers(scene, T_q.shape[1])
    if scene.nodes % 2 == 0:  # the Nyquist mode is held by a sine, which vanishes at the nodes
        k_xx, k_zz, k_c = (float(k[0]) for k in stiffness(q[-1:], height, scene.E, scene.nu))
        x, up = T_q[:, -1].real
        T_q[:, -1] = x - 1j * k_c * up / k_zz, up + 1j * k_c * x / k_xx
    even, odd = np.moveaxis(transfer(q, z, height, scene.shear_modulus, scene.nu)[2:], 1, 0)
    modes = even * T_q[[1, 1, 0], None] + 1j * odd * T_q[[0, 0, 1], None]
    return Stress(scene.x - scene.width / 2, z, *np.fft.irfft(modes, scene.nodes, norm="forward"))


def wavenumbers(scene, modes) -> NDArray[np.float64]:
    """q of the first modes, 1/nm."""
    return 2.0 * np.pi / scene.width * np.arange(modes)


@kernel
def shape_of(q, z, height, nu) -> tuple:
    """(y, eta, zeta, r, P, p, C, S): as above, r = 2 zeta y + 4 (1-nu)(1-2nu), and functions of depth.

    P, p = kappa (cosh, sinh)(y + zeta)/(2B) and C, S = (cosh, sinh)(eta)/(2B); B = kappa cosh^2 y + y^2 + (1-2nu)^2.
    """
    y, eta, zeta, kappa = q * height, q * z, q * (height - z), 3.0 - 4.0 * nu
    down, r = exp(-eta), 2.0 * zeta * y + 4.0 * (1.0 - nu) * (1.0 - 2.0 * nu)
    if zeta > 50.0:  # q (h - z): the top reflects exp(-2 zeta) (q h)^2 < 1e-29
        return y, eta, zeta, r, down, down, 0.0, 0.0
    up = exp(-y - zeta)
    a, b, t = down * down, up * up, down * up
    scale = 1.0 / (kappa * (1.0 + t) ** 2 + 4.0 * t * (y * y + (1.0 - 2.0 * nu) ** 2))
    down, up = scale * down, scale * up
    return y, eta, zeta, r, kappa * down * (1.0 + b), kappa * down * (1.0 - b), up * (1.0 + a), up * (1.0 - a)


@kernel
def normal(shape) -> tuple[float, float]:
    """sigma_zz of a mode: (even) T_z + i (odd) T_x."""
    y, eta, zeta, r, P, p, C, S = shape
    return -(P + eta * p + (y + zeta) * S + (1.0 + r) * C), eta * (P + C) + r * S


@kernel
def shear(shape) -> tuple[float, float]:
    """sigma_xz of a mode: (even) T_x + i (odd) T_z."""
    y, eta, zeta, r, P, p, C, S = shape
    return -(P - eta * p - (y + zeta) * S + (1.0 + r) * C), eta * (P + C) - r * S


@kernel
def lateral(shape) -> tuple[float, float]:
    """sigma_xx of a mode: (even) T_z + i (odd) T_x."""
    y, eta, zeta, r, P, p, C, S = shape
    even = -(P - eta * p + (3.0 * y - zeta) * S + (1.0 - r) * C)
    return even, 2.0 * p - eta * P + (3.0 * y + zeta) * C - (2.0 + r) * S


@kernel
def displacement(q, z, height, G, nu) -> tuple:
    """u_x = (even) T_x + i (odd) T_z and u_z = (even) T_z + i (odd) T_x of a mode, less those of the top; four numbers.

    D_s, D_c = (sinh, cosh)(y + zeta) - (sinh, cosh)(eta) keep all digits near the top.
    """
    if q == 0.0:
        return (height - z) / G, 0.0, (1.0 - 2.0 * nu) * (height - z) / (2.0 * (1.0 - nu) * G), 0.0
    y, eta, zeta, _, _, _, C, S = shape_of(q, z, height, nu)
    kappa, t = 3.0 - 4.0 * nu, exp(-2.0 * y)
    scale = 1.0 / (kappa * (1.0 + t) ** 2 + 4.0 * t * (y * y + (1.0 - 2.0 * nu) ** 2))
    D_s = -expm1(-2.0 * zeta) * exp(-eta) * scale
    D_c = -expm1(-2.0 * y) * D_s
    D_s *= 1.0 + t
    less = 2.0 * zeta * C - D_s
    if y < 1.0:  # the difference cancels, and is all of u_z for nu -> 1/2
        less = 4.0 * t * scale * (cosh(y) * _less(zeta) - zeta * sinh(y) * sinh(zeta))
    x_even = 2.0 * zeta * y * S + kappa * eta * D_c - (2.0 - 2.0 * nu) * (2.0 * zeta * C + kappa * D_s)
    z_even = 2.0 * zeta * y * S - kappa * eta * D_c + (2.0 - 2.0 * nu) * (less - 2.0 * (1.0 - 2.0 * nu) * D_s)
    both = 2.0 * zeta * y * C - (1.0 - 2.0 * nu) * kappa * D_c
    apart = kappa * eta * D_s - (2.0 - 4.0 * nu) * zeta * S
    unit = 0.5 / (G * q)
    return -x_even * unit, -(both + apart) * unit, -z_even * unit, (both - apart) * unit


@kernel
def _less(zeta):
    """zeta cosh zeta - sinh zeta without cancellation, for 0 <= zeta <= 1."""
    term, total = zeta**3 / 3.0, 0.0
    for k in range(1, 10):  # the tenth term is below 1e-17 of the first
        total += term
        term *= zeta * zeta * (k + 1) / (k * (2 * k + 2) * (2 * k + 3))
    return total


@kernel
def transfer(q, z, height, G, nu) -> NDArray[np.float64]:
    """(5, 2, nz, modes) real: u_x, u_z (nm/GPa), sigma_xx, sigma_zz, sigma_xz at depths z (nm) per traction of modes q.

    Column 0, even: the shares of T_x in u_x and sigma_xz, of T_z in the others. Column 1, odd, times i: the shares of
    the other traction. q in 1/nm, height in nm, G in GPa.
    """
    out = np.empty((5, 2, z.size, q.size))
    for r in range(z.size):
        for k in range(q.size):
            shape = shape_of(q[k], z[r], height, nu)
            out[0, 0, r, k], out[0, 1, r, k], out[1, 0, r, k], out[1, 1, r, k] = displacement(q[k], z[r], height, G, nu)
            out[2, 0, r, k], out[2, 1, r, k] = lateral(shape)
            out[3, 0, r, k], out[3, 1, r, k] = normal(shape)
            out[4, 0, r, k], out[4, 1, r, k] = shear(shape)
    return out
