"""The page "Inside the solid": the stress in the layer, drawn by the browser (page.js)."""

from bokeh.palettes import cividis

from app.pages import Sheet
from app.schema import STRESSES
from app.views.plots import Quantity, picture, rendered

TITLE, ORDER, FIGURES = "Inside the solid", 4, ("field",)
NODE = Quantity("x", "x in the punch, undeformed", "nm")  # where it was in the undeformed layer


def compose():
    """The picture."""
    z = Quantity("z", "height z in the layer", "nm")
    image = picture("field", NODE, z, [("x", "$x{0} nm"), ("z", "$y{0} nm"), ("", "@image{0.000} GPa")])
    return [rendered("solid_field", [image], {}, x=(-250, 250), y=(0, 250))]


class Page(Sheet):
    """See pages.py."""

    def start(self):
        """The browser draws from the frames and the table of the layer that it has."""
        self.publish(palette=list(cividis(256)), stresses={name: vars(stress) for name, stress in STRESSES.items()})
