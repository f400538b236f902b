"""The page "Friction over load": force and load of the first slip of every run that this visitor has seen.

The browser collects the points (static/js/slips.js) and draws them (page.js).
"""

from typing import Any

from bokeh.models import Span
from bokeh.models.glyphs import Scatter

from app.pages import Sheet
from app.schema import CHANGES
from app.views.plots import add, add_zero, blank, draw

TITLE, ORDER, FIGURES = "Friction over load", 3, ("slips",)


def compose() -> list[Any]:
    tooltips = [("", "@label"), ("L", "@L{0.0} N/m"), ("Fₛ", "@F{0.0} N/m")]
    plot = blank("load_slips", "load L (N/m)", "friction Fₛ at the first slip (N/m)")
    add_zero(plot)
    add(plot, "no load", Span(dimension="height", location=0.0, line_width=2, line_dash="dashed"), "--text")
    draw(plot, Scatter, "mark now", "--cursor", "L", "F", marker="circle", size=18, fill_alpha=0.0, line_width=2)
    for name, node in CHANGES.items():
        look = {"tooltips": tooltips, "marker": node.marker, "size": node.size}
        draw(plot, Scatter, name, node.colour, "L", "F", "label", **look)
    return [plot]


class Page(Sheet):
    """See app/pages."""
