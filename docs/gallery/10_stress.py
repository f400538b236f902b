"""The largest shear stress lies inside the layer.

A punch with hardly any adhesion is pressed onto the substrate. The largest shear stress is not at the surface but
below it. It is 0.301 of the largest pressure; the theory of Hertz for a cylinder gives 0.300.
"""

import numpy as np

from solver import Scene, simulate

result = simulate(Scene(phi_n=0.02, delta_n=0.2, delta_bar=2.0, u_x_max=0.0))
frame = result.frames[-1]
half = 0.5 * frame.A  # nm, half-width of the contact
stress = result.stress(0.0, z=np.linspace(0.0, 2.0 * half, 101))
shear = np.hypot(0.5 * (stress.xx - stress.zz), stress.xz)  # GPa, the largest over all directions
number = float(shear.max() / frame.T[1].max())
depth = float(stress.z[shear.max(axis=1).argmax()] / half)


def draw(ax):
    """Largest shear stress around the contact."""
    near = np.abs(stress.x) < 2.0 * half
    drawn = ax.contourf(stress.x[near], stress.z, shear[:, near], levels=20)
    ax.figure.colorbar(drawn, ax=ax, label="largest shear stress (GPa)")
    ax.set(xlabel="x (nm)", ylabel="height above the surface (nm)")
