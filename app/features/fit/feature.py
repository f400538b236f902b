"""A measured friction curve, and the parameters that fit it. Needs lab."""

from app import interface

TITLE, ORDER = "Fit", 3


class Feature(interface.Feature):
    """The page may begin with a measured curve, which its address names."""

    READS = frozenset({"curve"})
