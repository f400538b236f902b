"""The figures of the pages: composed once with HoloViews; from then on only their sources change."""

import json
from collections import defaultdict
from dataclasses import dataclass
from functools import cache

import holoviews as hv
import numpy as np
from bokeh.core.serialization import Deserializer, Serializer
from bokeh.models import HoverTool, Legend
from bokeh.util.serialization import make_id

from app.views.live import AXIS, FRAME, ONE_LOOK


@dataclass
class View:
    """One Bokeh figure with what changes in it: {label: renderer, band or line}.

    A part is called "figure.label", and has the colour of style.css that its tag names.
    """

    figure: object
    parts: dict


@cache
def load():
    """Load HoloViews' half of Bokeh, which takes a second: before anything is composed."""
    hv.extension("bokeh", logo=False)


def _empty(kind, label, dimensions, said, options):
    x, *others = dimensions
    hover = {"tools": ["hover"], "hover_tooltips": said} if said else {}
    return kind(tuple([] for _ in dimensions), x, others, label=label).opts(default_tools=[], **hover, **options)


def curve(label, *dimensions, said=None, **options):
    """A line over the first two dimensions; what is `said` when one points at it may name the others."""
    return _empty(hv.Curve, label, dimensions, said, options)


def dots(label, *dimensions, said=None, **options):
    """Marks, as `curve`."""
    return _empty(hv.Scatter, label, dimensions, said, options)


def picture(label, x, y, value, said=None, bounds=(0, 0, 1, 1), **options):
    """An image of a value over x and y."""
    blank, hover = np.zeros((2, 2), np.float32), {"tools": ["hover"], "hover_tooltips": said} if said else {}
    return hv.Image(blank, [x, y], value, bounds=bounds, label=label).opts(default_tools=[], **hover, **options)


def rendered(name, elements, colours, **ranges):
    """A Bokeh figure of an overlay, what will be changed in it named by its label."""
    overlay = hv.Overlay(elements).opts(show_legend=False, responsive=True, toolbar=None, default_tools=[], title="")
    plot = hv.renderer("bokeh").get_plot(overlay)
    figure = plot.state
    for element, subplot in zip(elements, plot.subplots.values(), strict=True):
        part = subplot.handles.get("glyph_renderer", subplot.handles["glyph"])
        part.update(name=f"{name}.{element.label}", tags=[colours.get(element.label, "")])
        if "glyph_renderer" in subplot.handles:
            part.update(**ONE_LOOK)
    figure.update(name=name, title=None, **FRAME)
    figure.center = [item for item in figure.center if not isinstance(item, Legend)]
    figure.toolbar.tools = [tool for tool in figure.tools if isinstance(tool, HoverTool)]
    figure.yaxis.ticker.desired_num_ticks = 4
    labelled = next(element for element in elements if isinstance(element, hv.Curve | hv.Image))
    for axis, dimension in zip((*figure.xaxis, *figure.yaxis), labelled.dimensions(), strict=False):
        axis.update(axis_label=dimension.pprint_label, **AXIS)
    for axis, (low, high) in ranges.items():
        getattr(figure, f"{axis}_range").update(start=low, end=high)
    return figure


@cache
def composed(compose):
    """The figures of a page as text, from which a visitor's own are read in a third of the time."""
    load()
    return json.dumps(Serializer(deferred=False).encode(compose()))


def views(compose):
    """[View] of `compose` for one visitor: Bokeh models of their own, under ids of their own."""
    ids = defaultdict(make_id)

    def own(value):
        return value | {"id": ids[value["id"]]} if "id" in value else value

    return [_view(figure) for figure in Deserializer().decode(json.loads(composed(compose), object_hook=own))]


def _view(figure):
    named = [part for part in (*figure.renderers, *figure.center) if part.name]
    return View(figure, {part.name.removeprefix(f"{figure.name}."): part for part in named})
