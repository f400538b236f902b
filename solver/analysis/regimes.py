"""The scenes of flat on flat at zero gap over stiffness and strength (Figs. 4, 5)."""

from math import inf

import numpy as np

from ..scene import LIMITS, Scene, SceneError
from .friction_laws import critical_modulus, friction, tau_max

MODULI, STRENGTHS = (10.0, 3000.0), (0.004, 4.0)  # E in GPa, phi_t in N/m: the line of E_c crosses the map
END = 40.0  # nm, of a run that shows curves: 16 lattice periods of the default


def flat(scene) -> Scene:
    """The scene as flat on flat at zero gap, with a rigid drive, overdamped as in the paper's Fig. 4."""
    flat = scene.changed(surface="flat", delta_bar=0.0, u_x_max=END, path="shear", hold="delta", damping=inf)
    return flat.changed(drive_t=inf, drive_n=inf)


def sliding(scene, E) -> Scene:
    """The flat at modulus E, GPa, sheared over two periods of steady sliding; raises SceneError."""
    stiffer = scene.changed(E=float(f"{E:.6g}"))
    # The flat slips at the latest where springs bear tau_max. Slips land between two increments: over a shorter path
    # with fewer slips, means change by up to 2 %.
    end = 2.5 * tau_max(scene) * stiffer.shear_compliance + 3.0 * scene.spacing
    # slips are located, however long the increments
    return stiffer.changed(u_x_max=float(f"{min(end, 1e4):.6g}"), du_x=0.2)


def mean_friction(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """(E/tau_max (k,), mean friction of Eq. 7 over w tau_max (k,)) of a flat, in closed form; raises SceneError.

    Mean friction depends only on this ratio and on the layer.
    """
    own = scene.changed(phi_n=2.0, phi_ratio=0.1)
    ratios = critical_modulus(own) / tau_max(own) * np.geomspace(1e-4, 10.0, 200)
    low, high = LIMITS["E"][:2]
    ratios = ratios[(ratios * tau_max(own) >= low) & (ratios * tau_max(own) <= high)]
    if ratios.size == 0:
        allowed = f"allowed here: one with friction between E = {low:g} and {high:g} GPa"
        raise SceneError("delta_t", own.delta_t, allowed, "make it smaller, or use fewer nodes")
    return ratios, np.array([friction(own.changed(E=ratio * tau_max(own))).mean * ratio for ratio in ratios])
