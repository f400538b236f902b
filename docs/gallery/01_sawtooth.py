"""A sliding punch slips once per lattice site.

The friction force is a sawtooth. Its slips lie 2.4414 nm apart: the node spacing, which is the period of the lattice.
A state moved on by one site is an equilibrium again, so every tooth repeats the first one.
"""

import numpy as np

from solver import Scene, simulate

result = simulate(Scene(delta_bar=0.2, u_x_max=30.0))
shear = result.table[result.table["stage"] == "shear"]
slips = result.slips[result.slips["stage"] == "shear"]
number = float(np.diff(slips["U_s (nm)"]).mean())


def draw(ax):
    """F over U_x, with the slips."""
    ax.plot(shear["U_x (nm)"], shear["F (N/m)"], label="run")
    ax.plot(slips["U_s (nm)"], slips["F_s (N/m)"], "v", label="slips")
    ax.set(xlabel="U_x (nm)", ylabel="F (N/m)")
    ax.legend()
