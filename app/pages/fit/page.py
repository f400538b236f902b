"""The page "Fit": a measured friction curve over that of the sliders, and the parameters that make it.

A file is read and fitted by a worker (`solver.analysis.measurement`, `fit`); the curve of the sliders is filled in by
the browser (page.js), so that a hand can try before the machine does.
"""

import re
from random import randrange

import numpy as np

from app.pages import Sheet
from app.service import tasks
from app.service.pool import HEAVY, LATER
from app.views.plots import Quantity, curve, dots, level, rendered

TITLE, ORDER, FIGURES = "Fit", 7, ("curve", "residuals")
FREE = {  # what can be free: what the page calls it, its unit, whether it is free at first
    "phi_n": ("adhesion φₙ", "N/m", False),  # which F and L hardly tell from the next
    "phi_ratio": ("friction / adhesion φₜ/φₙ", "", True),
    "delta_bar": ("press depth δ/δ₀", "", True),
    "E": ("stiffness E", "GPa", False),
    "offset_U": ("zero of Uₓ", "nm", False),
    "scale_F": ("scale of F", "", False),
    "offset_F": ("zero of F", "", False),
}
TEMPLATE = {"fit_free": FREE}
COLOURS = {"run": "--shear", "run_load": "--text"}
COLOURS |= dict.fromkeys(("measured", "load"), "--free") | dict.fromkeys(("fitted", "fitted_load"), "--cut")
PARTS = {"F_bar": ("measured", "fitted"), "L_bar": ("load", "fitted_load")}  # of the figure, for each quantity
LONG = 120.0  # s that a fit may take
SEEDS = 2**32  # of made-up measurements, each another one
LOST = "it could not be computed; try again"
ROOM = 0.08  # of a curve, above and below it
PLACE, FORCE = Quantity("U_x", "displacement of the top Uₓ", "nm"), Quantity("F", "F", "N/m")
OFF = Quantity("off", "difference", "noise")


def compose():
    """Measured and computed forces, and by how much they differ after a fit."""
    curves = [
        dots("measured", PLACE, FORCE, size=4),
        dots("load", PLACE, FORCE, size=4),
        curve("run", PLACE, FORCE, line_width=2),
        curve("run_load", PLACE, FORCE, line_width=2, line_dash="dashed"),
        curve("fitted", PLACE, FORCE, line_width=3),
        curve("fitted_load", PLACE, FORCE, line_width=3),
    ]
    off = [level("zero"), curve("line", PLACE, OFF, line_width=1), dots("residuals", PLACE, OFF, size=4)]
    return [
        rendered("fit_curve", curves, COLOURS),
        rendered("fit_residuals", off, {"zero": "--grid", "line": "--grid", "residuals": "--cut"}, y=(-5.0, 5.0)),
    ]


class Page(Sheet):
    """See pages.py."""

    measured = None  # Measurement

    def order(self, values):
        """A file, a made-up measurement, a fit, or cancel."""
        what, scene = values.get("what"), self.session.scene
        if what == "file":
            self.wanted.ask((tasks.measured_curve, values["text"], scene), self._read, rank=LATER)
        elif what == "example":
            self.wanted.ask((tasks.made_up_curve, scene, randrange(SEEDS)), self._read, rank=HEAVY, seconds=LONG)
        elif what == "fit" and self.measured is not None:
            free = tuple(name for name in FREE if name in values.get("free", "").split(","))
            if not free:
                return self.publish(texts={"fit-said": "Choose what may be changed to fit."})
            self.wanted.ask((tasks.fitted, scene, self.measured, free), self._fitted, rank=HEAVY, seconds=LONG)
            self.publish(busy=0.0, texts={"fit-said": "Fitting: runs are followed to where they meet the points …"})
        elif what == "cancel":
            self.close()
            self.publish(busy=None, texts={"fit-said": "Cancelled."})

    def _read(self, result):
        measured, why = result or (None, LOST)
        if measured is None:
            return self.publish(texts={"fit-said": f"measurement: {why}. What was there stays."})
        self.measured = measured
        forces = {name: measured.values[name] * self._unit for name in PARTS if name in measured.values}
        every = np.concatenate([*forces.values()])
        room = ROOM * (float(np.ptp(every)) or 1.0)
        along = {"start": min(0.0, float(measured.U_x[0])), "end": float(measured.U_x[-1])}
        for view in self.views.values():
            view.figure.x_range.update(**along)
        self.views["curve"].figure.y_range.update(start=float(every.min()) - room, end=float(every.max()) + room)
        for name, (points, line) in PARTS.items():
            there = name in forces
            self.draw("curve", points, U_x=measured.U_x if there else [], F=forces.get(name, []))
            self.draw("curve", line, U_x=[], F=[])
        self.draw("residuals", "residuals", U_x=[], off=[])
        count, noise = measured.U_x.size, measured.noise["F_bar"] * self._unit
        text = f"{count} points, {len(measured.slips)} slips, noise {noise:.2g} N/m. {' '.join(measured.notes)}".strip()
        self.publish(texts={"fit-said": f"{text} Move the sliders until the curves meet, or let it fit."}, fit=None)

    @property
    def _unit(self):
        """N/m that F_bar of the measurement is times."""
        scene = self.session.scene
        return self.measured.unit or scene.width * scene.E

    def _fitted(self, found):
        if found is None or isinstance(found, str):
            return self.publish(busy=None, texts={"fit-said": f"Nothing was found: {found or LOST}."})
        of = {name: np.array([(at, a, b) for at, which, a, b in found.rows if which == name]) for name in PARTS}
        for name, (_, line) in PARTS.items():
            if of[name].size:
                self.draw("curve", line, U_x=of[name][:, 0], F=of[name][:, 2] * self._unit)
        rows = of["F_bar"]
        off = (rows[:, 2] - rows[:, 1]) / self.measured.noise["F_bar"]
        self.draw("residuals", "residuals", U_x=rows[:, 0], off=off)
        end = max(5.0, 1.1 * float(np.abs(off).max()))
        self.views["residuals"].figure.y_range.update(start=-end, end=end)
        said = f"χ² per point {found.chi2:.3g}, {found.runs} runs followed." + "".join(map(in_words, found.warnings))
        told = {
            "values": {name: float(f"{value:.5g}") for name, value in found.values.items()},
            "errors": {name: float(f"{error:.2g}") for name, error in found.errors.items()},
            "correlations": np.round(found.correlations, 2).tolist(),
        }
        self.publish(busy=None, texts={"fit-said": said}, fit=told)


def in_words(sentence):
    """A warning in the page's words."""
    for name, (what, *_) in FREE.items():
        sentence = re.sub(rf"\b{name}\b", what, sentence)
    sentence = sentence.replace("+-", "±").replace(" -", " −")
    return f" {sentence[0].upper()}{sentence[1:]}."
