"""A profile from a file equals the built-in surface.

A profilometer writes lines about itself, units, and two columns. This text holds a cosine wave with an amplitude of 5
nm. The punch slips first at F = 177.53 N/m, as the built-in wave of the same shape does.
"""

import numpy as np

from solver import Scene, read_profile, simulate

x = np.linspace(0.0, 0.4, 161)  # µm
z = 5.0 * np.cos(2.0 * np.pi * x / 0.4)  # nm; summits face the substrate
rows = [f"{along:.4f};{height:.4f}".replace(".", ",") for along, height in zip(x, z, strict=True)]
text = "\n".join(["Instrument;stylus", "Speed;2 µm/s", "x (µm);z (nm)", *rows])

profile = read_profile(text)
size = {"width": profile.length, "nodes": 160, "delta_bar": 0.3, "u_x_max": 20.0}
result = simulate(Scene(surface="measured", measured=profile, **size))
built_in = simulate(Scene(surface="wave", amplitude=5.0, waves=1, **size))
number = result.first_slip.F_s


def draw(ax):
    """F over U_x of both surfaces."""
    for run, style, name in ((result, "-", "from the text"), (built_in, "--", "built in")):
        shear = run.table[run.table["stage"] == "shear"]
        ax.plot(shear["U_x (nm)"], shear["F (N/m)"], style, label=name)
    ax.set(xlabel="U_x (nm)", ylabel="F (N/m)")
    ax.legend()
