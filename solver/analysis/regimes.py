"""The scenes of flat on flat at zero gap over stiffness and strength (Figs. 4, 5)."""

from math import inf

from ..scene import Scene
from .friction_laws import tau_max

MODULI, STRENGTHS = (10.0, 3000.0), (0.004, 4.0)  # E in GPa, phi_t in N/m: the line of E_c crosses the map
END = 40.0  # nm, of a run that shows curves: 16 lattice periods of the default
STEP = 0.2  # delta_t, increments of a run that gives the friction: slips are located, however long the increments
# Times the shear at which springs bear tau_max, where the flat slips at the latest; and lattice periods beyond. Slips
# land between two increments: with 1 and 3, fewer of them, means change by up to 2 %.
SHEAR, PERIODS = 2.5, 3


def flat(scene) -> Scene:
    """The scene as flat on flat at zero gap, with a rigid drive, overdamped as in the paper's Fig. 4."""
    flat = scene.changed(surface="flat", delta_bar=0.0, u_x_max=END, path="shear", hold="delta", damping=inf)
    return flat.changed(drive_t=inf, drive_n=inf)


def sliding(scene, E) -> Scene:
    """The flat at modulus E, GPa, sheared over two periods of steady sliding; raises SceneError."""
    stiffer = scene.changed(E=float(f"{E:.6g}"))
    end = SHEAR * tau_max(scene) * stiffer.shear_compliance + PERIODS * scene.spacing
    return stiffer.changed(u_x_max=float(f"{min(end, 1e4):.6g}"), du_x=STEP)
