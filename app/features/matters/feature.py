"""What matters: how the first slip changes with each parameter and with the strength of each node. Needs pages."""

from app import interface


class Feature(interface.Feature):
    """See page.py."""

    ORDER = 15
