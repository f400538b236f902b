"""The page "Fit": a measured friction curve, the curve of the sliders, and the fitted parameters.

A worker reads and fits a file (`solver.analysis.measurement`, `fit`). The browser draws the curve of the sliders
(page.js), so that a visitor can first fit by hand.
"""

import re
from math import inf
from random import randrange
from typing import Any

import numpy as np
from bokeh.models import DataRange1d
from bokeh.models.glyphs import Line, Scatter

from app.pages import Sheet
from app.pages.notebook import laid_out, page_of
from app.service import tasks
from app.service.pool import HEAVY
from app.views.plots import add_zero, blank, draw
from solver import Scene, load_path
from solver.text import counted

TITLE, ORDER, FIGURES = "Fit", 7, ("curve", "residuals")
FREE = {  # parameters that can be free: label, unit, whether it is free at first
    "phi_n": ("adhesion φₙ", "N/m", False),  # F and L hardly distinguish it from the next
    "phi_ratio": ("friction / adhesion φₜ/φₙ", "", True),
    "delta_bar": ("press depth δ/δ₀", "", True),
    "E": ("stiffness E", "GPa", False),
    "drive_t": ("drive kₜ", "MPa/nm", False),
    "offset_U": ("zero of Uₓ", "nm", False),
    "scale_F": ("scale of F", "", False),
    "offset_F": ("zero of F", "", False),
}
PARTS = {"F_bar": ("measured", "fitted"), "L_bar": ("load", "fitted_load")}  # parts of the figure, per quantity
LONG = 120.0  # s, time limit of a fit
HOW = {"rank": HEAVY, "seconds": LONG, "private": True}
SEEDS = 2**32  # number of seeds of example data
LOST = f"the server could not compute it within {LONG:g} s. Free fewer parameters, start nearer, or thin out the data"
NEUTRAL = {"offset_U": 0.0, "scale_F": 1.0, "offset_F": 0.0}  # true values that example data do not change
MARGIN = 0.08  # margin above and below a curve, over its height
PLACE = "displacement Uₓ (nm)"


def compose() -> list[Any]:
    """Return the figures: measured and computed forces, and their differences after a fit."""
    curves = blank("fit_curve", PLACE, "F (N/m)")
    for name in ("measured", "load"):
        draw(curves, Scatter, name, "--free", "U_x", "F", size=4)
    draw(curves, Line, "run", "--shear", "U_x", "F", line_width=2)
    draw(curves, Line, "run_load", "--text", "U_x", "F", line_width=2, line_dash="dashed")
    for name in ("fitted", "fitted_load"):
        draw(curves, Line, name, "--cut", "U_x", "F", line_width=3)
    off = blank("fit_residuals", PLACE, "difference (noise)", y=(-5.0, 5.0))
    add_zero(off)
    draw(off, Line, "line", "--grid", "U_x", "off", line_width=1)
    draw(off, Scatter, "residuals", "--cut", "U_x", "off", size=4)
    return [curves, off]


def figure(scene: Scene, measured: Any = None) -> Any:
    """Return friction and load of a Scene, and of a Measurement if given, for a notebook."""
    page = page_of(compose, Page, scene)
    if measured is not None:
        page.take_measurement((measured, None))
    frames = [frame for frame in load_path(scene) if frame.stage == "shear"]
    U_x = [frame.U_x for frame in frames]
    page.draw("curve", "run", U_x=U_x, F=[frame.F for frame in frames])
    page.draw("curve", "run_load", U_x=U_x, F=[frame.L for frame in frames])
    curves = page.views["curve"].figure
    if measured is None:
        curves.update(x_range=DataRange1d(), y_range=DataRange1d())
    return laid_out(page)


