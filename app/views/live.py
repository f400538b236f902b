"""The five live views of the experiment, as Bokeh models. The browser changes their data.

Units: lengths and the contact area in nm, tractions in GPa, forces in N/m; the browser relabels axes in other units.
"""

import numpy as np
from bokeh.core.properties import field
from bokeh.models import BoxAnnotation, ColumnDataSource, HoverTool, LinearColorMapper, NoOverlap, Range1d, Span
from bokeh.models.glyphs import Image, Line, MultiLine, Patch, Scatter, Text, VBar
from bokeh.plotting import figure

from app.schema import CURVES, NODES

FRAME = {
    # px beside the frame, the same in every view so that shared axes line up
    **{"min_border_left": 76, "min_border_right": 14, "min_border_top": 6, "min_border_bottom": 4},
    "output_backend": "canvas",  # a lecture hall's laptops may lack WebGL
    **{"background_fill_alpha": 0, "border_fill_alpha": 0, "sizing_mode": "stretch_both", "min_height": 40},
}
ONE_LOOK = {"selection_glyph": None, "nonselection_glyph": None, "muted_glyph": None}
COORDINATES = {  # of glyphs, if other than x and y
    MultiLine: ("xs", "ys"),
    Text: ("x", "y", "text"),
    VBar: ("x", "width", "top", "bottom"),
    Image: ("image", "x", "y", "dw", "dh"),
}
SLIP = {"marker": "diamond", "size": 8, "fill_alpha": 0, "line_width": 1.5}  # hollow, so that peaks stay visible
AXIS = {"axis_label_text_font_style": "normal", "minor_tick_line_color": None, "axis_label_standoff": 4}
POSITION = "x on the substrate, from the middle (nm)"  # current position of a node
UNDEFORMED = "x, undeformed (nm)"  # initial position of a node
TOP = "displacement Uₓ (nm)"


def live_figures():
    """Return {name: figure} with linked axes."""
    place, path = Range1d(-250, 250), Range1d(0, 40)
    return {
        "punch": punch(place),
        "traction": traction(place),
        "forces": forces(path),
        "area": area(path),
        "map": contact_map(path),
    }


def punch(x, name="punch"):
    """The deformed punch above the lattice sites of the rigid substrate, nodes by state."""
    tooltips = [("x", "@at{0.0} nm"), ("gap", "@gap{0.000} nm"), ("Tₙ", "@T_n{0.000} GPa"), ("Tₜ", "@T_t{0.000} GPa")]
    plot = blank(name, x, Range1d(-1.2, 7), POSITION, "height (nm)")
    add(plot, "substrate", BoxAnnotation(top=0, fill_alpha=0.12, line_width=0), "--text")
    draw(plot, Patch, "body", "--body", "x", "y", fill_alpha=0.25, line_alpha=0)
    draw(plot, Line, "surface", "--body", "x", "gap")
    draw(plot, Scatter, "sites", "--text", "x", "gap", marker="square", size=2)
    for state, node in reversed(NODES.items()):  # the first is on top
        look = {"marker": node.marker, "size": node.size, "hover": {"tooltips": [(state, node.meaning), *tooltips]}}
        draw(plot, Scatter, state, node.colour, "x", "gap", "at", "T_n", "T_t", **look)
    _pins(plot)
    return plot


def traction(x):
    """Normal and tangential traction along the interface."""
    plot = blank("traction", x, Range1d(-1, 2), POSITION, "traction (GPa)")
    _zero(plot)
    _curves(plot, "x", "T", "x", "GPa", "T_n", "T_t")
    return plot


def forces(x):
    """Friction and load along the path, with the previous run as pale curves."""
    plot = blank("forces", x, Range1d(-1, 2), TOP, "F, L (N/m)")
    _zero(plot)
    _along(plot, "N/m", "F", "L")
    return plot


def area(x):
    """Contact area along the path."""
    plot = blank("area", x, Range1d(0, 100), TOP, "A (nm)")
    _along(plot, "nm", "A")
    return plot


