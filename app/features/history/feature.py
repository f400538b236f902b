"""History: the address names scene and increment, and Back goes to the change before."""

from app import interface


class Feature(interface.Feature):
    """Entries of the browser's history."""

    ORDER = 5
    KEEPS = frozenset({"k"})
