"""What Python draws, templates explain and scripts change, declared once: names, marks and colours.

Colours are variables of style.css, marks are classes of it; dashes and markers are Bokeh's. Columns and fields of
packed frames are declared in service/packing.py and travel by name.
"""

from dataclasses import dataclass

from app.service.packing import FREE

WEAK = f"attraction below {100 * FREE:g} % of its peak"


@dataclass(frozen=True)
class Node:
    """How nodes in some state are drawn and called; the shape says the same as the colour."""

    said: str
    mark: str
    marker: str
    size: int
    colour: str
    meaning: str = ""


@dataclass(frozen=True)
class Curve:
    """How a curve is drawn and called."""

    said: str
    colour: str
    dash: str = "solid"
    symbol: str = ""


@dataclass(frozen=True)
class Stress:
    """A quantity inside the solid: its choice, its name (HTML), (mark, ramp, word) of its values below and above zero.

    Without `below` it has no sign.
    """

    choice: str
    name: str
    below: tuple = ("", "", "")
    above: tuple = ("", "", "")


NODES = {  # in the punch, as run.js tells them apart
    "repulsive": Node("touching", "dot repulsive", "circle", 5, "--repulsive"),
    "adhering": Node("attracted", "wedge", "inverted_triangle", 5, "--adhering"),
    "free": Node("free", "dot free", "circle", 3, "--free", WEAK),
    "contact": Node("in contact, Tₙ = 0", "dot contact", "square", 5, "--shear", "Tₙ = 0"),  # of flats only
}
RIDERS = {  # on the interface law, as pages/law.js tells them apart; another colour than the maps have
    "stick": Node("nodes stick (before the peak of Tₜ)", "dot stick", "circle", 6, "--stick"),
    "slip": Node("past the peak", "slip", "diamond", 9, "--slip"),
    "open": Node(f"free ({WEAK})", "dot free", "circle", 4, "--free"),
}
CURVES = {
    "T_n": Curve("normal Tₙ, repulsion > 0", "--normal", symbol="Tₙ"),
    "T_t": Curve("tangential Tₜ, against +x", "--shear", "dashed", "Tₜ"),
    "F": Curve("friction F", "--shear", symbol="F"),
    "L": Curve("load L", "--normal", "dashed", "L"),
    "A": Curve("A, width touching", "--area", symbol="A"),
    "ghost": Curve("before", "--ghost"),
}
FLATS = {  # presets on the page "Stick-slip", a line each, E in GPa and phi_t in N/m
    "fig4a-blue": Curve("E 70, φₜ 0.2", "--repulsive"),
    "fig4a-red": Curve("140, 0.2", "--adhering", "dotted"),
    "fig4a-green": Curve("70, 0.1", "--shear", "dashed"),
    "fig4b-weak": Curve("70, 0.004", "--slip", "dotdash"),
    "fig4b-stiff": Curve("3000, 0.2", "--soft", "dashdot"),
}
# blue is compression, as in the contact map, and the shear stress is at the surface what the traction view shows
SQUEEZED, STRETCHED = ("squeezes", "push", "compression"), ("stretches", "pull", "tension")
STRESSES = {
    "largest": Stress("largest shear stress", "Largest shear stress (σ₁ − σ₂)/2", above=("cividis", "", "")),
    "normal": Stress("normal stress, vertical", "Normal stress σ<sub>zz</sub>", SQUEEZED, STRETCHED),
    "lateral": Stress("normal stress, sideways", "Normal stress σ<sub>xx</sub>", SQUEEZED, STRETCHED),
    "shear": Stress(
        "shear stress",
        "Shear stress σ<sub>xz</sub>",
        ("pulls", "pull", "along +x"),
        ("pushes", "push", "against +x; at the surface this is Tₜ"),
    ),
    "mean": Stress(
        "mean stress",
        "Mean stress (σ<sub>xx</sub> + σ<sub>yy</sub> + σ<sub>zz</sub>)/3",
        SQUEEZED,
        STRETCHED,
    ),
}
