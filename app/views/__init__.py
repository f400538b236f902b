"""Bokeh figures: the live views of the experiment, and the figures of pages."""
