"""The five views, composed once with HoloViews and rendered to Bokeh figures; from then on only their sources change.

Units: lengths in nm, tractions in GPa, F̄, L̄ and Ā in thousandths (they are dimensionless: over w E, w E and w).
"""

import json
from collections import defaultdict
from dataclasses import dataclass, field
from functools import cache

import holoviews as hv
import numpy as np
from bokeh.core.serialization import Deserializer, Serializer
from bokeh.models import HoverTool
from bokeh.util.serialization import make_id

from app.service.worker import FREE

hv.extension("bokeh", logo=False)
POSITION = hv.Dimension("x", label="x on the substrate, from the middle", unit="nm")  # where a node is
NODE = hv.Dimension("x", label="x in the punch, undeformed", unit="nm")  # where it was in the undeformed layer
SHEAR = hv.Dimension("U_x", label="displacement of the top Uₓ", unit="nm")
LEFT, RIGHT = 64, 14  # px beside the frame, the same in every view so that shared axes line up
EMPTY = ([], [])
# label: (marker, size, colour variable of style.css); shape says the same as colour
NODES = {
    "free": ("circle", 3, "--free"),
    "adhering": ("inverted_triangle", 5, "--adhering"),
    "repulsive": ("circle", 5, "--repulsive"),
    "contact": ("square", 5, "--shear"),
}
# how the node pointed at is described
MEANT = {"free": f"attraction below {100 * FREE:.0f} % of its peak", "contact": "Tₙ = 0"}


@dataclass
class View:
    """One Bokeh figure with what changes in it: {label: renderer, band or line}.

    A part is called "figure.label", and has the colour of style.css that its tag names.
    """

    name: str
    figure: object
    parts: dict = field(default_factory=dict)


def curve(label, x, y, **options):
    return hv.Curve(EMPTY, x, y, label=label).opts(default_tools=[], **options)


def dots(label, x, y, **options):
    return hv.Scatter(EMPTY, x, y, label=label).opts(default_tools=[], **options)


def cursor():
    return hv.VLine(0.0, label="cursor").opts(line_width=1.5, color="#888888")


def rendered(name, elements, colours, **ranges):
    """Render an overlay and find in it, by label, what will be updated."""
    overlay = hv.Overlay(elements).opts(show_legend=False, responsive=True, toolbar=None, default_tools=[], title="")
    plot = hv.renderer("bokeh").get_plot(overlay)
    view = View(name, plot.state)
    for element, subplot in zip(elements, plot.subplots.values(), strict=True):
        handles = subplot.handles
        part = view.parts[element.label] = handles.get("glyph_renderer", handles["glyph"])
        part.update(name=f"{name}.{element.label}", tags=[colours.get(element.label, "")])
        if element.label == "cursor":
            part.level = "overlay"  # a canvas of its own: moving it paints nothing else
    _dress(view.figure, name)
    x, y = next(element for element in elements if isinstance(element, hv.Curve | hv.Image)).dimensions()[:2]
    view.figure.xaxis.axis_label, view.figure.yaxis.axis_label = x.pprint_label, y.pprint_label
    for axis, (low, high) in ranges.items():
        getattr(view.figure, f"{axis}_range").update(start=low, end=high)
    return view


def _dress(figure, name):
    """What every figure has in common: place beside the frame, no tools that catch the wheel or a finger."""
    figure.update(name=name, min_border_left=LEFT, min_border_right=RIGHT, min_border_top=6, min_border_bottom=4)
    figure.update(background_fill_alpha=0.0, border_fill_alpha=0.0, sizing_mode="stretch_both", min_height=80)
    figure.output_backend = "canvas"  # a lecture hall's laptops may lack WebGL
    figure.toolbar.tools = [tool for tool in figure.tools if isinstance(tool, HoverTool)]
    for axis in (*figure.xaxis, *figure.yaxis):
        axis.update(axis_label_text_font_style="normal", minor_tick_line_color=None)
        axis.axis_label_standoff = 4
    figure.yaxis.ticker.desired_num_ticks = 4


def punch():
    """The deformed punch above the lattice sites of the rigid substrate, nodes by state."""
    gap = hv.Dimension("gap", label="height", unit="nm")
    body = hv.Area(([], [], []), POSITION, [gap, hv.Dimension("top")], label="body")
    elements = [
        hv.HSpan(-100.0, 0.0, label="substrate").opts(alpha=0.12, line_alpha=0),
        body.opts(default_tools=[], alpha=0.25, line_alpha=0),
        curve("surface", POSITION, gap, line_width=1),
        dots("sites", POSITION, gap, marker="square", size=2),
    ]
    hover = [("x", "@x{0.0} nm"), ("gap", "@gap{0.000} nm"), ("Tₙ", "@T_n{0.000} GPa"), ("Tₜ", "@T_t{0.000} GPa")]
    for label, (marker, size, _) in NODES.items():
        nodes = hv.Scatter(([], [], [], []), POSITION, [gap, "T_n", "T_t"], label=label)
        elements.append(
            nodes.opts(
                default_tools=[],
                marker=marker,
                size=size,
                tools=["hover"],
                hover_tooltips=[(label, MEANT.get(label, "")), *hover],
            )
        )
    colours = {"substrate": "--text", "body": "--body", "surface": "--body", "sites": "--text"}
    colours |= {label: colour for label, (_, _, colour) in NODES.items()}
    return rendered("punch", elements, colours, x=(-250, 250), y=(-1.2, 7))


