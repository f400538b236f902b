"""Figures with Bokeh whose curves can be drawn again: of the research pages, and of reports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import zip_longest
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from bokeh.plotting import figure

# Colours of Okabe & Ito, which colour-blind readers distinguish
COLOURS = BLUE, ORANGE, *_ = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"
DASHES = "solid", "6 4", "2 4", "2 4 6 4", "6 4 2 4", "solid"  # px of line and gap
METHODS = {"fast": (BLUE, "circle"), "gfmd": (ORANGE, "square")}  # colour and marker of each
WORKS = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
LEAST = 1e-13  # drawn on logarithmic axes, which have no zero
PALE = 0.3  # opacity of other runs
TOOLS = "pan,wheel_zoom,box_zoom,save,reset"
LOOK = {"height": 380, "sizing_mode": "stretch_width", "frame_align": False, "tools": TOOLS}


class Curve(NamedTuple):
    """A line through (x, y), or markers there. Lines, and markers, with the same label share an entry of the legend.

    size: width of the line, or of a marker, px; values: shown with the points when the pointer is over them.
    """

    label: str
    x: Sequence[float] | np.ndarray
    y: Sequence[float] | np.ndarray
    color: str = BLUE
    dash: str = "solid"
    marker: str = ""
    size: float = 2.0
    alpha: float = 1.0
    values: Sequence[str] = ()


def chart(curves: Sequence[Curve], x: str, y: str, beside: bool = False, **look: Any) -> figure:
    """A figure of curves over axes with these labels; look: of `bokeh.plotting.figure`.

    beside: whether values are also printed beside points that are not pale.
    """
    from bokeh.models import ColumnDataSource, HoverTool, Legend, LegendItem, MultiLine, Scatter, Text
    from bokeh.plotting import figure

    plot, marks = figure(x_axis_label=x, y_axis_label=y, **LOOK | look), ColumnDataSource()
    common = {"line_color": "color", "line_alpha": "alpha"}
    lines = MultiLine(xs="x", ys="y", line_dash="dash", line_width="size", **common)
    filled = {"fill_color": "color", "fill_alpha": "alpha"}
    parts = [
        plot.add_glyph(ColumnDataSource(), lines),
        plot.add_glyph(marks, Scatter(x="x", y="y", marker="marker", size="size", **common, **filled)),
    ]
    draw(plot, curves)
    if beside:
        plot.x_range.range_padding = 0.4  # share of the data's range, for text
        text = {"text_baseline": "middle", "text_font_size": "14px", "x_offset": 8, "text_color": "color"}
        plot.add_glyph(marks, Text(x="x", y="y", text="beside", **text))
    named = [part for part in parts if any(part.data_source.data["label"])]
    if named:
        items = [LegendItem(label={"field": "label"}, renderers=[part]) for part in named]
        plot.add_layout(Legend(items=items, ncols=2, location="left", margin=0, padding=4, glyph_width=14), "above")
    tips = [("", "@label @value"), (x, "$snap_x"), (y, "$snap_y")]
    plot.add_tools(HoverTool(renderers=parts, tooltips=tips, line_policy="nearest"))
    return plot


def draw(plot: figure, curves: Iterable[Curve]) -> None:
    """Show curves in a chart in place of its own. Its legend has those that were there first."""
    curves, (lines, marks) = list(curves), (part.data_source for part in plot.renderers[:2])
    points = [point for curve in curves if curve.marker for point in _points(curve)]
    rows = [curve for curve in curves if not curve.marker]
    if not any(len(curve.x) for curve in curves):  # Bokeh has no range for axes without data
        rows.append(Curve(rows[0].label if rows else "", [0.1, 1.0], [0.1, 1.0], alpha=0.0))
    lines.data = _columns(rows)
    marks.data = _columns(points) | {"beside": [point.values if point.alpha > PALE else "" for point in points]}


def _columns(rows):
    return {name: [getattr(row, name) for row in rows] for name in Curve._fields}


def _points(curve):
    """A Curve for each point, after one without a place: it keeps a curve without points in the legend."""
    for x, y, value in [(nan, nan, ""), *zip_longest(curve.x, curve.y, curve.values, fillvalue="")]:
        yield curve._replace(x=x, y=y, values=value)


def work_precision(points: Iterable[Any], work: str, alpha: float = 1.0) -> list[Curve]:
    """Lines with markers, one a method: error over `work`, seconds or evaluations, of Points of `accuracy.compare`."""
    drawn = []
    for name, (colour, marker) in METHODS.items():
        own = [p for p in points if p.series == name and not p.failure and p.branch_error is not None]
        at = [max(getattr(p, work), LEAST) for p in own], [max(p.branch_error, LEAST) for p in own]
        drawn += [
            Curve(name, *at, colour, alpha=alpha),
            Curve("", *at, colour, marker=marker, size=9.0, alpha=alpha, values=[f"{p.value:g}" for p in own]),
        ]
    return drawn
