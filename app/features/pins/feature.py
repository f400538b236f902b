"""Pinned runs: up to four stay in view behind the run on screen, to compare with."""

from app import interface


class Feature(interface.Feature):
    """Their runs are kept in the browser."""