def traction():
    """Normal and tangential traction along the interface."""
    value = hv.Dimension("T", label="traction", unit="GPa")
    hover = {"tools": ["hover"], "hover_mode": "vline"}
    elements = [
        hv.HLine(0.0, label="zero").opts(line_width=1),
        curve("T_n", POSITION, value, line_width=2, hover_tooltips=tip("Tₙ", "x", "T", "GPa"), **hover),
        curve("T_t", POSITION, value, line_width=2, line_dash="dashed", **hover).opts(
            hover_tooltips=tip("Tₜ", "x", "T", "GPa")
        ),
    ]
    return rendered("traction", elements, {"zero": "--grid", "T_n": "--normal", "T_t": "--shear"}, y=(-1, 2))


def tip(symbol, x, y, unit):
    return [(f"{'Uₓ' if x == 'U_x' else x}", f"@{x}{{0.0}} nm"), (symbol, f"@{y}{{0.000}} {unit}")]


def forces():
    """Friction and load against the displacement of the top, the previous run pale behind."""
    value = hv.Dimension("value", label="F̄, L̄", unit="10⁻³")
    hover = {"tools": ["hover"], "hover_mode": "vline"}
    elements = [
        hv.HLine(0.0, label="zero").opts(line_width=1),
        curve("ghost_F", SHEAR, value, line_width=3),
        curve("ghost_L", SHEAR, value, line_width=3, line_dash="dashed"),
        curve("F", SHEAR, value, line_width=2, hover_tooltips=tip("F̄", "U_x", "value", "·10⁻³"), **hover),
        curve("L", SHEAR, value, line_width=2, line_dash="dashed", **hover).opts(
            hover_tooltips=tip("L̄", "U_x", "value", "·10⁻³")
        ),
        dots("slips_F", SHEAR, value, marker="diamond", size=8),
        cursor(),
    ]
    colours = {"zero": "--grid", "ghost_F": "--ghost", "ghost_L": "--ghost", "F": "--shear", "L": "--normal"}
    return rendered("forces", elements, colours | {"slips_F": "--slip", "cursor": "--cursor"}, x=(0, 40), y=(-1, 2))


def area():
    """Contact area against the displacement of the top."""
    value = hv.Dimension("value", label="Ā", unit="10⁻³")
    elements = [
        curve("ghost_A", SHEAR, value, line_width=3),
        curve("A", SHEAR, value, line_width=2).opts(
            tools=["hover"], hover_mode="vline", hover_tooltips=tip("Ā", "U_x", "value", "·10⁻³")
        ),
        dots("slips_A", SHEAR, value, marker="diamond", size=8),
        cursor(),
    ]
    colours = {"ghost_A": "--ghost", "A": "--area", "slips_A": "--slip", "cursor": "--cursor"}
    return rendered("area", elements, colours, y=(0, 100))


def contact_map():
    """Normal traction over displacement and place: where the contact repels, adheres or is open, at every moment."""
    blank = np.zeros((2, 2), dtype=np.float32)
    place = hv.Dimension("x", label="x, undeformed", unit="nm")
    image = hv.Image(blank, [SHEAR, place], "T_n", bounds=(0, -1, 1, 1), label="map")
    hover = [("Uₓ", "$x{0.0} nm"), ("x", "$y{0} nm"), ("Tₙ", "@image{0.000} GPa")]
    elements = [
        image.opts(default_tools=[], tools=["hover"], hover_tooltips=hover, clipping_colors={"NaN": "transparent"}),
        dots("slips_map", SHEAR, hv.Dimension("x"), marker="diamond", size=8),
        cursor(),
    ]
    return rendered("map", elements, {"slips_map": "--slip", "cursor": "--cursor"}, y=(-250, 250))


def _compose():
    """All five, with their shared axes linked."""
    made = {view.name: view for view in (punch(), traction(), forces(), area(), contact_map())}
    made["traction"].figure.x_range = made["punch"].figure.x_range
    for name in ("area", "map"):
        made[name].figure.x_range = made["forces"].figure.x_range
    return made


@cache
def _composed(compose):
    """{name: View} as HoloViews made them, and as text from which a visitor's own are read in a third of the time."""
    made = compose()
    return made, json.dumps(Serializer(deferred=False).encode([view.figure for view in made.values()]))


def views(compose=_compose):
    """The views {name: View} of `compose` for one visitor: Bokeh models of their own, under ids of their own."""
    made, text = _composed(compose)
    ids = defaultdict(make_id)

    def own(value):
        return value | {"id": ids[value["id"]]} if "id" in value else value

    mine = {}
    for figure in Deserializer().decode(json.loads(text, object_hook=own)):
        items = {item.name: item for item in (*figure.renderers, *figure.center)}
        parts = {label: items[part.name] for label, part in made[figure.name].parts.items()}
        mine[figure.name] = View(figure.name, figure, parts)
    return mine
