"""A lost server: the page plays on, and is as it was once the server answers."""

from app import interface


class Feature(interface.Feature):
    """Watches the connection; comes after features whose state it carries over."""

    ORDER = 90
