"""The cohesive laws, NP1 (paper Eq. 2-5; McGarry et al. 2014) and another, summed over the lattice sites in the window.

With NP1 a spring from a surface node to a lattice site, at tangential gap dt and normal gap dn, carries

    T_x =  2 phi_t/delta_t (dt/delta_t) exp(-dn/delta_n) exp(-dt^2/delta_t^2)
    T_z = - phi_n/delta_n  (dn/delta_n) exp(-dn/delta_n) exp(-dt^2/delta_t^2)

as traction on the layer. The law of Xu & Needleman (1993, q = 1, r = 0) has one factor more in T_x, 1 + dn/delta_n; for
phi_t = phi_n it has a potential. Both lattices have the period a, so the sum over sites depends on u_x only through its
distance r to the nearest site, and the Gaussians of all sites follow from exp(-r^2) and exp(2 a r) by recurrence.
Loops over nodes hold no branch and no call, so that they compile to vector instructions; NumPy takes the exponentials.
"""

import numpy as np

from ..continuation.compiled import kernel

DEEPEST = -50.0  # dn/delta_n: deeper nodes, which occur in iterates only, count as this deep; exp(50) is finite
# dn/delta_n: nodes farther away count as this far. They pull with 1e-24 of the strength, and no product of two such
# numbers leaves the range of double precision, where arithmetic is slow
REMOTEST = 60.0
OPENING = {"np1": 0.0, "xu-needleman": 1.0}  # c in the factor 1 + c dn of T_x
FARTHEST = 700.0  # argument of exp, beyond which a number of double precision is out of range soon
WORK = 10  # rows of the scratch array `work`

_fast = {"contract", "nsz", "arcp"}  # sums are not reordered, and NaN stays NaN


def law_constants(scene) -> np.ndarray:
    """`law` of the kernels, (7,): phi_n/delta_n, 2 phi_t/delta_t (GPa), delta_n, delta_t (nm), a/delta_t, window_t, c.

    T_x has the factor 1 + c dn: c is 0 for NP1, 1 for Xu-Needleman.
    An array, because numba unpacks a NamedTuple slowly compared with an evaluation.
    """
    strengths = scene.phi_n / scene.delta_n, 2.0 * scene.phi_t / scene.delta_t
    lengths = scene.delta_n, scene.delta_t, scene.spacing / scene.delta_t, scene.window_t
    return np.array([*strengths, *lengths, OPENING[scene.law]])


@kernel(fastmath=_fast, error_model="numpy")
def _exponents(u_x, u_z, profile, law, work):
    """Fill rows of work: 0 to 2 with -dn, -r^2 and 2 a r, 5 with dn, 6 with r, the distance of the nearest site."""
    delta_n, delta_t, a = law[2], law[3], law[4]
    for i in range(profile.size):
        x = u_x[i] / delta_t
        r = x - a * np.floor(x / a + 0.5)
        dn = min(max((profile[i] + u_z[i]) / delta_n, DEEPEST), REMOTEST)
        work[0, i], work[1, i], work[2, i] = -dn, max(-r * r, -FARTHEST), min(max(2.0 * a * r, -FARTHEST), FARTHEST)
        work[5, i], work[6, i] = dn, r


def window_sums(u_x, u_z, profile, law, work) -> None:
    """Fill rows of work (WORK, m): exp(-dn), sums of 1, dt and dt^2 times exp(-dt^2), and dn, in rows 0, 1, 3, 4, 5.

    u_x, u_z, profile: (m,) nm; dt in delta_t, dn in delta_n. Sums run over the sites |dt| <= window_t.
    """
    _exponents(u_x, u_z, profile, law, work)
    np.exp(work[:3], out=work[:3])  # vectorised, unlike the exp of Numba
    _window_sums(law, work)


@kernel(fastmath=_fast, error_model="numpy")
def _window_sums(law, work):
    a, window, m = law[4], law[5], work.shape[1]
    s0, up, s1, s2, r = work[1], work[2], work[3], work[4], work[6]
    down, ahead, behind = work[7], work[8], work[9]
    shrink = np.exp(-a * a)
    for i in range(m):
        down[i] = shrink / up[i]
        up[i] *= shrink
        ahead[i] = behind[i] = s0[i]
        s1[i] = -r[i] * s0[i]
        s2[i] = r[i] * r[i] * s0[i]
    shrink *= shrink
    for k in range(1, int((window + 0.5 * a) / a) + 1):
        for i in range(m):
            ahead[i] *= up[i]  # Gaussian of site k ahead from that of site k - 1; up, down: their ratios
            behind[i] *= down[i]
            up[i] *= shrink
            down[i] *= shrink
            front, back = k * a - r[i], k * a + r[i]
            g = ahead[i] if front <= window else 0.0
            h = behind[i] if back <= window else 0.0
            s0[i] += g + h
            s1[i] += front * g - back * h
            s2[i] += front * front * g + back * back * h


@kernel(fastmath=_fast, error_model="numpy")
def _tractions(work, law, T_x, T_z):
    normal, shear, c = law[0], law[1], law[6]
    e, s0, s1, dn = work[0], work[1], work[3], work[5]
    for i in range(T_x.size):
        T_x[i] = shear * s1[i] * (1.0 + c * dn[i]) * e[i]
        T_z[i] = -normal * dn[i] * s0[i] * e[i]


def tractions(u, profile, law, work, out) -> None:
    """Fill out (2, m), rows T_x and T_z, with the tractions of nodes displaced by u (2, m) nm, GPa.

    profile: undeformed gap, (m,) nm; law: `law_constants`; work: scratch, (WORK, m). Kernels get rows: slices of wider
    buffers then have the type of whole arrays, and compile once.
    """
    window_sums(u[0], u[1], profile, law, work)
    _tractions(work, law, out[0], out[1])


@kernel(fastmath=_fast, error_model="numpy")
def _tangents(work, law, out):
    normal, shear, delta_n, delta_t, c = law[0], law[1], law[2], law[3], law[6]
    e, s0, s1, s2, dn = work[0], work[1], work[3], work[4], work[5]
    for i in range(out.shape[1]):
        force = e[i]
        out[0, i] = -shear * (s0[i] - 2.0 * s2[i]) * (1.0 + c * dn[i]) * force / delta_t
        out[1, i] = -shear * s1[i] * (1.0 - c + c * dn[i]) * force / delta_n
        out[2, i] = -normal * dn[i] * 2.0 * s1[i] * force / delta_t
        out[3, i] = -normal * (1.0 - dn[i]) * s0[i] * force / delta_n


def tangents(u, profile, law, work, out) -> None:
    """Fill out (4, m), rows dT_x/du_x, dT_x/du_z, dT_z/du_x, dT_z/du_z, with tangents, GPa/nm; else as `tractions`.

    They are not symmetric, as NP1 has no potential; those of Xu-Needleman with phi_t = phi_n are.
    """
    window_sums(u[0], u[1], profile, law, work)
    _tangents(work, law, out)


@kernel
def _add_product(J, x, z, out_x, out_z):
    for i in range(x.size):
        a, b = x[i], z[i]
        out_x[i] += J[0, i] * a + J[1, i] * b
        out_z[i] += J[2, i] * a + J[3, i] * b


def add_product(J, w, out) -> None:
    """Add J w to out, (2, m) each; J: (4, m) as of `tangents`."""
    _add_product(J, w[0], w[1], out[0], out[1])


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
