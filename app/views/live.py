"""The five views of the experiment, as Bokeh models; from then on only their sources change, in the browser.

Units: lengths and the contact area in nm, tractions in GPa, forces in N/m; the browser names others when it uses them.
"""

import numpy as np
from bokeh.core.properties import field
from bokeh.models import (
    BasicTicker,
    BoxAnnotation,
    ColumnDataSource,
    GlyphRenderer,
    Grid,
    HoverTool,
    Image,
    Line,
    LinearAxis,
    LinearColorMapper,
    MultiLine,
    Patch,
    Plot,
    Range1d,
    Scatter,
    Span,
    Toolbar,
    VBar,
)

from app.schema import CURVES, NODES

FRAME = {
    # px beside the frame, the same in every view so that shared axes line up
    **{"min_border_left": 76, "min_border_right": 14, "min_border_top": 6, "min_border_bottom": 4},
    "output_backend": "canvas",  # a lecture hall's laptops may lack WebGL
    **{"background_fill_alpha": 0, "border_fill_alpha": 0, "sizing_mode": "stretch_both", "min_height": 40},
}
ONE_LOOK = {"selection_glyph": None, "nonselection_glyph": None, "muted_glyph": None}
AXIS = {"axis_label_text_font_style": "normal", "minor_tick_line_color": None, "axis_label_standoff": 4}
POSITION = "x on the substrate, from the middle (nm)"  # where a node is
UNDEFORMED = "x, undeformed (nm)"  # where it was
TOP = "displacement of the top Uₓ (nm)"


def live_figures():
    """{name: figure} for one visitor, with their shared axes linked."""
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
    said = [("x", "@x{0.0} nm"), ("gap", "@gap{0.000} nm"), ("Tₙ", "@T_n{0.000} GPa"), ("Tₜ", "@T_t{0.000} GPa")]
    parts = [
        _part("substrate", BoxAnnotation(top=0, fill_alpha=0.12, line_width=0), "--text"),
        _drawn("body", Patch(x="x", y="y", fill_alpha=0.25, line_alpha=0), "--body"),
        _drawn("surface", Line(x="x", y="gap"), "--body"),
        _drawn("sites", Scatter(x="x", y="gap", marker="square", size=2), "--text"),
    ]
    for state, node in reversed(NODES.items()):  # the first on top
        glyph = Scatter(x="x", y="gap", marker=node.marker, size=node.size)
        parts.append(_drawn(state, glyph, node.colour, [(state, node.meaning), *said], more=("T_n", "T_t")))
    return _figure(name, x, Range1d(-1.2, 7), POSITION, "height (nm)", [*parts, _pins()])


def traction(x):
    """Normal and tangential traction along the interface."""
    parts = [_zero(), *(_curve(name, "x", "T", "x", "GPa") for name in ("T_n", "T_t"))]
    return _figure("traction", x, Range1d(-1, 2), POSITION, "traction (GPa)", parts)


def forces(x):
    """Friction and load along the path, those of the run before pale behind."""
    parts = [_zero(), _band("F"), _band("L"), _pins(), *_curves("N/m", "F", "L"), _ways()]
    return _figure("forces", x, Range1d(-1, 2), TOP, "F, L (N/m)", parts)


def area(x):
    """Contact area along the path."""
    return _figure("area", x, Range1d(0, 100), TOP, "A (nm)", [_band("A"), _pins(), *_curves("nm", "A"), _ways()])


def contact_map(x):
    """Normal traction over path and place: where the contact repels, adheres or is open, at every moment."""
    blank = {"image": [np.zeros((2, 2), np.float32)], "x": [0], "y": [-1], "dw": [1], "dh": [2]}
    image = Image(color_mapper=LinearColorMapper(palette=["#888888"], low=0, high=1, nan_color="#00000000"))
    said = [("Uₓ", "$x{0.0} nm"), ("x", "$y{0} nm"), ("Tₙ", "@image{0.000} GPa")]
    slips = Scatter(x="U_x", y="x", marker="diamond", size=8)
    stripes = VBar(x="x", width="width", bottom="bottom", top="top", fill_alpha=0.15, line_alpha=0)
    stripes.update(hatch_pattern="right_diagonal_line", hatch_color="#808080", hatch_weight=2, hatch_scale=8)
    unrested = _drawn("unrested", stripes, "--free", data={name: [] for name in ("x", "width", "bottom", "top")})
    branch = _drawn("branch", Line(x="U_x", y="x", line_dash="dashed"), "--text")  # edges, on the way that is not shown
    parts = [_drawn("map", image, "", said, data=blank), unrested, branch, _pins()]
    parts += [_drawn("slips_map", slips, "--slip"), _cursor()]
    return _figure("map", x, Range1d(-250, 250), TOP, UNDEFORMED, parts)


