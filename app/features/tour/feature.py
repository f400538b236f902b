"""The tour: nine stops, each with a prediction before the run shows its future. Needs pages, history."""

from app import interface


class Feature(interface.Feature):
    """Its card takes the place of the sentence."""

    ORDER = 40
    KEEPS = frozenset({"tour"})
