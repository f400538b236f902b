"""The figures of pages. They are made when a page opens; afterwards only their data change."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from bokeh.models import BoxAnnotation, LinearColorMapper, Range1d, Span
from bokeh.models.glyphs import Image, Line, Scatter, Text

from app.views.live import add, blank, draw


class Quantity(NamedTuple):
    """The quantity of an axis: its column in the data, its label and its unit."""

    column: str
    label: str
    unit: str = ""

    @property
    def title(self):
        """Title of the axis."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


class Part(NamedTuple):
    """A part of a figure; `kind`: a glyph that draws quantities, or another model (line, band)."""

    kind: type
    label: str
    quantities: tuple = ()
    tooltips: list | None = None
    mode: str = "mouse"
    look: dict = {}  # noqa: RUF012 (never changed)


@dataclass
class View:
    """One Bokeh figure with its parts {label: renderer, band or line}.

    The name of a part is "figure.label"; its tag names its colour in style.css.
    """

    figure: object
    parts: dict


def curve(label, *quantities, tooltips=None, mode="mouse", **look):
    """A curve of the first two quantities; its tooltip `tooltips` may name the others."""
    return Part(Line, label, quantities, tooltips, mode, look)


def dots(label, *quantities, tooltips=None, **look):
    """Markers; the arguments are those of `curve`."""
    return Part(Scatter, label, quantities, tooltips, look=look)


def texts(label, *quantities, **look):
    """Texts of the third quantity at positions of the first two."""
    return Part(Text, label, quantities, look=look)


def picture(label, x, y, tooltips=None, bounds=(0, 0, 1, 1), palette=("#888888",)):
    """An image over x and y, within (left, bottom, right, top)."""
    return Part(Image, label, (x, y), tooltips, look={"bounds": bounds, "palette": list(palette)})


def level(label):
    """A line at zero."""
    return Part(Span, label, look={"location": 0.0, "line_width": 1})


def band(label):
    """A band over a range of the horizontal axis."""
    return Part(BoxAnnotation, label, look={"left": 1.0, "right": 2.0, "fill_alpha": 0.18, "line_alpha": 0})


def rendered(name, parts, colours, x=(0.0, 1.0), y=(0.0, 1.0), **axes):
    """Return a Bokeh figure of parts; colours: {label: variable of style.css}; axes: x_axis_type, y_axis_type."""
    across, up = next(part.quantities[:2] for part in parts if part.quantities)
    made = blank(name, Range1d(*x), Range1d(*y), across.title, up.title, **axes)
    for part in parts:
        colour, hover = colours.get(part.label, ""), part.tooltips and {"tooltips": part.tooltips, "mode": part.mode}
        columns = [quantity.column for quantity in part.quantities]
        if not columns:
            add(made, part.label, part.kind(**part.look), colour)
        elif part.kind is Image:
            _draw_image(made, part, hover)
        else:
            draw(made, part.kind, part.label, colour, *columns, hover=hover, **part.look)
    return made


def _draw_image(made, part, hover):
    left, bottom, right, top = part.look["bounds"]
    data = {"image": [np.zeros((2, 2), np.float32)], "x": [left], "y": [bottom]}
    data |= {"dw": [right - left], "dh": [top - bottom]}
    mapper = LinearColorMapper(palette=part.look["palette"], low=0, high=1, nan_color="#00000000")
    draw(made, Image, part.label, "", *data, data=data, hover=hover, color_mapper=mapper, level="image")


def view_of(figure):
    """Return the View of a figure."""
    named = [part for part in (*figure.renderers, *figure.center) if part.name]
    return View(figure, {part.name.removeprefix(f"{figure.name}."): part for part in named})
