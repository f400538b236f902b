"""Displacement and stress inside the layer as the sum over all modes, to round-off: what pictures are held against."""

from dataclasses import dataclass

import numpy as np

from solver.analysis.interior import transfer, wavenumbers
from solver.mechanics.layer import stiffness

CHUNK = 512  # modes of one matrix product: some MB


@dataclass(frozen=True)
class Body:
    """Displacement u (2, nz, nx) in nm, x above z, and stress (3, nz, nx) in GPa: sigma_xx, sigma_zz, sigma_xz.

    At the points x (nx,) and z (nz,) in nm; plane strain, so that sigma_yy = nu (sigma_xx + sigma_zz).
    """

    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    stress: np.ndarray


def surface_modes(scene, first, traction):
    """Amplitudes T_q (2, nodes//2 + 1), GPa: T = Re sum of T_q exp(i q x), every mode but q = 0 counted twice.

    At Nyquist the surface moves by cosines, each by its own traction/K as in `layer.Modes`; the traction that holds its
    partner is a sine, which vanishes at the nodes: with it the mode is an exact solution inside, like all others.
    """
    T = np.zeros((2, scene.nodes))
    traction = np.asarray(traction, float)
    T[:, first : first + traction.shape[1]] = traction
    T_q = np.fft.rfft(T, norm="forward")
    if scene.nodes % 2 == 0:
        q = wavenumbers(scene, T_q.shape[1])[-1:]
        k_xx, k_zz, k_c = (float(k[0]) for k in stiffness(q, scene.height * scene.width, scene.E, scene.nu))
        x, z = 0.5 * T_q[:, -1].real  # there is no -q beside it
        T_q[:, -1] = x - 1j * k_c * z / k_zz, z + 1j * k_c * x / k_xx
    return T_q


def inside(scene, first, traction, load, x, z):
    """Body at the points x (nx,) and z (nz,) in nm, 0 <= z <= h, to round-off: the sum over all modes.

    traction (2, m), GPa, on the nodes from `first` on, none elsewhere; load (U_x, U_z) of the top, nm: a Frame's
    (U_x, -delta). Raises ValueError where z leaves the layer.
    """
    x, z = np.asarray(x, float), np.asarray(z, float)
    height = scene.height * scene.width
    if z.size and not (z.min() >= 0.0 and z.max() <= height):
        raise ValueError(f"z = {z.min():g} .. {z.max():g}: allowed: 0 .. {height:g} nm, the layer; leave out the rest")
    T_q = surface_modes(scene, first, traction)
    T_q[:, 1:] *= 2.0  # the modes of -q
    q = wavenumbers(scene, T_q.shape[1])
    fields = np.zeros((5, z.size, x.size))
    for k in range(0, q.size, CHUNK):
        part = slice(k, k + CHUNK)
        even, odd = np.moveaxis(transfer(q[part], z, height, scene.shear_modulus, scene.nu), 1, 0)
        # rows u_x, u_z, sigma_xx, sigma_zz, sigma_xz: `even` answers to T_x in the first and last, to T_z in the others
        own, other = T_q[[0, 1, 1, 1, 0], None, part], T_q[[1, 0, 0, 0, 1], None, part]
        mode = even * own + 1j * odd * other
        turns = np.outer(np.arange(k, k + mode.shape[2]), x / scene.width % 1.0)
        phase = np.exp(2j * np.pi * (turns % 1.0))
        fields += mode.real @ phase.real - mode.imag @ phase.imag
    return Body(x, z, fields[:2] + np.asarray(load, float)[:, None, None], fields[2:])


def mean_stress(stress, nu):
    """(sigma_xx + sigma_yy + sigma_zz)/3 = (1 + nu)(sigma_xx + sigma_zz)/3, GPa, of stress (3, ...): tension > 0."""
    return (1.0 + nu) / 3.0 * (stress[0] + stress[1])


def principal_difference(stress):
    """sigma_1 - sigma_2 in the plane, GPa, of stress (3, ...): twice the largest shear, what a polariscope shows."""
    return np.hypot(stress[1] - stress[0], 2.0 * stress[2])
