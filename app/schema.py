"""Names, marks and colours of curves and nodes. Python, templates and scripts share these declarations.

Colours are variables of style.css, marks are its classes; markers are those of chart.js.
service/packing.py declares the columns and fields of packed frames.
"""

from dataclasses import dataclass

from app.service.packing import FREE

WEAK = f"attraction below {100 * FREE:g} % of its peak"


@dataclass(frozen=True)
class Node:
    """Style and label of the nodes in one state; both the shape and the colour show the state."""

    label: str
    mark: str
    marker: str
    size: int
    colour: str
    meaning: str = ""


@dataclass(frozen=True)
class Curve:
    """Style and label of a curve."""

    label: str
    colour: str
    dash: str = "solid"


NODES = {  # of the punch; frames.js assigns the states
    "repulsive": Node("touching", "dot repulsive", "circle", 5, "--repulsive"),
    "adhering": Node("attracted", "wedge", "inverted_triangle", 5, "--adhering"),
    "free": Node("free", "dot free", "circle", 3, "--free", WEAK),
    "contact": Node("in contact, Tₙ = 0", "dot contact", "square", 5, "--shear"),  # of flats only
}
RIDERS = {  # nodes on the interface law; pages/law/page.js assigns the states. The maps use other colours
    "stick": Node("nodes stick (before the peak of Tₜ)", "dot stick", "circle", 6, "--stick"),
    "slip": Node("past the peak", "slip", "diamond", 9, "--slip"),
    "open": Node(f"free ({WEAK})", "dot free", "circle", 4, "--free"),
}
EDGES = {  # of the contact, on the toughness of the interface
    "trailing": Node("trailing edge", "dot repulsive", "circle", 9, "--repulsive"),
    "leading": Node("leading edge", "slip", "diamond", 12, "--slip"),
}
CHANGES = {  # what changed before a run, on the page "Friction over load"
    "delta_bar": Node("press depth", "dot repulsive", "circle", 9, "--repulsive"),
    "phi_ratio": Node("friction to adhesion", "slip", "diamond", 12, "--slip"),
    "E": Node("stiffness", "wedge", "inverted_triangle", 10, "--adhering"),
    "another": Node("another parameter", "dot contact", "square", 8, "--shear"),
    "several": Node("another experiment", "dot free", "circle", 9, "--free"),
}
CURVES = {
    "F": Curve("friction F", "--shear"),
    "L": Curve("load L", "--normal", "dashed"),
    "A": Curve("A, width touching", "--area"),
    "ghost": Curve("before", "--ghost"),
}