def contact_map(x):
    """Normal traction over path and position: shows where the contact repels, adheres or is open."""
    plot = blank("map", x, Range1d(-250, 250), TOP, UNDEFORMED)
    empty = {"image": [np.zeros((2, 2), np.float32)], "x": [0], "y": [-1], "dw": [1], "dh": [2]}
    colours = LinearColorMapper(palette=["#888888"], low=0, high=1, nan_color="#00000000")
    tooltips = [("Uₓ", "$x{0.0} nm"), ("x", "$y{0} nm"), ("Tₙ", "@image{0.000} GPa")]
    draw(plot, Image, "map", "", *empty, hover={"tooltips": tooltips}, data=empty, color_mapper=colours, level="glyph")
    stripes = {"hatch_pattern": "right_diagonal_line", "hatch_color": "#808080", "hatch_weight": 2, "hatch_scale": 8}
    draw(plot, VBar, "unrested", "--free", "x", "width", "top", "bottom", fill_alpha=0.15, line_alpha=0, **stripes)
    draw(plot, Line, "branch", "--text", "U_x", "x", line_dash="dashed")  # contact edges, off screen
    _pins(plot)
    draw(plot, Scatter, "slips_map", "--slip", "U_x", "x", **SLIP)
    _cursor(plot)
    return plot


def _along(plot, unit, *names):
    """Curves along the path, above those of the previous run and of pinned runs, with the slips of the first curve."""
    _pins(plot)
    for name in names:
        ghost = {"line_width": 3, "line_dash": CURVES[name].dash}
        draw(plot, Line, f"ghost_{name}", CURVES["ghost"].colour, "U_x", "value", **ghost)
    _curves(plot, "U_x", "value", "Uₓ", unit, *names)
    draw(plot, Scatter, f"slips_{names[0]}", "--slip", "U_x", "value", **SLIP)
    _cursor(plot)
    heads = {"angle": "angle", "marker": "triangle", "size": 11}  # of arrows along the curve
    draw(plot, Scatter, "ways", "--text", "U_x", "value", "angle", **heads)


def _curves(plot, x, y, along, unit, *names):
    """Curves with tooltips. Two curves have theirs on opposite sides of the mouse, so that both stay visible."""
    for name, side in zip(names, ("right", "left") if len(names) == 2 else ("horizontal",), strict=True):
        curve = CURVES[name]
        tooltips = [(along, f"@{x}{{0.0}} nm"), (curve.symbol, f"@{y}{{0.000}} {unit}")]
        hover = {"tooltips": tooltips, "mode": "vline", "attachment": side}
        draw(plot, Line, name, curve.colour, x, y, hover=hover, line_width=2, line_dash=curve.dash)


def _pins(plot):
    """Lines of pinned runs, each with its own colour, dash and width."""
    looks = {"line_color": field("colour"), "line_dash": field("dash"), "line_width": field("width")}
    draw(plot, MultiLine, "pins", "", "xs", "ys", "colour", "dash", "width", **looks)


def _zero(plot):
    add(plot, "zero", Span(location=0), "--grid")


def _cursor(plot):
    """The line at the increment on screen; it has its own canvas, so that moving it redraws nothing else."""
    add(plot, "cursor", Span(location=0, dimension="height", line_width=1.5, level="overlay"), "--cursor")


def draw(plot, kind, label, colour, *columns, data=None, hover=None, level="glyph", **look):
    """Add a glyph over columns, empty at first, that begin with its coordinates; hover: options of its tooltip."""
    coordinates = dict(zip(COORDINATES.get(kind, ("x", "y")), map(field, columns), strict=False))
    source = ColumnDataSource(data=data or {column: [] for column in columns})
    named = _named(plot, label, colour)
    part = plot.add_glyph(source, kind(**coordinates, **look), level=level, **named, **ONE_LOOK)
    if hover:
        plot.add_tools(HoverTool(renderers=[part], **hover))


def add(plot, label, model, colour):
    """Add a line or a band to a figure."""
    model.update(**_named(plot, label, colour))
    plot.renderers.append(model)


def _named(plot, label, colour):
    """Return the name of a part of a figure, for the browser, and its colour in style.css."""
    return {"name": f"{plot.name}.{label}", "tags": [colour]}


def blank(name, x, y, x_label, y_label, **axes):
    """Return a figure with axes and a grid, without tools that capture the wheel or touch."""
    axes |= {"x_axis_label": x_label, "y_axis_label": y_label}
    plot = figure(name=name, title=None, tools="", toolbar_location=None, x_range=x, y_range=y, **axes, **FRAME)
    for axis in plot.axis:
        axis.update(**AXIS, major_label_policy=NoOverlap(min_distance=6))  # px
    plot.yaxis.ticker.desired_num_ticks = 4
    return plot
