"""A weak interface slides smoothly.

A flat slips only if its springs soften faster than the layer and the drive can follow. With E = 70 GPa it slips above
phi_t/phi_n = 0.0027, and slides smoothly below. The threshold is proportional to E.
"""

from solver import Scene, simulate

# 16 nodes are enough for a flat, whose nodes all move alike. The layer is 2500 nm thick, as in the default.
flat = Scene(surface="flat", nodes=16, width=39.0625, height=64.0, u_x_max=1.5)
moduli = [35.0, 70.0, 140.0]  # GPa
halvings = 8


def threshold(E):
    """The phi_ratio above which the flat slips, by bisection between 0 and 1e-4 E/GPa."""
    smooth, slips = 0.0, 1e-4 * E
    for _ in range(halvings):
        ratio = 0.5 * (smooth + slips)
        if simulate(flat.changed(E=E, phi_ratio=ratio)).first_slip:
            slips = ratio
        else:
            smooth = ratio
    return 0.5 * (smooth + slips)


thresholds = [threshold(E) for E in moduli]
number = thresholds[1]


def draw(ax):
    """The threshold over E."""
    ax.plot(moduli, thresholds, "o-")
    ax.text(50.0, 0.004, "stick-slip")
    ax.text(110.0, 0.0015, "smooth sliding")
    ax.set(xlabel="E (GPa)", ylabel="phi_t/phi_n", xlim=(0.0, 150.0), ylim=(0.0, 0.006))
