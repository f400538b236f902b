"""The page "Inside the solid": the stress in the layer. The browser draws it (page.js)."""

from bokeh.palettes import cividis

from app.pages import Sheet
from app.schema import STRESSES
from app.views.plots import blank, draw_image

TITLE, ORDER, FIGURES = "Inside the solid", 4, ("field",)


def compose():
    """Return the figure of the stress."""
    plot = blank("solid_field", "x in the punch, undeformed (nm)", "height z in the layer (nm)", (-250, 250), (0, 250))
    draw_image(plot, "field", [("x", "$x{0} nm"), ("z", "$y{0} nm"), ("", "@image{0.000} GPa")])
    return [plot]


class Page(Sheet):
    """The page of one visitor; see app/pages."""

    def start(self):
        """Send colours and labels; the browser draws from its frames and its table of the layer."""
        self.publish(palette=list(cividis(256)), stresses={name: vars(stress) for name, stress in STRESSES.items()})
