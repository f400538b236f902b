"""The node spacing is physics, not a mesh size.

The nodes form a lattice, as the sites do. If the springs of a node reach several sites, their shears cancel. With
half the spacing the largest friction force falls to 0.076 of its value. With twice the length delta_t it falls to
0.040.
"""

from solver import Scene, simulate

scenes = {
    "default": Scene(u_x_max=14.0),
    "half the spacing": Scene(u_x_max=14.0, nodes=2048),
    "twice delta_t": Scene(u_x_max=14.0, delta_t=2.0),
}
# The largest force, as a slip may come later: with twice delta_t, at 0.012 of the default's first slip.
runs = {name: simulate(scene) for name, scene in scenes.items()}
largest = {name: max(frame.F for frame in run.frames) for name, run in runs.items()}
number = largest["half the spacing"] / largest["default"]
doubled = largest["twice delta_t"] / largest["default"]


def draw(ax):
    """F over U_x of the three lattices."""
    for name, run in runs.items():
        shear = run.table[run.table["stage"] == "shear"]
        ax.plot(shear["U_x (nm)"], shear["F (N/m)"], label=name)
    ax.set(xlabel="U_x (nm)", ylabel="F (N/m)")
    ax.legend()