class Page(Sheet):
    """The page of one visitor; see app/pages. It stays: a fit continues while the page is closed."""

    stays = True

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.measured, self.found = None, None  # Measurement, its Fit
        self.truth = {}  # {parameter: value} of example data
        self.answers = 0  # number of files and examples answered

    def scene_changed(self) -> None:
        """Draw forces again: F_bar in N/m depends on the stiffness and width on screen."""
        if self.measured is not None:
            self._draw_measured()
            self._draw_fitted()

    def order(self, values: dict[str, Any]) -> None:
        """Read a file, generate example data, start a fit, or cancel."""
        what, scene = values.get("what"), self.session.scene
        if "text" in values:
            self.publish(busy=None, texts={"fit-text": "Reading the file …"})
            self.single.ask((tasks.measured_curve, values["text"], scene), self.take_measurement, private=True)
        elif what == "example":
            call, seed = tasks.made_up_curve, randrange(SEEDS)
            made = tasks.made_up_scene(scene, seed)
            truth = {name: getattr(made, name, NEUTRAL.get(name)) for name in FREE}
            self.publish(busy=None, texts={"fit-text": "Generating example data …"})
            self.single.ask((call, scene, seed), lambda made: self.take_measurement(made, truth), **HOW)
        elif what == "fit" and self.measured is not None:
            free = tuple(name for name in FREE if name in values.get("free", "").split(","))
            if not free:
                return self.publish(texts={"fit-text": "No parameter is free. Tick at least one."})
            if "drive_t" in free and scene.drive_t == inf:
                return self.publish(texts={"fit-text": "The drive is rigid: give drive_t a number under Parameters."})
            text = f"Fitting, for up to {LONG:g} s. It continues while you look at other pages."
            self.publish(busy=0.0, texts={"fit-text": text})
            self.single.ask((tasks.fitted, scene, self.measured, free), self._fitted, **HOW)
        elif what == "cancel":
            self.close()
            self.publish(busy=None, texts={"fit-text": "Cancelled."})

    def take_measurement(self, result: Any, truth: dict[str, float] | None = None) -> None:
        """Take (Measurement, None) or (None, why there is none); truth: {parameter: value} of example data."""
        measured, why = result or (None, LOST)
        self.answers += 1
        if measured is None:
            there = "The previous measurement stays." if self.measured else "Choose another file."
            text = f"Not read: {why}. {there}"
            return self.publish(answers=self.answers, refused=True, texts={"fit-text": text})
        self.measured, self.found, self.truth = measured, None, truth or {}
        self._draw_measured()
        self._draw_fitted()
        along = {"start": min(0.0, float(measured.U_x[0])), "end": float(measured.U_x[-1])}
        for view in self.views.values():
            view.figure.x_range.update(**along)
        points, slips = counted(measured.U_x.size, "point"), counted(len(measured.slips), "slip")
        noise = measured.noise["F_bar"] * self._unit
        text = f"{points}, {slips} recognised, noise {noise:.2g} N/m. {' '.join(measured.notes)}".strip()
        text += " Move the sliders until the curves meet, or click Fit."
        news = {"answers": self.answers, "refused": False, "made": bool(truth), "fit": None}
        self.publish(texts={"fit-text": text}, **news)

    @property
    def _unit(self):
        """The unit of F_bar of the measurement, N/m."""
        scene = self.session.scene
        return self.measured.unit or scene.width * scene.E

    def _draw_measured(self):
        measured, unit = self.measured, self._unit
        forces = {name: measured.values[name] * unit for name in PARTS if name in measured.values}
        every = np.concatenate([*forces.values()])
        margin = MARGIN * (float(np.ptp(every)) or 1.0)
        self.views["curve"].figure.y_range.update(start=float(every.min()) - margin, end=float(every.max()) + margin)
        for name, (points, _) in PARTS.items():
            there = name in forces
            self.draw("curve", points, U_x=measured.U_x if there else [], F=forces.get(name, []))

    def _draw_fitted(self):
        rows = self.found.rows if self.found else ()
        of = {name: np.array([row[:1] + row[2:] for row in rows if row[1] == name]).reshape(-1, 3) for name in PARTS}
        for name, (_, line) in PARTS.items():
            self.draw("curve", line, U_x=of[name][:, 0], F=of[name][:, 2] * self._unit)
        off = (of["F_bar"][:, 2] - of["F_bar"][:, 1]) / self.measured.noise["F_bar"]
        self.draw("residuals", "residuals", U_x=of["F_bar"][:, 0], off=off)
        end = max(5.0, 1.1 * float(np.abs(off).max(initial=0.0)))
        self.views["residuals"].figure.y_range.update(start=-end, end=end)

    def _fitted(self, found):
        if found is None or isinstance(found, str):
            return self.publish(busy=None, texts={"fit-text": f"No fit: {found or LOST}."})
        self.found = found
        self._draw_fitted()
        runs = counted(found.runs, "predicted run")
        text = f"χ² per point {found.chi2:.3g}, from {runs}." + "".join(map(in_words, found.warnings))
        result = {
            "values": {name: float(f"{value:.5g}") for name, value in found.values.items()},
            "errors": {name: float(f"{error:.2g}") for name, error in found.errors.items()},
            "truth": {name: float(f"{value:.5g}") for name, value in self.truth.items() if name in found.values},
            "correlations": np.round(found.correlations, 2).tolist(),
        }
        self.publish(busy=None, texts={"fit-text": text}, fit=result)


def in_words(sentence: str) -> str:
    """Return a warning in the page's terms."""
    for name, (what, *_) in FREE.items():
        sentence = re.sub(rf"\b{name}\b", what, sentence)
    sentence = sentence.replace("+-", "±").replace(" -", " −")
    return f" {sentence[0].upper()}{sentence[1:]}."
