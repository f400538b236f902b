"""The page "Friction over load": force and load of the first slip of every run that this visitor has seen.

The browser collects the points (static/js/slips.js) and draws them (page.js).
"""

from bokeh.models import Span

from app.pages import Sheet
from app.schema import CHANGES
from app.views.plots import Part, Quantity, dots, level, rendered

TITLE, ORDER, FIGURES = "Friction over load", 3, ("slips",)
TEMPLATE = {"changes": CHANGES}
LOAD = Quantity("L", "load L", "N/m")
FRICTION = Quantity("F", "friction Fₛ at the first slip", "N/m")
CHANGE = Quantity("label", "")


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


class Page(Sheet):
    """See app/pages."""
