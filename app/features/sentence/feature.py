"""The live sentence: what happens, and what the last change has done, in plain words and true numbers."""

from app import interface


class Feature(interface.Feature):
    """Words beside the picture."""

    ORDER = 30
    ALONE = True
