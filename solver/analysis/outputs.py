"""F_bar, L_bar and A_bar as functions of the tractions on a patch, with their derivatives by these."""

import numpy as np

from ..run.frame import contact_area, forces, least_repulsion, on_nodes

NAMES = ("F_bar", "L_bar", "A_bar")


def values(scene, T):
    """(F_bar, L_bar, A_bar) of T (2, m), GPa."""
    T = on_nodes(scene, T)
    return np.array([*forces(scene, T), contact_area(scene, T)])


def gradients(scene, T):
    """Their derivatives by T, (3, 2, m) per GPa."""
    m, out = T.shape[1], np.zeros((3, 2, T.shape[1]))
    scale = 1.0 / (scene.nodes * scene.E) if m > 1 else 1.0 / scene.E
    out[0, 0], out[1, 1] = -scale, scale
    if m > 1:
        out[2, 1] = _area(scene, T[1])
    return out


def _area(scene, T_z):
    """d A_bar/d T_z (m,), per GPa: of the two nodes at each edge of a contact, between which it is interpolated."""
    m, n, out = T_z.size, scene.nodes, np.zeros(T_z.size + 2)
    T = np.concatenate([[0.0], T_z, [0.0]]) if m < n else np.concatenate([T_z[-1:], T_z, T_z[:1]])
    T -= least_repulsion(scene)
    i = np.arange(m + 1 if m < n else m)
    for p, q in ((i, i + 1), (i + 1, i)):  # repulsion at p, none at q: p - q apart, of which p/(p - q) is in contact
        edge = (T[p] > 0.0) & (T[q] <= 0.0)
        p, q = p[edge], q[edge]
        square = (T[p] - T[q]) ** 2
        np.add.at(out, p, -T[q] / square)
        np.add.at(out, q, T[p] / square)
    if m == n:
        out[-2] += out[0]
    return out[1:-1] / n


def over_own(scene, name, found, by):
    """Derivatives `by` (4, ...) of U_x, F_bar, L_bar and A_bar, `found`, by a parameter, as forces and areas change.

    The forces over the E and width of the scene itself, and the area over its width, whatever these become.
    """
    per_unit = {"E": np.array([0.0, 1.0, 1.0, 0.0]) / scene.E, "width": np.array([0.0, 1.0, 1.0, 1.0]) / scene.width}
    return by + (found.T * per_unit[name]).T if name in per_unit else by


def explicit(scene, found, change):
    """What F_bar, L_bar and A_bar, `found` (3, ...), change by at fixed tractions, per unit: forces are over w E."""
    return (-found.T / scene.E * [1.0, 1.0, 0.0]).T if change.name == "E" else np.zeros_like(found)
