"""Theory: the model in nine equations, and a glossary, in a dialog."""

from app import interface


class Feature(interface.Feature):
    """Its texts are files that the page fetches when the dialog opens."""

    ORDER = 30
