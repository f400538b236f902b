"""The contact map: normal traction over place and path."""

from app import interface


class Feature(interface.Feature):
    """A third chart over the path."""

    ORDER = 10
    ALONE = True
