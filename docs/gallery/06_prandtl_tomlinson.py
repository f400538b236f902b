"""A flat is the model of Prandtl and Tomlinson.

All nodes of a flat move alike, as one node that a spring pulls through the lattice. Its equilibria are a closed form.
The run follows them up to the largest displacement of the stage, U_x = 15.389 nm, and slips there.
"""

import numpy as np

from solver import Scene, simulate

flat = Scene(surface="flat", nodes=16, width=39.0625, height=64.0, phi_ratio=0.1, u_x_max=20.0, damping=np.inf)
result = simulate(flat)
shear = result.table[result.table["stage"] == "shear"]
number = result.first_slip.U_s

# The closed form: a node displaced by u feels every site within reach, and the layer is a spring of stiffness k.
u = np.linspace(0.0, 2.0 * flat.spacing, 400)
k = flat.shear_modulus / (flat.height * flat.width)  # GPa/nm
shears = (u[:, None] - flat.spacing * np.arange(-10, 13)) / flat.delta_t
traction = 2.0 * flat.phi_t / flat.delta_t * (shears * np.exp(-(shears**2))).sum(axis=1)


def draw(ax):
    """F over U_x: all equilibria of the closed form, and those that the run visits."""
    ax.plot(u + traction / k, traction * flat.width, color="silver", label="closed form")
    ax.plot(shear["U_x (nm)"], shear["F (N/m)"], ".", markersize=3, label="run")
    ax.set(xlabel="U_x (nm)", ylabel="F (N/m)")
    ax.legend()
