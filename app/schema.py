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
CURVES = {
    "F": Curve("friction F", "--shear"),
    "L": Curve("load L", "--normal", "dashed"),
    "A": Curve("A, width touching", "--area"),
    "ghost": Curve("before", "--ghost"),
}
