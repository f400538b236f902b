"""The work-precision diagram of a Report as a page of its own."""

from collections.abc import Callable
from html import escape
from typing import NamedTuple

from .. import html_page
from ..scene import LIMITS
from .accuracy import LEAST, SWEEPS, Report
from .accuracy_text import choice, command, failures, notes, sentence, table, title


class Style(NamedTuple):
    """The look of a series in colours of Okabe & Ito, which colour-blind readers distinguish; markers for print."""

    colour: str
    marker: str
    below: int  # pixels between a point and the value beside it


class Panel(NamedTuple):
    """A row of diagrams: the parameter swept, the error shown and its name."""

    sweep: str
    label: str
    error: Callable


STYLE = {
    "fast": Style("#0072B2", "circle", 5),
    "gfmd": Style("#D55E00", "square", 5),
    "gfmd mass-weighted": Style("#009E73", "triangle", -4),
    "FIRE": Style("#CC79A7", "diamond", 14),
}
WORK = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
WIDER = 2.5  # factor of the largest work at which the axis ends, for the value beside the last point
PANELS = (
    Panel("tolerance", "F, L, A before the first slip: largest relative error", lambda p: p.branch_error),
    Panel("du_x", "largest error of a slip's position [nm]", lambda p: p.worst("position")),
)


def write_page(file, report: Report) -> None:
    """Write the page to a file; raises OSError."""
    from bokeh.layouts import gridplot

    shown = [panel for panel in PANELS if _drawn(report.of(panel.sweep), panel)]
    diagrams = [[_diagram(report, panel, work) for work in WORK] for panel in shown]
    parts = [
        f"<h1>Error against run time: {escape(title(report))}</h1><p><code>{escape(command(report))}</code></p>",
        f'<p class="meaning">{escape(sentence(report))}</p>',
        gridplot(diagrams, toolbar_location=None),
        html_page.items([*notes(report), *failures(report)]),
    ]
    for sweep in filter(report.of, SWEEPS):
        parts.append(f"<h2>{sweep}</h2>{html_page.table(table(report, sweep))}<p>{escape(choice(report, sweep))}</p>")
    html_page.write_page(file, f"Error against run time: {title(report)}", *parts)


def _drawn(points, panel):
    return [p for p in points if not p.failure and panel.error(p) is not None]


def _diagram(report, panel, work):
    """One pair of axes: a curve with markers for each series, crosses on runs that left the right branches."""
    from bokeh.plotting import figure

    def work_of(p):
        return max(getattr(p, work), LEAST[work])

    spent = [work_of(p) for p in _drawn(report.of(panel.sweep), panel)]
    shown = figure(
        x_axis_type="log",
        y_axis_type="log",
        x_range=(min(spent) / WIDER**0.5, max(spent) * WIDER),
        x_axis_label=WORK[work],
        y_axis_label=panel.label,
        title=f"{panel.sweep} swept [{LIMITS[panel.sweep].unit}]: values beside the points",
        tools="hover",
        tooltips=[(panel.sweep, "@name"), (work, "@x"), ("error", "@y")],
        width=550,
        height=430,
    )
    for series, style in STYLE.items():
        points = _drawn(report.of(panel.sweep, series), panel)
        errors = [max(panel.error(p), LEAST["error"]) for p in points]
        source = {"x": [work_of(p) for p in points], "y": errors, "name": [f"{p.value:g}" for p in points]}
        if points:
            shown.line(source["x"], source["y"], color=style.colour, width=2, legend_label=series)
            dots = {"source": source, "size": 10, "marker": style.marker}
            source = shown.scatter(**dots, color=style.colour, legend_label=series).data_source
            look = {"color": style.colour, "text_font_size": "9pt", "x_offset": 8, "y_offset": style.below}
            shown.text(source=source, text="name", **look)
        astray = [(work_of(p), error) for p, error in zip(points, errors, strict=True) if not p.right]
        if astray:
            cross = {"size": 16, "marker": "x", "color": "black", "line_width": 2, "legend_label": "other branch"}
            shown.scatter(*zip(*astray, strict=True), **cross)
    shown.legend.update(orientation="horizontal", border_line_alpha=0.0, label_text_font_size="8pt")
    shown.add_layout(shown.legend[0], "above")
    return shown
