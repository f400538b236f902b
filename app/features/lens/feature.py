"""The lens: nodes, lattice sites and springs at the trailing edge, to scale."""

from app import interface


class Feature(interface.Feature):
    """A part of the picture of the punch."""

    ALONE = True
