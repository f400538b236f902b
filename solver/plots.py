"""Plots of results with HoloViews, for notebooks and for files that open without internet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from .run.frame import Frame
from .run.load_steps import abscissa, place
from .run.summary import fields_of
from .scene import LIMITS, Scene

if TYPE_CHECKING:
    import holoviews as hv
    import pandas as pd

BACKENDS = {".html": "bokeh", ".png": "matplotlib", ".svg": "matplotlib"}
# Below each other: as wide as a column of text, three on one screen
SIZES = {"bokeh": {"width": 700, "height": 240}, "matplotlib": {"aspect": 3}}
UNITS = {"U_s": "nm", "F_s": "N/m", "A_s": "nm", "A_0": "nm", "L_min": "N/m", "L_off": "N/m"}


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


def first_slips(table: pd.DataFrame, x: str, y: str, of: str) -> hv.Layout:
    """A column of a map over its two parameters, and the regimes; points without a value are blank."""
    import holoviews as hv
    import pandas as pd

    _ready()
    kdims = [hv.Dimension(name, unit=LIMITS[name].unit or None) for name in (x, y)]
    table = table.sort_values([y, x])
    # of one size on any axis
    cells = pd.DataFrame({name: [f"{value:.4g}" for value in table[name]] for name in (x, y)})
    cells[of] = [float(value) if value != "" else np.nan for value in table[of]]
    cells["regime"] = list(table["regime"])
    numbers = hv.HeatMap(cells, kdims, hv.Dimension(of, unit=UNITS.get(of)))
    regimes = {name: hv.Points(part, kdims, []) for name, part in cells.groupby("regime", sort=False)}
    return _sized(numbers.opts(hv.opts.HeatMap(colorbar=True)) + hv.NdOverlay(regimes, kdims="regime"))


def _ready():
    """Loads Bokeh unless the caller has chosen a backend."""
    import holoviews as hv

    if not hv.Store.loaded_backends():
        hv.extension("bokeh", inline=True, logo=False)  # with its scripts in the notebook: no internet is needed


@contextmanager
def drawn_with(backend: str) -> Iterator[None]:
    """Within, HoloViews draws with this backend; afterwards with the one that the caller has chosen."""
    import holoviews as hv

    _ready()
    chosen = hv.Store.current_backend
    if backend == chosen:  # to set it again takes a fifth of the time of a plot
        yield
        return
    if backend in hv.Store.loaded_backends():
        hv.Store.set_current_backend(backend)
    else:
        hv.extension(backend, logo=False)
    try:
        yield
    finally:
        hv.Store.set_current_backend(chosen)


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


def save(file: str | PathLike, draw: Callable[[], Any], title: str, notes: Iterable[str]) -> None:
    """Writes the plot draw() as HTML that opens without internet, or as PNG or SVG (needs matplotlib).

    draw is called once the backend is chosen. title: above the plot, with the version; notes: sentences below it.
    Raises ValueError for another suffix, ImportError without matplotlib.
    """
    import holoviews as hv

    from . import __version__

    suffix = Path(file).suffix
    if suffix not in BACKENDS:
        raise ValueError(f"file = {str(file)!r}; allowed: a name that ends in {', '.join(BACKENDS)}; rename it")
    if BACKENDS[suffix] == "matplotlib" and find_spec("matplotlib") is None:
        raise ImportError(f"{suffix} needs matplotlib: pip install mixed-mode-contact[plots], or write .html")
    text = f"{title}, mixed-mode-contact {__version__}"
    with drawn_with(BACKENDS[suffix]):
        drawn = hv.render(draw(), backend=BACKENDS[suffix])
    if BACKENDS[suffix] == "matplotlib":
        drawn.suptitle("\n".join(wrap(text, 90)), y=0.99, va="bottom", fontsize="medium")
        drawn.savefig(file, bbox_inches="tight", metadata={"Title": text})
        return
    from bokeh.embed import file_html
    from bokeh.resources import INLINE

    lines = "".join(f"<p>{escape(line)}</p>" for line in [text, *notes])
    page = file_html(drawn, INLINE, text).replace("<body>", f"<body>{lines}", 1)
    Path(file).write_text(page, encoding="utf-8")
