"""The trailing edge peels more than the leading edge.

Both edges of a contact move inward before it slips. At the indentation delta_bar = 0.4, while the top moves by 12 nm,
the trailing edge peels 3.5 times as far as the leading edge. Under tension, at -0.1, the two edges are more alike.
"""

from solver import Scene, simulate


def peeled(delta_bar, u_x_max):
    """U_x, and how far the trailing and the leading edge have moved inward, all in nm."""
    edges = simulate(Scene(delta_bar=delta_bar, u_x_max=u_x_max)).edges
    trailing, leading = edges["x_trailing (nm)"], edges["x_leading (nm)"]
    return edges["U_x (nm)"], trailing - trailing.iloc[0], leading.iloc[0] - leading


runs = {"pressed, delta_bar 0.4": peeled(0.4, 12.0), "under tension, -0.1": peeled(-0.1, 9.0)}
_, trailing, leading = runs["pressed, delta_bar 0.4"]
number = float(trailing.iloc[-1] / leading.iloc[-1])


def draw(ax):
    """Inward movement of both edges over U_x."""
    for color, (name, (U_x, trailing, leading)) in zip(("C0", "C1"), runs.items(), strict=True):
        ax.plot(U_x, trailing, color=color, label=f"{name}: trailing")
        ax.plot(U_x, leading, "--", color=color, label="leading")
    ax.set(xlabel="U_x (nm)", ylabel="peeled (nm)")
    ax.legend()
