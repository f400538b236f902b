"""The cohesive laws, NP1 (paper Eq. 2-5; McGarry et al. 2014) and another, summed over the lattice sites in the window.

With NP1 a spring from a surface node to a lattice site, at tangential gap dt and normal gap dn, carries

    T_x =  2 phi_t/delta_t (dt/delta_t) exp(-dn/delta_n) exp(-dt^2/delta_t^2)
    T_z = - phi_n/delta_n  (dn/delta_n) exp(-dn/delta_n) exp(-dt^2/delta_t^2)

as traction on the layer. The law of Xu & Needleman (1993, q = 1, r = 0) has one factor more in T_x, 1 + dn/delta_n; for
phi_t = phi_n it has a potential. Both lattices have the period a, so the sum over sites depends on u_x only through its
distance r to the nearest site, and the Gaussians of all sites follow from exp(-r^2) and exp(2 a r) by recurrence.
`kernels` has the loops over nodes.
"""

import numpy as np

from . import kernels
from .kernels import WORK

OPENING = {"np1": 0.0, "xu-needleman": 1.0}  # c in the factor 1 + c dn of T_x


def law_constants(scene) -> np.ndarray:
    """`law` of the kernels, (7,): phi_n/delta_n, 2 phi_t/delta_t (GPa), delta_n, delta_t (nm), a/delta_t, window_t, c.

    T_x has the factor 1 + c dn: c is 0 for NP1, 1 for Xu-Needleman.
    An array, because numba unpacks a NamedTuple slowly compared with an evaluation.
    """
    strengths = scene.phi_n / scene.delta_n, 2.0 * scene.phi_t / scene.delta_t
    lengths = scene.delta_n, scene.delta_t, scene.spacing / scene.delta_t, scene.window_t
    return np.array([*strengths, *lengths, OPENING[scene.law]])


def tractions(u, profile, law, work, out) -> None:
    """Fill out (2, m), rows T_x and T_z, with the tractions of nodes displaced by u (2, m) nm, GPa.

    profile: undeformed gap, (m,) nm; law: `law_constants`; work: scratch, (WORK, m). Kernels get rows: slices of wider
    buffers then have the type of whole arrays, and compile once.
    """
    kernels.tractions(u[0], u[1], profile, law, work, out[0], out[1])


def tangents(u, profile, law, work, out) -> None:
    """Fill out (4, m), rows dT_x/du_x, dT_x/du_z, dT_z/du_x, dT_z/du_z, with tangents, GPa/nm; else as `tractions`.

    They are not symmetric, as NP1 has no potential; those of Xu-Needleman with phi_t = phi_n are.
    """
    kernels.tangents(u[0], u[1], profile, law, work, out)


def add_product(J, w, out) -> None:
    """Add J w to out, (2, m) each; J: (4, m) as of `tangents`."""
    kernels.add_product(J, w[0], w[1], out[0], out[1])


def alike(tangents) -> bool:
    """Whether all nodes have the same tangents, (4, m) as of `tangents`, to 1e-7 of the largest: round-off is 1e-13."""
    return bool(np.ptp(tangents, axis=1).max() <= 1e-7 * np.abs(tangents).max())


def traction(scene, ux, gap) -> np.ndarray:
    """(T_x, T_z), GPa, of single nodes displaced by ux (nm) at a gap (nm); arrays of one shape, or numbers."""
    return _free(tractions, 2, scene, ux, gap)


def tangent(scene, ux, gap) -> np.ndarray:
    """The tangents of single nodes, rows as in `tangents`, GPa/nm; arguments as in `traction`."""
    return _free(tangents, 4, scene, ux, gap)


def _free(kernel, rows, scene, ux, gap):
    """The rows of a kernel for nodes without a surface."""
    u = np.array(np.broadcast_arrays(ux, gap), float)
    m, out = u[0].size, np.empty((rows, *u[0].shape))
    kernel(u.reshape(2, m), np.zeros(m), law_constants(scene), np.empty((WORK, m)), out.reshape(rows, m))
    return out
