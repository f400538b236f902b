"""A slip jumps over an unstable branch.

The equilibria of a flat are one curve. A strong interface folds it: the run slips where the curve turns back, and no
experiment follows the unstable part, dashed. At phi_ratio = 0.0865 both folds meet in a cusp, and the jump is gone.
"""

from solver import Scene, boundary, simulate, unstable_branch

flat = Scene(surface="flat", delta_bar=0.0, nodes=32, width=78.125, height=1.0, u_x_max=6.0, du_x=0.02)
border = boundary(flat.changed(phi_ratio=0.3), "phi_ratio")
number = border.value

ratios = {"slips": 3.0 * number, "at the boundary": number, "slides smoothly": 0.5 * number}
runs = {label: simulate(flat.changed(phi_ratio=ratio)) for label, ratio in ratios.items()}
between = [unstable_branch(runs["slips"], slip) for slip in range(2)]


def draw(ax):
    """F over U_x: three runs, and the unstable branch between two slips."""
    for label, result in runs.items():
        shear = result.table[result.table["stage"] == "shear"]
        ax.plot(shear["U_x (nm)"], shear["F (N/m)"], label=label)
    for branch in between:
        ax.plot(branch.U_x, branch.F_bar * flat.width * flat.E, "--", color="C0")
    ax.set(xlabel="U_x (nm)", ylabel="F (N/m)")
    ax.legend()
