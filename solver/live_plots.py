"""Plots of research pages with HoloViews and Bokeh: they fill the width of a page and follow its data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import cycle
from math import isfinite
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from .analysis.friction_laws import Onset
from .plots import drawn_with
from .scene import LIMITS, Scene

if TYPE_CHECKING:
    import holoviews as hv

METHODS = {"fast": ("#0072B2", "circle"), "gfmd": ("#D55E00", "square")}  # colour and marker of each
WORKS = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
LEAST = 1e-13  # drawn on logarithmic axes, which have no zero
# Colours of Okabe & Ito, which colour-blind readers distinguish, and dashes for print
COLOURS = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"
MARKERS = "circle", "square", "triangle", "diamond"
DASHES = "solid", "dashed", "dotted", "dotdash", "dashdot"
LIVE = {
    "responsive": True,
    "height": 380,
    "show_grid": True,
    "padding": 0.05,
    "legend_position": "top",
    "legend_cols": 3,
}


@drawn_with("bokeh")
def work_precision(
    points: Iterable[Any],
    work: str,
    before: Iterable[Any] = (),
    error: Callable[[Any], float | None] = attrgetter("branch_error"),
    label: str = "largest relative error",
    swept: str = "tolerance",
) -> hv.Overlay:
    """Error over `work`, seconds or evaluations, of runs at the values of `swept` beside the points.

    points: as of `accuracy.compare.Point`; before: other runs, drawn pale; error, label: of the vertical axis.
    """
    import holoviews as hv

    kdim, vdim = hv.Dimension(work, label=WORKS[work]), hv.Dimension("error", label=label)
    parts = []
    for runs, alpha in ((before, 0.3), (points, 1.0)):
        for name, (colour, marker) in METHODS.items():
            own = [p for p in runs if p.series == name and not p.failure and error(p) is not None]
            errors = [max(error(p) or 0.0, LEAST) for p in own]
            at = [max(getattr(p, work), LEAST) for p in own], errors
            values = [f"{p.value:g}" for p in own]
            look = {"color": colour, "alpha": alpha}
            marks = hv.Points((*at, values), [kdim, vdim], hv.Dimension(swept, label=f"{swept} ({LIMITS[swept].unit})"))
            parts += [
                hv.Curve(at, kdim, vdim, label=name if alpha == 1.0 else "").opts(**look),
                marks.opts(size=9, marker=marker, tools=["hover"], **look),
            ]
            if alpha == 1.0:
                labels = hv.Labels((*at, [f"   {each}" for each in values]), [kdim, vdim], "beside")
                parts += [labels.opts(text_color=colour, text_font_size="9pt", xoffset=0.0, text_align="left")]
    return _live(parts, logx=True, logy=True, padding=0.15)


@drawn_with("bokeh")
def curves(drawn: Mapping[str, tuple[Sequence[float], Sequence[float]]], x: str, y: str) -> hv.Overlay:
    """Curves {label: (x, y)} with a legend; x, y: labels of the axes."""
    import holoviews as hv

    kdim, vdim = hv.Dimension("x", label=x), hv.Dimension("y", label=y)
    parts = [
        hv.Curve(drawn.get(label, ([], [])), kdim, vdim, label=label).opts(
            tools=["hover"], line_dash=dash, color=colour
        )
        for label, dash, colour in zip(drawn or [""], cycle(DASHES), cycle(COLOURS))
    ]
    return _live(parts)


@drawn_with("bokeh")
def mean_curve(exact: Any, runs: Mapping[float, float], own: float, critical: float) -> hv.Overlay:
    """Mean friction over w tau_max over E/tau_max: in closed form, as (ratios, means), and of runs.

    own: E/tau_max of a scene; critical: from which on sliding is smooth; both inf without friction.
    """
    import holoviews as hv

    kdim, vdim = hv.Dimension("ratio", label="E/τₘₐₓ"), hv.Dimension("mean", label="⟨F⟩/(w τₘₐₓ)")
    ratios, means = exact or ([], [])
    at = [own] if exact and isfinite(own) else []
    parts = [
        hv.Curve((ratios, means), kdim, vdim, label="closed form").opts(color=COLOURS[0], tools=["hover"]),
        hv.Scatter((list(runs), list(runs.values())), kdim, vdim, label="runs").opts(size=9, color="gray"),
        hv.Scatter((at, np.interp(np.log(at), np.log(ratios), means) if at else []), kdim, vdim, label="this scene"),
        hv.Curve(([critical] * 2, [0.0, 1.0]) if at else ([], []), kdim, vdim, label="sliding is smooth beyond"),
    ]
    parts[2].opts(size=14, marker="diamond", color=COLOURS[1])
    parts[3].opts(color="gray", line_dash="dashed")
    return _live(parts, logx=True)


@drawn_with("bokeh")
def friction_map(
    exact: Any, scene: Scene, slopes: tuple[float, float], moduli: tuple[float, float], strengths: tuple[float, float]
) -> hv.Overlay:
    """Mean friction over w tau_max over log10 of E (GPa) and of phi_t (N/m); exact: (ratios, means) of the layer.

    slopes: tau_max and the critical modulus over phi_t, GPa m/N; moduli, strengths: ends of the axes.
    The line is the critical modulus: stick-slip to its left, continuous sliding to its right.
    """
    import holoviews as hv

    E, phi_t = (np.geomspace(*ends, 120) for ends in (moduli, strengths))
    ratios, means = exact or (np.ones(1), np.zeros(1))
    over = E / (phi_t[:, None] * slopes[0])
    image = np.interp(np.log(over), np.log(ratios), means, left=means[0], right=0.0)
    kdims = [hv.Dimension("E", label="E (GPa)"), hv.Dimension("phi_t", label="φₜ (N/m)")]
    vdim = hv.Dimension("mean", label="⟨F⟩/(w τₘₐₓ)")
    line = slopes[1] * phi_t
    own = [(np.log10(scene.E), np.log10(scene.phi_t))] if scene.phi_t >= strengths[0] else []
    ticks = {"xticks": [(1, "10"), (2, "100"), (3, "1000")], "yticks": [(-2, "0.01"), (-1, "0.1"), (0, "1")]}
    parts = [
        hv.Image((np.log10(E), np.log10(phi_t), image), kdims, vdim).opts(
            colorbar=True, cmap="cividis", tools=["hover"]
        ),
        hv.Path([np.log10([line, phi_t]).T], kdims).opts(color="white", line_width=3),
        hv.Points(own, kdims).opts(color="white", marker="diamond", size=14),
    ]
    ends = {"xlim": tuple(np.log10(moduli)), "ylim": tuple(np.log10(strengths))}
    return _live(parts, **ticks, **ends)


@drawn_with("bokeh")
def area_curves(runs: Mapping[float, Onset], laws: Mapping[float, Any]) -> hv.Overlay:
    """A_bar over F_bar of each Onset {delta_bar: Onset}, its QuadraticLaw or None of `laws`, and where it slips."""
    import holoviews as hv

    kdim, vdim = hv.Dimension("F", label="F̄ (10⁻³)"), hv.Dimension("A", label="Ā (10⁻³)")
    drawn = [(law, runs[depth].F) for depth, law in laws.items() if law]
    measured = _joined([(1e3 * run.F, 1e3 * run.A) for run in runs.values()])
    fits = _joined([(1e3 * F, 1e3 * np.maximum(law.A_0 - law.zeta * F**2, 0.0)) for law, F in drawn])
    parts = [
        hv.Curve(measured, kdim, vdim, label="runs").opts(color=COLOURS[0]),
        hv.Curve(fits, kdim, vdim, label="Ā₀ − ζF̄² (Eq. 8)").opts(color=COLOURS[1], line_dash="dashed"),
        hv.Points(_slips(runs), [kdim, vdim], "delta_bar", label="onset").opts(color="gray", size=8, tools=["hover"]),
    ]
    return _live(parts)


@drawn_with("bokeh")
def thresholds(series: Mapping[str, Mapping[float, Onset]], line_of: Callable[[Any], Any], beyond: float) -> hv.Overlay:
    """A_bar over F_bar at the slips of {series: {delta_bar: Onset}}, and the threshold law of each series.

    Slips from delta_bar = beyond on are crosses: they are not part of the law.
    """
    import holoviews as hv

    kdims, parts = [hv.Dimension("F", label="F̄ (10⁻³)"), hv.Dimension("A", label="Ā (10⁻³)")], []
    for (name, runs), marker, colour in zip(series.items(), cycle(MARKERS), cycle(COLOURS)):
        law, slips = line_of(runs), _slips(runs)
        line = [(1e3 * law.F_nc + law.tau_c * A, A) for A in (0.0, max(A for _, A, _ in slips))] if law else []
        look = {"color": colour, "size": 9, "tools": ["hover"]}
        inside, outside = ([slip for slip in slips if (slip[2] >= beyond) is late] for late in (False, True))
        parts += [
            hv.Curve(line, *kdims).opts(color=colour),
            hv.Points(inside, kdims, "delta_bar", label=name).opts(marker=marker, **look),
            hv.Points(outside, kdims, "delta_bar").opts(marker="x", **look),
        ]
    return _live(parts)


@drawn_with("bokeh")
def measured_curves(measured: Any, curve: Any, found: Any, scene: Scene) -> hv.Overlay:
    """F and L over U_x: a Measurement, the curve (U_x nm, F N/m, L N/m) of a scene, and a Fit; each may be None."""
    import holoviews as hv

    kdim, vdim = hv.Dimension("U_x", unit="nm"), hv.Dimension("force", unit="N/m")
    unit = getattr(measured, "unit", None) or scene.width * scene.E
    values, rows = getattr(measured, "values", {}), found.rows if found else ()
    U, *forces = curve if curve is not None else ([], [], [])
    parts = []
    for name, force, colour, dash in (
        ("F_bar", forces[0], COLOURS[0], "solid"),
        ("L_bar", forces[1], "gray", "dashed"),
    ):
        seen = (measured.U_x, values[name] * unit) if name in values else ([], [])
        fitted = [(U_x, model * unit) for U_x, quantity, _, model in rows if quantity == name]
        parts += [
            hv.Scatter(seen, kdim, vdim, label=f"{name[0]} measured").opts(color=colour, size=3, alpha=0.5),
            hv.Curve((U, force), kdim, vdim, label=f"{name[0]} of the sliders").opts(color=colour, line_dash=dash),
            hv.Curve(fitted, kdim, vdim, label=f"{name[0]} fitted").opts(
                color=COLOURS[1], line_dash=dash, line_width=3
            ),
        ]
    return _live(parts)


@drawn_with("bokeh")
def residuals(measured: Any, curve: Any, found: Any, scene: Scene) -> hv.Overlay:
    """Fitted less measured F over its noise, over U_x; arguments as of `measured_curves`."""
    import holoviews as hv

    kdim, vdim = hv.Dimension("U_x", unit="nm"), hv.Dimension("difference", label="fitted − measured (noise)")
    rows = [(U_x, model - seen) for U_x, quantity, seen, model in (found.rows if found else ()) if quantity == "F_bar"]
    noise = measured.noise["F_bar"] if measured else 1.0
    points = hv.Scatter([(U_x, off / noise) for U_x, off in rows], kdim, vdim).opts(color=COLOURS[1], size=4)
    return _live([points, hv.HLine(0.0).opts(color="gray", line_width=1)])


def _slips(runs):
    """(F_bar, A_bar in 1e-3, delta_bar) of each Onset {delta_bar: Onset} that slips."""
    return [(1e3 * run.F_s, 1e3 * run.A_s, depth) for depth, run in runs.items() if run.F_s]


def _live(parts, **more):
    """The overlay of a page, whose axes follow the data."""
    import holoviews as hv

    kinds = hv.opts.Curve, hv.opts.Scatter, hv.opts.Points
    return hv.Overlay(parts).opts(*(kind(framewise=True) for kind in kinds), hv.opts.Overlay(**LIVE | more))


def _joined(pairs):
    """One curve (x, y) of many, with gaps between them."""
    if not pairs:
        return [], []
    return tuple(np.concatenate([np.append(pair[k], np.nan) for pair in pairs]) for k in (0, 1))
