"""The four live views of the experiment, as Bokeh models. The browser changes their data.

Units: lengths and the contact area in nm, tractions in GPa, forces in N/m.
"""

from typing import Any

from bokeh.core.properties import field
from bokeh.models import BoxAnnotation, Range1d, Span
from bokeh.models.glyphs import Line, MultiLine, Patch, Scatter, VBar
from bokeh.plotting import figure

from app.schema import CURVES, NODES
from app.views.plots import add, add_zero, blank, draw, draw_image

SLIP: dict[str, Any] = {
    "marker": "diamond",
    "size": 8,
    "fill_alpha": 0,
    "line_width": 1.5,
}  # hollow, so that peaks stay visible
POSITION = "x on the substrate, from the middle (nm)"  # current position of a node
UNDEFORMED = "x (nm)"  # initial position of a node
TOP = "displacement Uₓ (nm)"


def live_figures() -> dict[str, figure]:
    """Return {name: figure} with linked axes."""
    place, path = Range1d(-250, 250), Range1d(0, 40)
    return {
        "punch": punch(place),
        "forces": forces(path),
        "area": area(path),
        "map": contact_map(path),
    }


def punch(x: Any) -> figure:
    """The deformed punch above the lattice sites of the rigid substrate, nodes by state."""
    tooltips = [("x", "@at{0.0} nm"), ("gap", "@gap{0.000} nm"), ("Tₙ", "@T_n{0.000} GPa"), ("Tₜ", "@T_t{0.000} GPa")]
    plot = blank("punch", POSITION, "height (nm)", x, (-1.2, 7))
    add(plot, "substrate", BoxAnnotation(top=0, fill_alpha=0.12, line_width=0), "--text")
    draw(plot, Patch, "body", "--body", "x", "y", fill_alpha=0.25, line_alpha=0)
    draw(plot, Line, "surface", "--body", "x", "gap")
    draw(plot, Line, "sites", "--text", "x", "gap")  # dashes, a site each
    for state, node in reversed(NODES.items()):  # the first is on top
        look: dict[str, Any] = {
            "marker": node.marker,
            "size": node.size,
            "tooltips": [(state, node.meaning), *tooltips],
        }
        draw(plot, Scatter, state, node.colour, "x", "gap", "at", "T_n", "T_t", **look)
    _pins(plot)
    return plot


def forces(x: Any) -> figure:
    """Friction and load along the path, with the previous run as pale curves."""
    plot = blank("forces", TOP, "F, L (N/m)", x, (-1, 2))
    add_zero(plot)
    _along(plot, "N/m", "F", "L")
    return plot


def area(x: Any) -> figure:
    """Contact area along the path."""
    plot = blank("area", TOP, "A (nm)", x, (0, 100))
    _along(plot, "nm", "A")
    return plot


def contact_map(x: Any) -> figure:
    """Normal traction over path and position: shows where the contact repels, adheres or is open."""
    plot = blank("map", TOP, UNDEFORMED, x, (-250, 250))
    tooltips = [("Uₓ", "$x{0.0} nm"), ("x", "$y{0} nm"), ("Tₙ", "@image{0.000} GPa")]
    draw_image(plot, "map", tooltips, (0, -1, 1, 1), level="glyph")
    stripes: dict[str, Any] = {"hatch_pattern": "right_diagonal_line", "hatch_color": "#808080"}
    stripes |= {"hatch_weight": 2, "hatch_scale": 8}
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
        ghost: dict[str, Any] = {"line_width": 3, "line_dash": CURVES[name].dash}
        draw(plot, Line, f"ghost_{name}", CURVES["ghost"].colour, "U_x", "value", **ghost)
    _curves(plot, "U_x", "value", "Uₓ", unit, *names)
    draw(plot, Scatter, f"slips_{names[0]}", "--slip", "U_x", "value", **SLIP)
    _cursor(plot)
    heads: dict[str, Any] = {"angle": "angle", "marker": "triangle", "size": 11}  # of arrows along the curve
    draw(plot, Scatter, "ways", "--text", "U_x", "value", "angle", **heads)


def _curves(plot, x, y, along, unit, *names):
    """Curves with tooltips. Two curves have theirs on opposite sides of the mouse, so that both stay visible."""
    for name, side in zip(names, ("right", "left") if len(names) == 2 else ("horizontal",), strict=True):
        curve = CURVES[name]
        tooltips = [(along, f"@{x}{{0.0}} nm"), (curve.symbol, f"@{y}{{0.000}} {unit}")]
        look: dict[str, Any] = {
            "hover": {"mode": "vline", "attachment": side},
            "line_width": 2,
            "line_dash": curve.dash,
        }
        draw(plot, Line, name, curve.colour, x, y, tooltips=tooltips, **look)


def _pins(plot):
    """Lines of pinned runs, each with its own colour, dash and width."""
    looks: dict[str, Any] = {"line_color": field("colour"), "line_dash": field("dash"), "line_width": field("width")}
    draw(plot, MultiLine, "pins", "", "xs", "ys", "colour", "dash", "width", **looks)


def _cursor(plot):
    """The line at the increment on screen; it has its own canvas, so that moving it redraws nothing else."""
    add(plot, "cursor", Span(location=0, dimension="height", line_width=1.5, level="overlay"), "--cursor")
