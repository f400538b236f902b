"""Friction over load: a point for the first slip of each run, and sweeps of the press depth. Needs pages."""

from typing import Any

from app import interface
from app.schema import Node

CHANGES = {  # what changed before a run
    "delta_bar": Node("press depth", "dot repulsive", "circle", 9, "--repulsive"),
    "phi_ratio": Node("friction to adhesion", "slip", "diamond", 12, "--slip"),
    "E": Node("stiffness", "wedge", "inverted_triangle", 10, "--adhering"),
    "another": Node("another parameter", "dot contact", "square", 8, "--shear"),
    "several": Node("another experiment", "dot free", "circle", 9, "--free"),
}


class Feature(interface.Feature):
    """See page.py."""

    ORDER = 13

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        return {"changes": {name: vars(node) for name, node in CHANGES.items()}}
