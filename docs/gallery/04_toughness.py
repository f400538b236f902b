"""A mix of opening and shear breaks the interface more easily.

The toughness is the energy release rate at which an edge advances. With phi_t = phi_n, opening weakens a spring
against shear, and shear weakens it against opening. At a mode angle of 45 degrees the toughness is 0.67 phi_n.
"""

import numpy as np

from solver import Scene, toughness

angles = np.arange(0.0, 80.0, 5.0)  # degrees; 0 is pure opening
curves = {ratio: toughness(Scene(phi_ratio=ratio), np.radians(angles)) for ratio in (0.5, 1.0, 2.0)}
number = float(toughness(Scene(), np.radians(45.0)) / Scene().phi_n)
potential = toughness(Scene(law="xu-needleman"), np.radians(angles))  # the same at every angle


def draw(ax):
    """Toughness over the mode angle."""
    for ratio, values in curves.items():
        ax.plot(angles, values, label=f"phi_t/phi_n = {ratio}")
    ax.plot(angles, potential, "k:", label="Xu and Needleman, 1.0")
    ax.set(xlabel="mode angle (degrees)", ylabel="toughness (N/m)")
    ax.legend()
