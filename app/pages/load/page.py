"""The page "Friction over load": force and load of the first slip of every run that this visitor has seen.

The browser collects the points (static/js/slips.js) and draws them (page.js).
"""

import holoviews as hv
from bokeh.models import Span

from app.pages import Sheet
from app.schema import CHANGES
from app.views.plots import Part, Quantity, dots, level, rendered
from solver import sweep
from solver.plots import friction_over_load

TITLE, ORDER, FIGURES = "Friction over load", 3, ("slips",)
TEMPLATE = {"changes": CHANGES}
LOAD = Quantity("L", "load L", "N/m")
FRICTION = Quantity("F", "friction Fₛ at the first slip", "N/m")
CHANGE = Quantity("label", "")
DEPTHS = (-0.2, 0.0, 0.2, 0.4)  # delta_bar of a notebook's figure


def compose():
    tooltips = [("", "@label"), ("L", "@L{0.0} N/m"), ("Fₛ", "@F{0.0} N/m")]
    marks = [
        dots(name, LOAD, FRICTION, CHANGE, tooltips=tooltips, marker=node.marker, size=node.size)
        for name, node in CHANGES.items()
    ]
    parts = [
        level("zero"),
        Part(Span, "no load", look={"dimension": "height", "location": 0.0, "line_width": 2, "line_dash": "dashed"}),
        dots("mark now", LOAD, FRICTION, marker="circle", size=18, fill_alpha=0.0, line_width=2),
        *marks,
    ]
    colours = {name: node.colour for name, node in CHANGES.items()}
    return [rendered("load_slips", parts, colours | {"zero": "--grid", "no load": "--text", "mark now": "--cursor"})]


def figure(scene):
    """F_s over L_s of a sweep of the press depth: what a notebook shows."""
    return hv.render(friction_over_load(sweep(scene, delta_bar=DEPTHS)), backend="bokeh")


class Page(Sheet):
    """See app/pages."""
