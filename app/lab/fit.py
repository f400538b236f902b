"""The page "Fit": a measured friction curve, that of the sliders, and the parameters that fit.

from app.lab.fit import view; view(Scene(E=140))
"""

import io
from functools import partial
from math import inf
from random import randrange
from typing import Any

import holoviews as hv
import numpy as np
import pandas as pd
import panel as pn
import param

from app.lab.base import WIDE, LabPage
from app.service import tasks
from app.service.jobs import jobs
from app.service.pool import HEAVY
from app.session.orders import LARGEST
from solver import Scene
from solver.analysis.measurement import Measurement
from solver.live_plots import measured_curves, residuals
from solver.text import counted

TITLE = "Fit"
FREE = {  # label: parameter that can be free
    "adhesion φₙ (N/m)": "phi_n",
    "friction / adhesion φₜ/φₙ": "phi_ratio",
    "press depth δ/δ₀": "delta_bar",
    "stiffness E (GPa)": "E",
    "drive kₜ (MPa/nm)": "drive_t",
    "zero of Uₓ (nm)": "offset_U",
    "scale of F": "scale_F",
    "zero of F": "offset_F",
}
LONG = 120.0  # s, time limit of a fit
SEEDS = 2**32  # number of seeds of example data
HOW = {"rank": HEAVY, "seconds": LONG, "private": True, "streams": True}
NARROW = {"sizing_mode": "stretch_width", "stylesheets": [".bk-input-group { flex-wrap: wrap }"]}  # in lines
NEUTRAL = {"offset_U": 0.0, "scale_F": 1.0, "offset_F": 0.0}  # true values that example data do not change


class Fit(LabPage):
    """A measurement, the curve of the scene, and the last fit."""

    TITLE = TITLE
    STATEMENT = (
        "Choose a measured curve: a CSV of up to 2 MB with columns U_x (nm) and F (N/m) or F_bar; L or L_bar and A_bar"
        " if measured. Or generate example data: an interface slightly different from this one, with noise. Move the"
        " sliders until the curves meet, then fit."
    )
    curve = param.Parameter(doc="(U_x nm, F N/m, L N/m) of the scene")
    measured = param.Parameter(doc="the Measurement, or None")
    found = param.Parameter(doc="its Fit, or None")
    truth = param.Dict({}, doc="{parameter: value} of example data")
    free = param.ListSelector(["phi_ratio", "delta_bar"], objects=FREE, label="Free parameters")

    async def compute(self) -> None:
        frames = await jobs.result(tasks.flat_frames, self.scene.changed(path="shear"), owner=id(self))
        rows = [(frame.U_x, frame.F, frame.L) for frame in frames if frame.stage == "shear"]
        self.curve = np.array(rows).T

    async def read(self, content: bytes) -> None:
        """Read the content of a file, bytes."""
        if len(content) > LARGEST:
            raise ValueError(f"the file has {len(content)} bytes; allowed: {LARGEST}; thin it out")
        text = content.decode("utf-8", "replace")
        made = await jobs.result(tasks.measured_curve, text, self.scene, owner=id(self), private=True)
        self.take(made, {})

    async def example(self) -> None:
        """Generate example data."""
        call = tasks.made_up_curve, self.scene, randrange(SEEDS)
        made = tasks.made_up_scene(*call[1:])
        truth = {name: getattr(made, name, NEUTRAL.get(name)) for name in FREE.values()}
        made = await jobs.result(*call, owner=id(self), private=True, rank=HEAVY, seconds=LONG)
        self.take(made, truth)

    def given(self, event: Any) -> None:
        """Read a chosen file."""
        if event.new is not None:
            self.start(partial(self.read, event.new))

    def take(self, made: tuple[Measurement | None, str | None], truth: dict[str, Any]) -> None:
        """Take (Measurement, None), or (None, why there is none); then the one before stays."""
        measured, why = made
        if measured is None:
            raise ValueError(f"Not read: {why}. {'The previous measurement stays' * bool(self.measured)}")
        self.param.update(measured=measured, found=None, truth=truth)
        points, slips = counted(measured.U_x.size, "point"), counted(len(measured.slips), "slip")
        noise = measured.noise["F_bar"] * (measured.unit or self.scene.width * self.scene.E)
        self.text = f"{points}, {slips} recognised, noise {noise:.2g} N/m. {' '.join(measured.notes)}"

    async def fit(self) -> None:
        """Fit the free parameters."""
        if self.measured is None:
            raise ValueError("There is no measurement. Choose a file, or generate example data")
        if not self.free:
            raise ValueError("No parameter is free. Tick at least one")
        if "drive_t" in self.free and self.scene.drive_t == inf:
            raise ValueError("The drive is rigid. Give drive_t a number in the experiment, under Parameters")
        found = await jobs.result(tasks.fitted, self.scene, self.measured, tuple(self.free), owner=id(self), **HOW)
        if isinstance(found, str):
            raise ValueError(f"No fit: {found}")
        self.found = found
        warnings = "".join(f" {line[0].upper()}{line[1:]}." for line in found.warnings)
        self.text = f"χ² per point {found.chi2:.3g}, from {counted(found.runs, 'predicted run')}.{warnings}"

    def apply(self, event: Any) -> None:
        """Give the sliders the fitted values."""
        if self.found:
            values = {name: float(f"{value:.5g}") for name, value in self.found.values.items() if name not in NEUTRAL}
            self.show(self.scene.changed(**values))

    def table(self, found: Any) -> pd.DataFrame:
        """Return fitted values, standard errors, true values of example data, and correlations."""
        if not found:
            return pd.DataFrame()
        names = [label for label, name in FREE.items() if name in found.values]
        rows = [[f"{found.values[FREE[n]]:.5g}", f"{found.errors[FREE[n]]:.2g}"] for n in names]
        table = pd.DataFrame(rows, index=pd.Index(names, name="parameter"), columns=["fitted", "± standard error"])
        if self.truth:
            table["made with"] = [f"{self.truth[FREE[n]]:.5g}" for n in names]
        table["correlations"] = [" ".join(f"{c:.2f}" for c in found.correlations[i][:i]) for i in range(len(names))]
        return table.reset_index()

    def content(self) -> list[Any]:
        given = self.param.measured, self.param.curve, self.param.found, self.param.scene
        plots = [hv.DynamicMap(pn.bind(draw, *given)) for draw in (measured_curves, residuals)]
        file = pn.widgets.FileInput(accept=".csv,.txt,.dat")
        file.param.watch(self.given, "value")
        table = pn.bind(self.table, self.param.found)
        there = self.param.found.rx.is_not(None)
        save = pn.widgets.FileDownload(visible=there, callback=self.csv, filename="fit.csv", label="Download the table")
        return [
            pn.FlexBox(
                file,
                pn.widgets.Button(label="Generate example data", on_click=lambda event: self.start(self.example)),
                pn.widgets.CheckBoxGroup.from_param(self.param.free, inline=True, **NARROW),
                pn.widgets.Button(label="Fit", on_click=lambda event: self.start(self.fit)),
                pn.widgets.Button(label="Apply to sliders", on_click=self.apply),
            ),
            pn.FlexBox(*(pn.pane.HoloViews(plot, styles=WIDE) for plot in plots)),
            pn.widgets.Tabulator(table, disabled=True, show_index=False, visible=there),
            save,
        ]

    def csv(self) -> io.StringIO:
        """Return the table as a file."""
        return io.StringIO(self.table(self.found).to_csv(index=False))


def view(scene: Scene | None = None) -> pn.viewable.Viewable:
    """Return the page for a Scene (default: the default Scene)."""
    return Fit(scene).view()
