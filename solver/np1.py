"""The NP1 cohesive law (paper Eq. 2-5; McGarry et al. 2014), summed over the lattice sites in the window.

A spring from a surface node to a lattice site has the tangential gap dt and the normal gap dn and carries

    T_x =  2 phi_t/delta_t (dt/delta_t) exp(-dn/delta_n) exp(-dt^2/delta_t^2)
    T_z = - phi_n/delta_n  (dn/delta_n) exp(-dn/delta_n) exp(-dt^2/delta_t^2)

as traction on the layer. Both lattices have the period a, so the sum over sites depends on u_x only through its
distance r to the nearest site, and the Gaussians of all sites follow from exp(-r^2) and exp(2 a r) by recurrence.
"""

import numpy as np
from numba import njit

DEEPEST = -50.0  # dn/delta_n; deeper overclosure (iterates only, never a solution) is continued as if at this depth


def law_constants(scene):
    """The numbers a kernel needs: [phi_n/delta_n, 2 phi_t/delta_t, delta_n, delta_t, a/delta_t, window_t]."""
    return np.array(
        [
            scene.phi_n / scene.delta_n,
            2.0 * scene.phi_t / scene.delta_t,
            scene.delta_n,
            scene.delta_t,
            scene.spacing / scene.delta_t,
            scene.window_t,
        ]
    )


@njit(cache=True, nogil=True)
def lattice_sums(x, a, window):
    """Sums of 1, dt and dt^2 times exp(-dt^2) over the sites |dt| <= window around x; all lengths in delta_t."""
    r = x - a * np.rint(x / a)
    s0 = s1 = s2 = 0.0
    if a > 3.0:  # few sites; exp(2 a r) could overflow
        for k in range(-int((window + r) / a) - 1, int((window + r) / a) + 2):
            dt = k * a - r
            if abs(dt) <= window:
                e = np.exp(-dt * dt)
                s0 += e
                s1 += dt * e
                s2 += dt * dt * e
        return s0, s1, s2
    e0 = np.exp(-r * r)
    s0, s1, s2 = e0, -r * e0, r * r * e0
    shrink = np.exp(-a * a)
    forward = np.exp(2.0 * a * r)
    up, down = forward * shrink, shrink / forward  # ratio of the next Gaussian to this one, ahead and behind
    shrink *= shrink
    ahead = behind = e0
    k = 1
    while k * a - abs(r) <= window:
        ahead *= up
        behind *= down
        up *= shrink
        down *= shrink
        dt = k * a - r
        if abs(dt) <= window:
            s0 += ahead
            s1 += dt * ahead
            s2 += dt * dt * ahead
        dt = -k * a - r
        if abs(dt) <= window:
            s0 += behind
            s1 += dt * behind
            s2 += dt * dt * behind
        k += 1
    return s0, s1, s2


@njit(cache=True, nogil=True)
def traction(ux, gap, law):
    """(T_x, T_z) on one node, GPa, from its tangential displacement and gap in nm."""
    dn = max(gap / law[2], DEEPEST)
    s0, s1, _ = lattice_sums(ux / law[3], law[4], law[5])
    e = np.exp(-dn)
    return law[1] * s1 * e, -law[0] * dn * s0 * e


@njit(cache=True, nogil=True)
def tangent(ux, gap, law):
    """(dT_x/du_x, dT_x/du_z, dT_z/du_x, dT_z/du_z) of one node, GPa/nm; not symmetric, NP1 has no potential."""
    dn = max(gap / law[2], DEEPEST)
    s0, s1, s2 = lattice_sums(ux / law[3], law[4], law[5])
    e = np.exp(-dn)
    return (
        -law[1] * (s0 - 2.0 * s2) * e / law[3],
        -law[1] * s1 * e / law[2],
        -law[0] * dn * e * 2.0 * s1 / law[3],
        -law[0] * (1.0 - dn) * e * s0 / law[2],
    )


@njit(cache=True, nogil=True)
def tractions(u, profile, active, law, out):
    """Traction of every node. u, out: (2, >= m) nm and GPa; profile, active: (m,); inactive nodes get zero."""
    for i in range(profile.size):
        if active[i]:
            out[0, i], out[1, i] = traction(u[0, i], profile[i] + u[1, i], law)
        else:
            out[0, i] = 0.0
            out[1, i] = 0.0


@njit(cache=True, nogil=True)
def tangents(u, profile, active, law, out):
    """Tangent of every node, out: (4, m), rows xx, xz, zx, zz in GPa/nm; inactive nodes get zero."""
    for i in range(profile.size):
        if active[i]:
            out[0, i], out[1, i], out[2, i], out[3, i] = tangent(u[0, i], profile[i] + u[1, i], law)
        else:
            out[0, i] = out[1, i] = out[2, i] = out[3, i] = 0.0
