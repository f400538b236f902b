"""The page "Fit": a measured friction curve, that of the sliders, and the parameters that fit.

from app.features.fit.research import view; view(Scene(E=140))
"""

import io
from functools import partial
from math import inf
from random import randrange
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
import param

from app import interface
from app.document import on_loop
from app.features.fit import tasks
from app.features.fit.feature import TITLE
from app.features.lab.base import LabPage, side_by_side
from app.features.lab.tasks import flat_frames
from app.service.job import HEAVY
from app.session.orders import LARGEST
from solver import fit
from solver.live_plots import BLUE, DASHES, ORANGE, Curve
from solver.measured.measurement import Measurement, Recording
from solver.text import counted

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
NEUTRAL = {"offset_U": 0.0, "scale_F": 1.0, "offset_F": 0.0}  # of example data
SEEDS = 2**32  # number of seeds of example data
MOST = 2000  # measured points that are drawn: a file may have 100,000
LONG = {"rank": HEAVY, "seconds": 120.0, "private": True, "streams": True}  # of a fit
NARROW = {"sizing_mode": "stretch_width", "stylesheets": [".bk-input-group { flex-wrap: wrap }"]}  # in lines


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
    fitted = param.Parameter(doc="its Fit, or None")
    truth = param.Dict({}, doc="{parameter: value} of example data")
    free = param.ListSelector(["phi_ratio", "delta_bar"], objects=FREE, label="Free parameters")

    def __init__(self, scene=None):
        super().__init__(scene)
        self.key = pn.state.session_args.get("curve", [b""])[-1].decode("ascii", "replace")

    async def compute(self) -> None:
        frames = await self.call(flat_frames, self.scene.changed(path="shear"))
        self.curve = np.array([(frame.U_x, frame.F, frame.L) for frame in frames if frame.stage == "shear"]).T
        key, self.key = self.key, ""
        if key:  # it lies over the run of the experiment, which named it in the address
            if (given := laid_over(key)) is None:
                raise ValueError("This server does not have the measured curve of this address. Choose the file again")
            content, how = given
            await self.read(content, **how)

    async def read(self, content: bytes, **how: Any) -> None:
        """Read the content of a file; how: arguments of `read_measurement`.

        If it is not usable, the previous measurement stays.
        """
        if len(content) > LARGEST and not how:
            raise ValueError(f"the file has {len(content)} bytes; allowed: {LARGEST}; thin it out")
        measured = await self.call(partial(tasks.measured, **how), self.scene, content, private=True)
        if isinstance(measured, Recording):
            loop = "this is a loop; the page takes one stroke; in Python, fit takes all of it"
            raise ValueError(measured.unfit or loop)
        self.take(measured, {})

    async def example(self) -> None:
        """Generate example data."""
        seed = randrange(SEEDS)
        made = tasks.made_up_scene(self.scene, seed)
        truth = {name: getattr(made, name, NEUTRAL.get(name)) for name in FREE.values()}
        self.take(await self.call(tasks.made_up_curve, made, seed, **LONG), truth)

    def take(self, measured: Measurement, truth: dict[str, Any]) -> None:
        """Show a measurement in place of the previous one."""
        self.param.update(measured=measured, fitted=None, truth=truth)
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
        found = self.fitted = await self.call(fit, self.scene, self.measured, tuple(self.free), **LONG)
        warnings = "".join(f" {line[0].upper()}{line[1:]}." for line in found.warnings)
        self.text = f"χ² per point {found.chi2:.3g}, from {counted(found.runs, 'predicted run')}.{warnings}"

    def apply(self, event: Any) -> None:
        """Give the sliders the fitted values."""
        if self.fitted:
            values = {name: float(f"{value:.5g}") for name, value in self.fitted.values.items() if name not in NEUTRAL}
            self.show(self.scene.changed(**values))

    def rows(self) -> pd.DataFrame:
        """Return fitted values, standard errors, true values of example data, and correlations."""
        rows, labels, found = [], {name: label for label, name in FREE.items()}, self.fitted
        for i, (name, value) in enumerate(found.values.items() if found else ()):
            row = {"parameter": labels[name], "fitted": f"{value:.5g}", "± standard error": f"{found.errors[name]:.2g}"}
            row |= {"made with": f"{self.truth[name]:.5g}"} if self.truth else {}
            rows.append(row | {"correlations": " ".join(f"{c:.2f}" for c in found.correlations[i][:i])})
        return pd.DataFrame(rows)

    def curves(self) -> list[Curve]:
        """Return F and L over U_x: measured, of the sliders, and fitted."""
        unit = getattr(self.measured, "unit", None) or self.scene.width * self.scene.E
        values, drawn = getattr(self.measured, "values", {}), []
        of_sliders = self.curve if self.curve is not None else np.empty((3, 0))
        for name, force, colour, dash in zip("FL", of_sliders[1:], (BLUE, "gray"), DASHES, strict=False):
            seen = values.get(f"{name}_bar", np.empty(0)) * unit
            at, every = self.measured.U_x if seen.size else [], 1 + seen.size // MOST
            U_x, _, model = self.fit_of(f"{name}_bar")
            drawn += [
                Curve(f"{name} measured", at[::every], seen[::every], colour, marker="circle", size=3.0, alpha=0.5),
                Curve(f"{name} of the sliders", of_sliders[0], force, colour, dash),
                Curve(f"{name} fitted", U_x, model * unit, ORANGE, dash, size=3.0),
            ]
        return drawn

    def residuals(self) -> list[Curve]:
        """Return fitted less measured F over its noise, over U_x."""
        U_x, seen, model = self.fit_of("F_bar")
        noise = self.measured.noise["F_bar"] if self.measured else 1.0
        zero = Curve("", U_x[[0, -1]], np.zeros(2), "gray", size=1.0) if U_x.size else Curve("", [], [])
        return [zero, Curve("", U_x, (model - seen) / noise, ORANGE, marker="circle", size=4.0)]

    def fit_of(self, quantity: str) -> np.ndarray:
        """Return U_x, measured and fitted values of a quantity, (3, k); k = 0 without a fit."""
        rows = [row for row in (self.fitted.rows if self.fitted else ()) if row[1] == quantity]
        return np.array([(U_x, seen, model) for U_x, _, seen, model in rows]).reshape(-1, 3).T

    def content(self) -> list[Any]:
        file = pn.widgets.FileInput(accept=".csv,.txt,.dat")
        file.param.watch(lambda event: self.start(partial(self.read, event.new or b"")), "value")
        generate = on_loop(lambda event: self.start(self.example))
        example = pn.widgets.Button(label="Generate example data", on_click=generate)
        curves = self.chart(self.curves, "U_x (nm)", "force (N/m)", title="Friction over displacement")
        residuals = self.chart(self.residuals, "U_x (nm)", "fitted − measured F (noise)", title="Residuals")
        return [
            side_by_side(file, example),
            pn.widgets.CheckBoxGroup.from_param(self.param.free, inline=True, **NARROW),
            side_by_side(
                pn.widgets.Button(label="Fit", on_click=on_loop(lambda event: self.start(self.fit))),
                pn.widgets.Button(label="Apply to sliders", on_click=on_loop(self.apply)),
            ),
            side_by_side(curves, residuals),
            self.table(self.rows),
            pn.widgets.FileDownload(
                callback=lambda: io.StringIO(self.rows().to_csv(index=False)),
                visible=self.param.fitted.rx.is_not(None),
                filename="fit.csv",
                label="Download the table",
            ),
        ]


def laid_over(key: str) -> Any:
    """Return (content, arguments that read it) of the curve that a visitor has drawn over the run, or None.

    The feature `files` keeps it, if it is there.
    """
    keeps: Any = interface.classes().get("files")  # which may be left out
    return keeps.kept(key) if keeps else None


view = Fit.view
