"""Plots of results with HoloViews, for notebooks and for files that open without internet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.util import find_spec
from itertools import cycle
from math import isfinite
from operator import attrgetter
from os import PathLike
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from .run.frame import Frame
from .run.load_steps import abscissa, place
from .run.summary import fields_of
from .scene import LIMITS, PARAMETERS, Scene

if TYPE_CHECKING:
    import holoviews as hv
    import pandas as pd

METHODS = {"fast": ("#0072B2", "circle"), "gfmd": ("#D55E00", "square")}  # colour and marker of each
WORKS = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
LEAST = 1e-13  # drawn on logarithmic axes, which have no zero
ROWS = 120  # of a map of friction
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
}  # on a page
BACKENDS = {".html": "bokeh", ".png": "matplotlib", ".svg": "matplotlib"}
LINE = 90  # characters of a line of the title
# Below each other: as wide as a column of text, three on one screen
SIZES = {"bokeh": {"width": 700, "height": 240}, "matplotlib": {"aspect": 3}}
UNITS = {"U_s": "nm", "F_s": "N/m", "A_s": "nm", "A_0": "nm", "L_min": "N/m"}


def experiment(scene: Scene, frames: Sequence[Frame], over_top: bool = False) -> hv.Layout:
    """F and L, A, and T_z over x, along U_x, or delta, or the path: see `load_steps.abscissa`; over_top: of the top."""
    import holoviews as hv

    _ready()
    along = abscissa(scene)
    across, force, area = (
        hv.Dimension(f"{along}_top" if over_top else along, unit="nm"),
        hv.Dimension("force", unit="N/m"),
        hv.Dimension("A", unit="nm"),
    )
    at = [getattr(f, f"{along}_top") if over_top else place(f) for f in frames]
    forces = hv.Overlay(
        [hv.Curve((at, [getattr(f, name) for f in frames]), across, force, label=name) for name in "FL"]
    )
    areas = hv.Curve((at, [frame.A for frame in frames]), across, area)
    return _sized(forces + areas + _contact_map(scene, frames, hv.Dimension(along, unit="nm")))


def _contact_map(scene, frames, across):
    """T_z (GPa, repulsion positive) over x from the middle of the cell and U_x; increments where U_x turns back."""
    import holoviews as hv

    fields = fields_of(frames)
    x, T_z = fields["x"], fields["T"][:, 1]
    at: Any = [frame.U_x for frame in frames]
    if np.any(np.diff(at) <= 0.0):
        across, at = hv.Dimension("increment"), range(len(frames))
    most = np.abs(T_z).max()
    value = hv.Dimension("T_z", label="normal traction T_z", unit="GPa", range=(-most, most))
    kdims = [across, hv.Dimension("x", unit="nm")]
    return hv.QuadMesh((at, x, T_z.T), kdims, value).opts(hv.opts.QuadMesh(cmap="RdBu_r", colorbar=True))


def comparison(rows: Iterable[tuple[float, str, float, float]]) -> hv.Layout:
    """Measured points, the fitted curve and their difference, from (U_x nm, quantity, measured, model)."""
    import holoviews as hv

    _ready()
    by: dict[str, list[tuple[float, float, float]]] = {}
    for U_x, quantity, measured, model in rows:
        by.setdefault(quantity, []).append((U_x, measured, model))
    plots, across = [], hv.Dimension("U_x", unit="nm")
    for quantity, points in by.items():
        U_x, measured, model = np.array(points).T
        data = hv.Scatter((U_x, measured), across, quantity, label="measured").opts(color="gray")
        plots += [data * hv.Curve((U_x, model), across, quantity, label="model")]
        plots += [hv.Scatter((U_x, measured - model), across, f"{quantity}: measured - model")]
    return _sized(hv.Layout(plots))


def first_slips(table: pd.DataFrame, x: str, y: str, of: str | None) -> hv.Layout:
    """A column of a map (default: U_s) over its two parameters, and the regimes; points without a value are blank."""
    import holoviews as hv
    import pandas as pd

    _ready()
    kdims = [hv.Dimension(name, unit=LIMITS[name].unit or None) for name in (x, y)]
    column = of if of not in (None, "regime") else "U_s"
    table = table.sort_values([y, x])
    cells = pd.DataFrame(
        {name: [f"{value:.4g}" for value in table[name]] for name in (x, y)}
    )  # of one size on any axis
    cells[column] = [float(value) if value not in ("", None) else np.nan for value in table[column]]
    cells["regime"] = [regime or "no result" for regime in table["regime"]]
    numbers = hv.HeatMap(cells, kdims, hv.Dimension(column, unit=UNITS.get(column)))
    regimes = {name: hv.Points(part, kdims, []) for name, part in cells.groupby("regime", sort=False)}
    return _sized(numbers.opts(hv.opts.HeatMap(colorbar=True)) + hv.NdOverlay(regimes, kdims="regime"))


def friction_over_load(table: pd.DataFrame) -> hv.Overlay:
    """F_s over L_s of the first slips in a table of `sweep`, and the line L = 0, where adhesion alone holds.

    The columns of parameters colour the points, the first one, and name them, all.
    """
    import holoviews as hv

    _ready()
    names = [name for name in table if name in PARAMETERS]
    slips = table[table["outcome"] == "slips"]
    points = hv.Points(slips, ["L_s (N/m)", "F_s (N/m)"], names)
    colour = {"color": names[0], "colorbar": True} if names else {}
    return (points.opts(size=8, tools=["hover"], **SIZES["bokeh"], **colour, backend="bokeh")) * hv.VLine(0.0)


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

    _ready()
    kdim, vdim = hv.Dimension(work, label=WORKS[work]), hv.Dimension("error", label=label)
    parts = []
    for runs, alpha in ((before, 0.3), (points, 1.0)):
        for name, (colour, marker) in METHODS.items():
            own = [p for p in runs if p.series == name and not p.failure and error(p) is not None]
            errors = [max(error(p) or 0.0, LEAST) for p in own]
            at = [max(getattr(p, work), LEAST) for p in own], errors
            values = [f"{p.value:g}" for p in own]
            look = {"color": colour, "alpha": alpha}
            value = hv.Dimension(swept, label=f"{swept} ({LIMITS[swept].unit})")
            marks = hv.Points((*at, values), [kdim, vdim], value)
            labels = hv.Labels((*at, [f"   {each}" if alpha == 1.0 else "" for each in values]), [kdim, vdim], "beside")
            parts += [
                hv.Curve(at, kdim, vdim, label=name if alpha == 1.0 else "").opts(**look),
                marks.opts(size=9, marker=marker, tools=["hover"], **look),
                labels.opts(text_color=colour, text_font_size="9pt", xoffset=0.0, text_align="left"),
            ]
    return _live(parts, logx=True, logy=True, padding=0.15)


def curves(drawn: Mapping[str, tuple[Sequence[float], Sequence[float]]], x: str, y: str) -> hv.Overlay:
    """Curves {label: (x, y)} with a legend; x, y: labels of the axes."""
    import holoviews as hv

    _ready()
    kdim, vdim = hv.Dimension("x", label=x), hv.Dimension("y", label=y)
    parts = [
        hv.Curve(drawn.get(label, ([], [])), kdim, vdim, label=label).opts(
            tools=["hover"], line_dash=dash, color=colour
        )
        for label, dash, colour in zip(drawn or [""], cycle(DASHES), cycle(COLOURS))
    ]
    return _live(parts)


def mean_curve(exact: Any, runs: Mapping[float, float], own: float, critical: float) -> hv.Overlay:
    """Mean friction over w tau_max over E/tau_max: in closed form, as (ratios, means), and of runs.

    own: E/tau_max of a scene; critical: from which on sliding is smooth; both inf without friction.
    """
    import holoviews as hv

    _ready()
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


def friction_map(
    exact: Any, scene: Scene, slopes: tuple[float, float], moduli: tuple[float, float], strengths: tuple[float, float]
) -> hv.Overlay:
    """Mean friction over w tau_max over log10 of E (GPa) and of phi_t (N/m); exact: (ratios, means) of the layer.

    slopes: tau_max and the critical modulus over phi_t, GPa m/N; moduli, strengths: ends of the axes.
    The line is the critical modulus: stick-slip to its left, continuous sliding to its right.
    """
    import holoviews as hv

    _ready()
    E, phi_t = np.geomspace(*moduli, ROWS), np.geomspace(*strengths, ROWS)
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


def area_curves(runs: Mapping[float, Mapping[str, Any]], law_of: Callable[[Any], Any]) -> hv.Overlay:
    """A_bar over F_bar of runs {delta_bar: {"F", "A", "F_s", "A_s"}}, the law of each, and the onsets."""
    import holoviews as hv

    _ready()
    kdim, vdim = hv.Dimension("F", label="F̄ (10⁻³)"), hv.Dimension("A", label="Ā (10⁻³)")
    laws = {depth: law_of(run) for depth, run in runs.items()}
    measured = _joined([(1e3 * run["F"], 1e3 * run["A"]) for run in runs.values()])
    fits = _joined(
        [
            (1e3 * run["F"], 1e3 * np.maximum(law.A_0 - law.zeta * run["F"] ** 2, 0.0))
            for law, run in zip(laws.values(), runs.values(), strict=True)
            if law
        ]
    )
    onsets = [(1e3 * run["F_s"], 1e3 * run["A_s"], depth) for depth, run in runs.items() if run["F_s"]]
    parts = [
        hv.Curve(measured, kdim, vdim, label="runs").opts(color=COLOURS[0]),
        hv.Curve(fits, kdim, vdim, label="Ā₀ − ζF̄² (Eq. 8)").opts(color=COLOURS[1], line_dash="dashed"),
        hv.Points(onsets, [kdim, vdim], "delta_bar", label="onset").opts(color="gray", size=8, tools=["hover"]),
    ]
    return _live(parts)


def thresholds(
    onsets: Mapping[str, Sequence[tuple[float, float, float]]], line_of: Callable[[Any], Any], beyond: float
) -> hv.Overlay:
    """A_bar over F_bar at the onsets {series: [(F_s, A_s, delta_bar)]}, and the threshold law of each series.

    Onsets from delta_bar = beyond on are crosses: they are not part of the law.
    """
    import holoviews as hv

    _ready()
    kdims, parts = [hv.Dimension("F", label="F̄ (10⁻³)"), hv.Dimension("A", label="Ā (10⁻³)")], []
    for (name, rows), marker, colour in zip((onsets or {"": []}).items(), cycle(MARKERS), cycle(COLOURS)):
        law, top = line_of(rows), max((A for _, A, _ in rows), default=0.0)
        line = [(1e3 * (law.F_nc + law.tau_c * A), 1e3 * A) for A in (0.0, top)] if law else []
        inside, outside = (
            [(1e3 * F, 1e3 * A, depth) for F, A, depth in rows if (depth >= beyond) is late] for late in (False, True)
        )
        look = {"color": colour, "size": 9, "tools": ["hover"]}
        parts += [
            hv.Curve(line, *kdims).opts(color=colour),
            hv.Points(inside, kdims, "delta_bar", label=name).opts(marker=marker, **look),
            hv.Points(outside, kdims, "delta_bar").opts(marker="x", **look),
        ]
    return _live(parts)


def measured_curves(measured: Any, curve: Any, found: Any, scene: Scene) -> hv.Overlay:
    """F and L over U_x: a Measurement, the curve (U_x nm, F N/m, L N/m) of a scene, and a Fit; each may be None."""
    import holoviews as hv

    _ready()
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


def residuals(measured: Any, curve: Any, found: Any, scene: Scene) -> hv.Overlay:
    """Fitted less measured F over its noise, over U_x; arguments as of `measured_curves`."""
    import holoviews as hv

    _ready()
    kdim, vdim = hv.Dimension("U_x", unit="nm"), hv.Dimension("difference", label="fitted − measured (noise)")
    rows = [(U_x, model - seen) for U_x, quantity, seen, model in (found.rows if found else ()) if quantity == "F_bar"]
    noise = measured.noise["F_bar"] if measured else 1.0
    points = hv.Scatter([(U_x, off / noise) for U_x, off in rows], kdim, vdim).opts(color=COLOURS[1], size=4)
    return _live([points, hv.HLine(0.0).opts(color="gray", line_width=1)])


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


def _ready():
    """Loads Bokeh unless the caller has chosen a backend."""
    import holoviews as hv

    if not hv.Store.loaded_backends():
        hv.extension("bokeh", inline=True, logo=False)  # with its scripts in the notebook: no internet is needed


def _sized(layout):
    """The plots below each other, in a size that fits a page."""
    import holoviews as hv

    layout = layout.opts(shared_axes=False).cols(1)
    kinds = hv.opts.Curve, hv.opts.QuadMesh, hv.opts.Scatter, hv.opts.HeatMap, hv.opts.Points
    for backend in set(hv.Store.loaded_backends()) & set(SIZES):
        layout.opts(*(kind(**SIZES[backend], backend=backend) for kind in kinds))
        overlays = hv.opts.Overlay, hv.opts.NdOverlay
        layout.opts(*(kind(legend_position="right", backend=backend) for kind in overlays))
    if "matplotlib" in hv.Store.loaded_backends():
        layout.opts(hv.opts.Layout(sublabel_format="", fig_inches=6, vspace=0.4, backend="matplotlib"))
    return layout


def refusal(file: str | PathLike) -> str | None:
    """Why a plot cannot be written to a file of this name, and what to do; None if it can."""
    suffix = Path(file).suffix
    if suffix not in BACKENDS:
        return f"file = {str(file)!r}; allowed: a name that ends in {', '.join(BACKENDS)}; rename it"
    if BACKENDS[suffix] == "matplotlib" and find_spec("matplotlib") is None:
        return f"{suffix} needs matplotlib: pip install mixed-mode-contact[plots], or write .html"
    return None


def save(
    file: str | PathLike, draw: Callable[..., Any], *content: Any, title: str = "", notes: Iterable[str] = ()
) -> None:
    """Writes the plot draw(*content) as HTML that opens without internet, or as PNG or SVG (needs matplotlib).

    draw is called once the backend is chosen. title: above the plot, with the version; notes: sentences below it.
    Raises ValueError for another suffix, ImportError without matplotlib.
    """
    import holoviews as hv

    from . import __version__

    suffix, why = Path(file).suffix, refusal(file)
    if why:
        raise ImportError(why) if suffix in BACKENDS else ValueError(why)
    hv.extension(BACKENDS[suffix], logo=False)
    plot, text = draw(*content), ", ".join([*([title] if title else []), f"mixed-mode-contact {__version__}"])
    if BACKENDS[suffix] == "matplotlib":
        figure = hv.render(plot, backend="matplotlib")
        figure.suptitle("\n".join(wrap(text, LINE)), y=0.99, va="bottom", fontsize="medium")
        figure.savefig(file, bbox_inches="tight", metadata={"Title": text})
        return
    from bokeh.embed import file_html
    from bokeh.resources import INLINE

    page = file_html(hv.render(plot, backend="bokeh"), INLINE, text)
    lines = "".join(f"<p>{escape(line)}</p>" for line in [text, *notes])
    Path(file).write_text(page.replace("<body>", f"<body>{lines}", 1), encoding="utf-8")
