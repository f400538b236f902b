"""Check: whether a device does what the page needs, in words that can be photographed."""

from app import interface


class Feature(interface.Feature):
    """The page asks nothing of the server but a run."""

    KEEPS = frozenset({"check"})
