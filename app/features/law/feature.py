"""Interface law: the traction of a node over its place, and the toughness of the interface. Needs pages."""

from typing import Any

import numpy as np

from app import interface
from app.schema import WEAK, Node
from solver import Scene
from solver.mechanics import cohesive_law

RIDERS = {  # nodes on the interface law; page.js assigns the states. The maps use other colours
    "stick": Node("nodes stick (before the peak of Tₜ)", "dot stick", "circle", 6, "--stick"),
    "slip": Node("past the peak", "slip", "diamond", 9, "--slip"),
    "open": Node(f"free ({WEAK})", "dot free", "circle", 4, "--free"),
}
EDGES = {  # of the contact, on the toughness of the interface
    "trailing": Node("trailing edge", "dot repulsive", "circle", 9, "--repulsive"),
    "leading": Node("leading edge", "slip", "diamond", 12, "--slip"),
}


class Feature(interface.Feature):
    """See page.py."""

    ORDER = 11

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        return {"riders": _plain(RIDERS), "edges": _plain(EDGES)}

    @classmethod
    def load(cls) -> None:
        """Compile the kernel of the law."""
        cohesive_law.traction(Scene(), np.zeros(1), 0.0)


def _plain(nodes):
    return {name: vars(node) for name, node in nodes.items()}
