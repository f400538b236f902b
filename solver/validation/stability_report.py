"""The stability report as text, as plain data, and as a page that opens offline."""

from dataclasses import asdict
from html import escape

from .. import html_page
from .stability import BAD, GOOD, by_region, counts, unstable

FRAMES = ("unstable", "said", "judged")  # as `unstable` counts them
COLOURS = ("#0072B2", "#BBBBBB", "#E69F00", *["#D55E00"] * len(BAD))  # Okabe & Ito; what must not be is red


def failed(results, forms, limits):
    """Whether anything came out as it must not."""
    return (
        any(r["verdict"] in BAD for r in results)
        or not all(form.held for form in forms)
        or any(limit.attained > limit.allowed for limit in limits)
    )


def data(results, forms, limits):
    """Everything as plain types."""
    return {
        "counts": counts(results),
        "converged_of_valid": share(results),
        "unstable_frames": dict(zip(FRAMES, unstable(results), strict=True)),
        "regions": {
            name: counts(some) | dict(zip(FRAMES, unstable(some), strict=True)) for name, some in by_region(results)
        },
        "closed_forms": [asdict(row) | {"held": row.held} for row in forms],
        "conditioning": [asdict(limit) for limit in limits],
        "scenes": results,
    }


def share(results):
    """Converged scenes over valid ones."""
    valid = [r for r in results if r["verdict"] != "refused"]
    return sum(r["verdict"] == "converged" for r in valid) / max(1, len(valid))


def tables(results, forms, limits):
    """[(title, DataFrame of text)] of the whole report."""
    from pandas import DataFrame  # takes longer to import than the solver

    sheets = [_scenes(results), _closed_forms(forms), _conditioning(limits), *_not_converged(results)]
    return [(title, DataFrame(rows, columns=header)) for title, header, rows in sheets]


# Each of these is (title, header, rows) of one table.


def _scenes(results):
    title = f"Scenes: {len(results)}; converged: {100 * share(results):.2f}% of the valid ones; unstable frames:"
    title += " {}, and {} that say so, of {} judged by the spectrum of the motion".format(*unstable(results))
    groups = ("all", results), *by_region(results)
    rows = [(name, *counts(some).values(), "{}, {} of {}".format(*unstable(some))) for name, some in groups]
    return title, ("probed", *GOOD, *BAD, "unstable frames, those that say so"), rows


def _closed_forms(forms):
    header = "form", "error", "allowed", "held", "reason for what is allowed", "source"
    rows = [
        (f.name, f"{f.error:.1e}", f"{f.tolerance:.0e}", "yes" if f.held else "NO", f.reason, f.source) for f in forms
    ]
    return "Closed forms", header, rows


def _conditioning(limits):
    title = "Conditioning: relative error attained, and by the printed formula in float64 (nan: it overflows)"
    rows = [(c.name, f"{c.attained:.1e}", _number(c.textbook), c.remedy) for c in limits]
    return title, ("where", "attained", "as printed", "remedy"), rows


def _not_converged(results):
    header = "verdict", "python -m solver run", "reason"
    lost = [r for r in results if r["verdict"] not in ("converged", "refused")]
    refused = [r for r in results if r["verdict"] == "refused" != r["kind"]]
    gave_up = [(r["verdict"], r["set"], r["reason"]) for r in lost] or [("none", "", "")]
    yield "Scenes that gave up, or worse", header, gave_up
    combined = [("refused", r["set"], r["reason"]) for r in refused]
    yield "Scenes within every range, refused for their combination", header, combined


def _number(value):
    return "" if value is None else f"{value:.1e}"


def text(results, forms, limits):
    """The tables for a terminal."""
    shown = tables(results, forms, limits)
    return "\n".join(f"{title}\n{frame.to_string(index=False, justify='left')}\n" for title, frame in shown)


def write_page(file, results, forms, limits):
    """Write the tables and two diagrams as one HTML file; raises OSError."""
    note = (
        "Every scene is an approach and a short shear. A sample of its frames is judged by sums written out spring by"
        " spring and mode by mode in long double, which share no code with the solver, and by the dense spectrum of the"
        " motion."
    )
    parts = [f"<h1>Stability on stiff and extreme scenes</h1><p>{note}</p>", _bars(results), _residuals(results)]
    for title, frame in tables(results, forms, limits):
        parts.append(f"<h2>{escape(title)}</h2>{html_page.table(frame, 'words' if len(frame.columns) < 5 else None)}")
    html_page.write_page(file, "Stability of the contact solver", *parts)


def _bars(results):
    """Scenes by what was probed, stacked by verdict."""
    from bokeh.plotting import figure

    regions = [(name, counts(some)) for name, some in by_region(results)]
    names = [name for name, _ in regions][::-1]
    source = {verdict: [found[verdict] for _, found in regions][::-1] for verdict in (*GOOD, *BAD)} | {"name": names}
    shown = figure(
        y_range=names, height=120 + 18 * len(names), width=1000, x_axis_label="scenes", toolbar_location=None
    )
    verdicts = [v for v in (*GOOD, *BAD) if any(source[v])]
    colours = [dict(zip((*GOOD, *BAD), COLOURS, strict=True))[v] for v in verdicts]
    shown.hbar_stack(verdicts, y="name", height=0.8, color=colours, source=source, legend_label=verdicts)
    shown.add_layout(shown.legend[0], "right")
    return shown


def _residuals(results):
    """The recomputed residual over the tolerance, against the force evaluations spent."""
    from bokeh.plotting import figure

    some = [r for r in results if r.get("residual") and r.get("evaluations")]
    axes = {"x_axis_label": "force evaluations of the scene", "y_axis_label": "recomputed residual / tolerance"}
    shown = figure(height=320, width=1000, x_axis_type="log", y_axis_type="log", toolbar_location=None, **axes)
    shown.scatter([r["evaluations"] for r in some], [r["residual"] for r in some], size=4, color=COLOURS[0], alpha=0.5)
    return shown
