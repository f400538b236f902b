"""Derivatives of F_bar, L_bar and A_bar by the tractions on a patch, and by parameters at fixed tractions."""

import numpy as np
from numpy.typing import NDArray

from ..run.frame import least_repulsion
from ..scene import Scene
from .partial import Change

Floats = NDArray[np.float64]
NAMES = ("F_bar", "L_bar", "A_bar")


def gradients(scene: Scene, T: Floats) -> Floats:
    """Derivatives of F_bar, L_bar and A_bar by T (2, m), (3, 2, m) per GPa."""
    m, out = T.shape[1], np.zeros((3, 2, T.shape[1]))
    scale = 1.0 / (scene.nodes * scene.E) if m > 1 else 1.0 / scene.E
    out[0, 0], out[1, 1] = -scale, scale
    if m > 1:
        out[2, 1] = _area(scene, T[1])
    return out


def _area(scene, T_z):
    """d A_bar/d T_z (m,), per GPa; nonzero for the two nodes at each edge, between which the area is interpolated."""
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


def over_own(scene: Scene, name: str, outputs: Floats, by: Floats) -> Floats:
    """Derivatives of U_x, forces and area by a parameter, from those `by` (4, ...) of U_x, F_bar, L_bar and A_bar.

    outputs (4, ...): the values. The results refer to forces over the present w E, and to the area over the present w.
    """
    per_unit = {"E": np.array([0.0, 1.0, 1.0, 0.0]) / scene.E, "width": np.array([0.0, 1.0, 1.0, 1.0]) / scene.width}
    return by + (outputs.T * per_unit[name]).T if name in per_unit else by


def explicit(scene: Scene, outputs: Floats, change: Change) -> Floats:
    """Derivatives of F_bar, L_bar and A_bar, `outputs` (3, ...), at fixed tractions, as the forces are over w E."""
    return (-outputs.T / scene.E * [1.0, 1.0, 0.0]).T if change.name == "E" else np.zeros_like(outputs)
