"""The work-precision diagram of a Report as a page of its own."""

from html import escape

from .. import html_page
from ..scene import LIMITS
from .accuracy import SWEEPS
from .accuracy_text import choice, command, failures, notes, sentence, table, title

# Okabe & Ito's colours, told apart by colour-blind readers; markers as well, for print.
STYLE = {  # colour, marker, and pixels that the values stand lower than their points
    "fast": ("#0072B2", "circle", 5),
    "gfmd": ("#D55E00", "square", 5),
    "gfmd mass-weighted": ("#009E73", "triangle", -4),
    "FIRE": ("#CC79A7", "diamond", 14),
}
WORK = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
LEAST = {"seconds": 1e-4, "evaluations": 1}  # a log axis has no zero
FLOOR = 1e-13  # of the error axes: what is smaller, round-off or nothing, is drawn there
BRANCH = "F, L, A before the first slip: largest relative error"
PLACE = "largest error of a slip's position [nm]"
PANELS = (
    ("tolerance", BRANCH, lambda p: p.branch_error),
    ("du_x", PLACE, lambda p: p.worst("position")),
    ("window_n", BRANCH, lambda p: p.branch_error),
)


def write_page(file, report):
    """Write the page to a file; raises OSError."""
    from bokeh.layouts import gridplot

    panels = [
        [_panel(report, sweep, label, error, work) for work in WORK]
        for sweep, label, error in PANELS
        if any(_drawn(report.of(sweep), error))
    ]
    parts = [
        f"<h1>Error against run time: {escape(title(report))}</h1><p><code>{escape(command(report))}</code></p>",
        f'<p class="meaning">{escape(sentence(report))}</p>',
        gridplot(panels, toolbar_location=None),
        html_page.items([*notes(report), *failures(report)]),
    ]
    for sweep in filter(report.of, SWEEPS):
        parts.append(f"<h2>{sweep}</h2>{html_page.table(table(report, sweep))}<p>{escape(choice(report, sweep))}</p>")
    html_page.write_page(file, f"Error against run time: {title(report)}", *parts)


def _drawn(points, error):
    return [p for p in points if not p.failure and error(p) is not None]


def _panel(report, sweep, label, error, work):
    """One pair of axes: a curve with markers for each series, crosses on runs that left the right branches."""
    from bokeh.plotting import figure

    shown = figure(
        x_axis_type="log",
        y_axis_type="log",
        x_axis_label=WORK[work],
        y_axis_label=label,
        title=f"{sweep} swept [{LIMITS[sweep].unit}]: values beside the points",
        tools="hover",
        tooltips=[(sweep, "@name"), (work, "@x"), ("error", "@y")],
        width=550,
        height=430,
    )
    for series, (colour, marker, below) in STYLE.items():
        points = _drawn(report.of(sweep, series), error)
        if not points:
            continue
        source = {
            "x": [max(getattr(p, work), LEAST[work]) for p in points],
            "y": [max(error(p), FLOOR) for p in points],
            "name": [f"{p.value:g}" for p in points],
        }
        shown.line(source["x"], source["y"], color=colour, width=2, legend_label=series)
        dots = shown.scatter(source=source, size=10, color=colour, marker=marker, legend_label=series)
        shown.text(source=dots.data_source, text="name", color=colour, text_font_size="9pt", x_offset=8, y_offset=below)
        astray = [k for k, p in enumerate(points) if p.branches[0] < p.branches[1]]
        if astray:
            at = ([source[axis][k] for k in astray] for axis in "xy")
            shown.scatter(*at, size=16, marker="x", color="black", line_width=2, legend_label="other branch")
    shown.legend.update(orientation="horizontal", border_line_alpha=0.0, label_text_font_size="8pt")
    shown.add_layout(shown.legend[0], "above")
    return shown
