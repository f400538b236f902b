"""A frame rechecked: residual, tractions and forces, by the sums of `extended`."""

from dataclasses import dataclass

import numpy as np
from extended import LONG, displacement, patch_of, springs

from solver.run.frame import Frame
from solver.scene import Scene

EPS = float(np.finfo(float).eps)
ROUNDING = 64.0  # roundings of one evaluation that may add up: some ten per exponential, log2(nodes) per transform
SHIFTS = 8.0  # roundings, of half a unit in the last place, between a displacement and its traction


@dataclass(frozen=True)
class Recheck:
    """residual and floor, nm: the recomputed residual, and the largest one that round-off in float64 can cause.

    traction, forces: deviation of the frame's T over the springs' largest size, of F_bar and L_bar over its sum.
    """

    residual: float
    floor: float
    traction: float
    forces: float


def recheck(scene: Scene, frame: Frame) -> Recheck:
    """The Recheck of one Frame of a Scene."""
    part, own, gap = patch_of(scene, frame)
    T, gross = springs(scene, own[0], gap)
    top = np.array([[frame.U_x], [-frame.delta]], LONG)
    u, largest = displacement(scene, _on_cell(scene, part, T))
    u += top
    forces = np.array([-T[0].sum(), T[1].sum()]) / (scene.nodes * LONG(scene.E)) - (frame.F_bar, frame.L_bar)
    terms = largest + float(np.abs(top).max()) + float(np.abs(own).max())
    return Recheck(
        residual=float(np.abs(u[:, part] - frame.u).max()),
        floor=ROUNDING * EPS * terms + _rounding(scene, frame, T, gross),
        traction=float(np.abs(T - frame.T).max()) / (float(gross.max()) or 1.0),
        forces=float(np.abs(forces).max()) * scene.nodes * scene.E / (float(gross.sum()) or 1.0),
    )


def _on_cell(scene, part, field):
    """A field (2, m) of the patch on all nodes, zero elsewhere."""
    whole = np.zeros((2, scene.nodes), LONG)
    whole[:, part] = field
    return whole


def _rounding(scene, frame, T, gross):
    """nm: the change of C T by the roundings of shift, gap and the sum over springs (where terms cancel) in float64.

    SHIFTS roundings of half a unit in the last place, at random for each node; all nodes alike where they move alike.
    """
    part, u, gap = patch_of(scene, frame)
    alike = scene.surface == "flat" or gap.size == 1
    sign = np.ones((4, 1)) if alike else np.random.default_rng(0).uniform(-1.0, 1.0, (4, gap.size))
    share = SHIFTS * 0.5 * EPS * sign.astype(LONG)
    ux, gap = u[0] + share[0] * np.abs(u[0]), gap + share[1] * (np.abs(u[1]) + scene.profile[part])
    change = springs(scene, ux, gap)[0] - T + share[2:] * gross
    return float(np.abs(displacement(scene, _on_cell(scene, part, change))[0][:, part]).max())