def _curves(unit, *names):
    """Curves along the path, on top of those of the run before, with the slips of the first."""
    ghosts = [(name, Line(x="U_x", y="value", line_width=3, line_dash=CURVES[name].dash)) for name in names]
    return [
        *(_drawn(f"ghost_{name}", line, CURVES["ghost"].colour) for name, line in ghosts),
        *(_curve(name, "U_x", "value", "Uₓ", unit) for name in names),
        _drawn(f"slips_{names[0]}", Scatter(x="U_x", y="value", marker="diamond", size=8), "--slip"),
        _cursor(),
    ]


def _curve(name, x, y, along, unit):
    curve = CURVES[name]
    said = [(along, f"@{x}{{0.0}} nm"), (curve.symbol, f"@{y}{{0.000}} {unit}")]
    return _drawn(name, Line(x=x, y=y, line_width=2, line_dash=curve.dash), curve.colour, said, "vline")


def _band(name):
    """Where a curve may lie if its parameters are not known exactly."""
    return _drawn(f"band_{name}", Patch(x="U_x", y="value", fill_alpha=0.25, line_alpha=0), CURVES[name].colour)


def _ways():
    """Heads of arrows along a curve."""
    ways = Scatter(x="U_x", y="value", angle="angle", marker="triangle", size=11)
    return _drawn("ways", ways, "--text", data={"U_x": [], "value": [], "angle": []})


def _pins():
    """Lines of pinned runs, each with colour, dash and width of its own."""
    looks = {"line_color": field("colour"), "line_dash": field("dash"), "line_width": field("width")}
    lines = MultiLine(xs="xs", ys="ys", **looks)
    return _drawn("pins", lines, "", data={name: [] for name in ("xs", "ys", "colour", "dash", "width")})


def _zero():
    return _part("zero", Span(location=0), "--grid")


def _cursor():
    """The increment on screen; on a canvas of its own: moving it paints nothing else."""
    return _part("cursor", Span(location=0, dimension="height", line_width=1.5, level="overlay"), "--cursor")


def _drawn(label, glyph, colour, said=None, mode="mouse", more=(), data=None):
    """A glyph with an empty source of the columns it names, and more; what is said of it when pointed at."""
    source = ColumnDataSource(data or {column: [] for column in (glyph.x, glyph.y, *more)})
    part = GlyphRenderer(data_source=source, glyph=glyph, **ONE_LOOK)
    return _part(label, part, colour, said and HoverTool(renderers=[part], tooltips=said, mode=mode))


def _part(label, model, colour, hover=None):
    """Something in a figure under the name by which the browser finds it, with its colour in style.css."""
    model.update(name=label, tags=[colour])
    return model, hover


def _beside_each_other(tools):
    """Boxes of two curves on either side of the mouse, so that none hides the other."""
    if len(tools) == 2 and all(tool.mode == "vline" for tool in tools):
        tools[0].attachment, tools[1].attachment = "right", "left"
    return tools


def _figure(name, x, y, x_label, y_label, parts):
    """Axes, grid and parts; no tools that catch the wheel or a finger."""
    across = LinearAxis(axis_label=x_label, **AXIS)
    up = LinearAxis(axis_label=y_label, ticker=BasicTicker(desired_num_ticks=4), **AXIS)
    for part, _ in parts:
        part.name = f"{name}.{part.name}"
    return Plot(
        **{"name": name, "title": None, "toolbar_location": None, "x_range": x, "y_range": y},
        **{"below": [across], "left": [up], "center": [Grid(axis=across, dimension=0), Grid(axis=up, dimension=1)]},
        renderers=[part for part, _ in parts],
        toolbar=Toolbar(tools=_beside_each_other([hover for _, hover in parts if hover])),
        **FRAME,
    )
