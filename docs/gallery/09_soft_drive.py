"""A soft drive slips later, at the same force.

A spring of 5 MPa/nm connects the stage with the top of the layer. Up to the slip, the contact passes the same states
as with a rigid drive. The stage is ahead by the stretch of the spring, so the first slip comes 18.12 nm later.
"""

from solver import Scene, simulate

rigid = Scene(delta_bar=0.2, u_x_max=40.0)
soft = rigid.changed(drive_t=5.0)  # MPa/nm
runs = {"rigid drive": simulate(rigid), "soft drive": simulate(soft)}
first = {name: run.first_slip for name, run in runs.items()}
number = first["soft drive"].U_s - first["rigid drive"].U_s
force = first["soft drive"].F_s / first["rigid drive"].F_s


def draw(ax):
    """F over the displacement of the stage."""
    for name, run in runs.items():
        shear = run.table[run.table["stage"] == "shear"]
        ax.plot(shear["U_x (nm)"], shear["F (N/m)"], label=name)
    ax.set(xlabel="U_x of the stage (nm)", ylabel="F (N/m)")
    ax.legend()
