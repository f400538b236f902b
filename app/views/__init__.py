"""Figures: the live ones, and the pages beside the experiment."""
