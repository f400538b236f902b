"""The work-precision diagram of a Report as a page of its own: no server, no network."""

from html import escape
from math import ceil, floor, log10
from pathlib import Path

from ..scene import LIMITS
from .measure import SWEEPS
from .verdict import choice, command, failures, notes, sentence, table, title

# Okabe & Ito's colours, told apart by colour-blind readers; markers as well, for print.
STYLE = {  # colour, marker, and pixels that the values stand lower than their points
    "fast": ("#0072B2", "circle", 0),
    "gfmd": ("#D55E00", "square", 0),
    "gfmd mass-weighted": ("#009E73", "triangle", -9),
    "FIRE": ("#CC79A7", "diamond", 9),
}
WORK = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
LEAST = {"seconds": 1e-4, "evaluations": 1}  # a log axis has no zero
FLOOR = 1e-13  # of the error axes: what is smaller, round-off or nothing, is drawn there
LEGEND = 0.1  # of the axis, left above the points
BRANCH = "F, L, A before the first slip: largest relative error"
PLACE = "largest error of a slip's position [nm]"
PANELS = (
    ("tolerance", BRANCH, lambda p: p.branch_error),
    ("du_x", PLACE, lambda p: p.worst("position")),
    ("window_n", BRANCH, lambda p: p.branch_error),
)
CSS = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #fff; max-width: 1120px; margin: 24px auto }
h1 { font-size: 21px; margin: 0 0 4px }
h2 { font-size: 16px; margin: 22px 0 2px }
code { background: #f2f2f2; padding: 2px 5px }
table { border-collapse: collapse; margin: 6px 0 }
td, th { padding: 2px 12px 2px 0; text-align: right; font-variant-numeric: tabular-nums }
td:first-child, th:first-child { text-align: left }
.meaning { font-weight: 600 }
.notes { color: #555; font-size: 13px }
"""


def write_page(file, report):
    """Write the page to a file; raises OSError."""
    with open(file, "w", encoding="utf-8") as out:
        out.write(page(report))


def page(report):
    """The page as HTML text, everything inline."""
    from bokeh.embed import components
    from bokeh.settings import settings

    # as INLINE, but without the widgets, and without what other packages in this process register with it
    library = (Path(settings.bokehjs_path()) / "js" / "bokeh.min.js").read_text(encoding="utf-8")
    script, div = components(diagram(report))
    tables = "".join(_table(report, sweep) for sweep in SWEEPS if report.of(sweep))
    unfinished = "".join(f"<li>{escape(line)}</li>" for line in failures(report))
    about = "".join(f"<li>{escape(line)}</li>" for line in notes(report))
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Error against run time: {escape(title(report))}</title>
<style>{CSS}</style><script>{library}</script></head><body>
<h1>Error against run time: {escape(title(report))}</h1>
<p><code>{escape(command(report))}</code></p>
<p class="meaning">{escape(sentence(report))}</p>
{div}
<ul class="notes">{about}{unfinished}</ul>
{tables}
{script}</body></html>
"""


def diagram(report):
    """Bokeh model: error before the first slip, or place of the slips, against the work; one row for each sweep."""
    import holoviews as hv

    hv.extension("bokeh", logo=False)
    panels = []
    for sweep, label, error in PANELS:
        if any(not p.failure and error(p) is not None for p in report.of(sweep)):
            panels += [_panel(hv, report, sweep, label, error, work) for work in WORK]
    return hv.render(hv.Layout(panels).cols(2).opts(shared_axes=False, toolbar=None), backend="bokeh")


def _panel(hv, report, sweep, label, error, work):
    """One pair of axes: a curve with markers for each series, crosses on runs that left the reference's branches."""
    shown, every, astray = [], [], []
    for series in STYLE:
        points = [p for p in report.of(sweep, series) if not p.failure and error(p) is not None]
        rows = [(max(getattr(p, work), LEAST[work]), max(error(p), FLOOR), _named(p.value)) for p in points]
        every += rows
        astray += [row[:2] for row, p in zip(rows, points, strict=True) if p.branches[0] < p.branches[1]]
        shown += _series(hv, series, rows, work, sweep) if rows else []
    if astray:
        crosses = hv.Points(astray, [work, "error"], label="other branch")
        shown.append(crosses.opts(color="black", marker="x", size=16, line_width=2))
    return hv.Overlay(shown).opts(
        logx=True,
        logy=True,
        xlim=_decades([row[0] for row in every], 3),
        ylim=_decades([row[1] for row in every], 4, LEGEND),
        xlabel=WORK[work],
        ylabel=label,
        title=f"{sweep} swept [{LIMITS[sweep].unit}]: values beside the points",
        width=550,
        height=400,
        show_grid=True,
        legend_position="top_left",
        legend_cols=5,
        legend_opts={"border_line_alpha": 0.0, "margin": 2, "padding": 2},
    )


def _series(hv, series, rows, work, sweep):
    """Line, markers and values of one series; rows of (work, error, value as text)."""
    colour, marker, below = STYLE[series]

    def beside(plot, _):
        plot.handles["glyph"].update(x_offset=8, y_offset=below)

    names = hv.Labels(rows, [work, "error"], sweep).opts(
        text_color=colour, text_font_size="9pt", text_align="left", hooks=[beside]
    )
    line = hv.Curve([row[:2] for row in rows], work, "error", label=series).opts(color=colour, line_width=2)
    dots = hv.Points(rows, [work, "error"], sweep, label=series)
    return [line, dots.opts(color=colour, marker=marker, size=10, tools=["hover"]), names]


def _decades(values, least, above=0.0):
    """(low, high) in whole decades around values > 0, at least so many apart; above: part of them that is left free."""
    low, high = floor(log10(min(values)) - 0.2), log10(max(values)) + 0.2
    high = ceil(high + above * max(high - low, least))
    return 10.0 ** min(low, high - least), 10.0**high


def _named(value):
    """A short number, as beside a point."""
    return f"{value:.0e}".replace("e-0", "e-") if value < 0.01 else f"{value:g}"


def _table(report, sweep):
    """A sweep as an HTML table, with its sentence."""
    head, *rows = table(report, sweep)
    cells = ["".join(f"<th>{escape(cell)}</th>" for cell in head)]
    cells += ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<h2>{sweep}</h2><table>{body}</table><p>{escape(choice(report, sweep))}</p>"
