"""A mix of opening and shear breaks the interface more easily.

The toughness is the energy release rate at which an edge advances. With phi_t = phi_n, opening weakens a spring
against shear, and shear weakens it against opening. At a mode angle of 45 degrees the toughness is 0.668 phi_n.
"""

import numpy as np

from solver import Scene, simulate, toughness

angles = np.arange(0.0, 80.0, 5.0)  # degrees; 0 is pure opening
curves = {ratio: toughness(Scene(phi_ratio=ratio), np.radians(angles)) for ratio in (0.5, 1.0, 2.0)}
number = float(toughness(Scene(), np.radians(45.0)) / Scene().phi_n)
edges = simulate(Scene(delta_bar=0.4, u_x_max=12.0)).edges[::5]


def draw(ax):
    """Toughness over the mode angle, and the energy release rate at the trailing edge of a punch."""
    for ratio, values in curves.items():
        ax.plot(angles, values, label=f"phi_t/phi_n = {ratio}")
    ax.plot(np.degrees(edges["psi_trailing (rad)"]), edges["J_trailing (N/m)"], "k.", label="edge of a punch")
    ax.set(xlabel="mode angle (degrees)", ylabel="toughness (N/m)")
    ax.legend()
