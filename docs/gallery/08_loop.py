"""A friction loop costs the energy that its slips lose.

A flat is pulled to one side, back, and forth again. The loop closes, so its ends store the same elastic energy. The
work of the stage, 100.98 nN (1 nN = 1 nJ per metre of depth), is the area of the loop. Its eight slips lose all of
it.
"""

import numpy as np

from solver import Scene, simulate, work_of

flat = Scene(
    surface="flat", nodes=16, width=39.0625, height=64.0, phi_ratio=0.1, damping=np.inf, path="loop", u_x_max=20.0
)
result = simulate(flat)
table, work = result.table, work_of(result.frames)
ends = [np.flatnonzero(table["stage"] == stage)[-1] for stage in ("shear", "forth")]
loop = table.iloc[ends[0] : ends[1] + 1]
number = float(work[ends[1]] - work[ends[0]])


def draw(ax):
    """F over U_x; the loop encloses the work."""
    ax.fill(loop["U_x (nm)"], loop["F (N/m)"], alpha=0.2)
    ax.plot(loop["U_x (nm)"], loop["F (N/m)"])
    ax.set(xlabel="U_x (nm)", ylabel="F (N/m)")
