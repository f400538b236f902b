"""What all figures are made of: axes, glyphs over columns of data, lines, bands and images.

The name of a part is "figure.label"; its tag names its colour in style.css.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from bokeh.core.properties import field
from bokeh.models import ColumnDataSource, HoverTool, LinearColorMapper, NoOverlap, Span
from bokeh.models.glyphs import Image, Text
from bokeh.plotting import figure

FRAME = {
    # px beside the frame, the same in every view so that shared axes line up
    **{"min_border_left": 76, "min_border_right": 14, "min_border_top": 6, "min_border_bottom": 4},
    "output_backend": "canvas",  # a lecture hall's laptops may lack WebGL
    **{"background_fill_alpha": 0, "border_fill_alpha": 0, "sizing_mode": "stretch_both", "min_height": 40},
}
ONE_LOOK = {"selection_glyph": None, "nonselection_glyph": None, "muted_glyph": None}
COORDINATES: dict[type, tuple[str, ...]] = {  # of glyphs, if other than x and y
    Text: ("x", "y", "text"),
    Image: ("image", "x", "y", "dw", "dh"),
}
FACE = "system-ui, sans-serif"  # Bokeh's own, helvetica, is a serif face in browsers that lack it
AXIS = {
    **{"axis_label_text_font": FACE, "major_label_text_font": FACE, "axis_label_text_font_style": "normal"},
    **{"minor_tick_line_color": None, "axis_label_standoff": 4},
}


def blank(name: str, x_label: str, y_label: str, x: Any = (0.0, 1.0), y: Any = (0.0, 1.0), **axes: Any) -> figure:
    """Return a figure with axes and a grid, without tools that capture the wheel or touch."""
    axes |= {"x_axis_label": x_label, "y_axis_label": y_label}
    plot = figure(name=name, title=None, tools="", toolbar_location=None, x_range=x, y_range=y, **axes, **FRAME)
    for axis in plot.axis:
        axis.update(**AXIS, major_label_policy=NoOverlap(min_distance=6))  # px
    plot.yaxis.ticker.desired_num_ticks = 4
    return plot


def draw(
    plot: figure,
    kind: type,
    label: str,
    colour: str,
    *columns: Any,
    data: dict[str, Any] | None = None,
    tooltips: list | None = None,
    level: str = "glyph",
    **look: Any,
) -> None:
    """Add a glyph over columns, empty at first, that begin with its coordinates."""
    coordinates = dict(zip(COORDINATES.get(kind, ("x", "y")), map(field, columns), strict=False))
    source = ColumnDataSource(data=data or {column: [] for column in columns})
    named = _named(plot, label, colour)
    part = plot.add_glyph(source, kind(**coordinates, **look), level=level, **named, **ONE_LOOK)
    if tooltips:
        plot.add_tools(HoverTool(renderers=[part], tooltips=tooltips))


def draw_image(
    plot: figure,
    label: str,
    tooltips: list | None = None,
    bounds: Sequence[float] = (0, 0, 1, 1),
    palette: Sequence[str] = ("#888888",),
    level: str = "image",
) -> None:
    """Add an image within (left, bottom, right, top), blank at first."""
    left, bottom, right, top = bounds
    data = {"image": [np.zeros((2, 2), np.float32)], "x": [left], "y": [bottom]}
    data |= {"dw": [right - left], "dh": [top - bottom]}
    mapper = LinearColorMapper(palette=list(palette), low=0, high=1, nan_color="#00000000")
    draw(plot, Image, label, "", *data, data=data, tooltips=tooltips, color_mapper=mapper, level=level)


def add(plot: figure, label: str, model: Any, colour: str) -> None:
    """Add a line or a band to a figure."""
    model.update(**_named(plot, label, colour))
    plot.renderers.append(model)


def add_zero(plot: figure) -> None:
    """Add a line at zero."""
    add(plot, "zero", Span(location=0), "--grid")


def _named(plot, label, colour):
    return {"name": f"{plot.name}.{label}", "tags": [colour]}


class View(NamedTuple):
    """One Bokeh figure with its parts {label: renderer, band or line}."""

    figure: object
    parts: dict


def view_of(figure: figure) -> View:
    """Return the View of a figure."""
    named = [part for part in (*figure.renderers, *figure.center) if part.name]
    return View(figure, {part.name.removeprefix(f"{figure.name}."): part for part in named})
