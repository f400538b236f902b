"""The page "Area laws" (paper Fig. 8, Eqs. 8, 9): runs up to the onset of sliding over a range of indentations.

from app.features.area_laws.research import view; view(Scene(phi_ratio=0.5))
"""

from typing import Any

import numpy as np
import pandas as pd
import panel as pn
import param

from app.features.area_laws import tasks
from app.features.area_laws.feature import TITLE
from app.features.lab.base import LabPage, side_by_side
from app.limits import INCREMENTS, increments_of
from solver import Scene, SceneError
from solver.analysis.area_laws import QuadraticLaw, ThresholdLaw, quadratic_law, threshold_law
from solver.analysis.friction_laws import INDENTATIONS, INTERFACES, Onset
from solver.live_plots import COLOURS, DASHES, ORANGE, Curve
from solver.presets import presets

BEYOND = 1.0  # delta_bar beyond those of Fig. 8, where the threshold line bends
DEPTHS = (*INDENTATIONS, BEYOND)
OWN = "this interface"
NAMED = "δ̄ = {:g}".format
MARKERS = "circle", "square", "triangle", "diamond"
Runs = dict[float, Onset]  # by delta_bar


def series_of(scene: Scene) -> Scene:
    """Return the scene that identifies a series: with a fixed indentation, path and length."""
    return scene.changed(delta_bar=0.0, u_x_max=Scene().u_x_max, path="shear", damping=1.0)


PAPER = [series_of(presets()[name].scene) for name in INTERFACES]
NAMES = [OWN, *(f"φₙ = {scene.phi_n:g}, φₜ/φₙ = {scene.phi_ratio:g}" for scene in PAPER)]


class AreaLaws(LabPage):
    """Contact area over friction of the interface on screen and of the three of the paper."""

    TITLE = TITLE
    STATEMENT = (
        "Paper: under shear the contact area shrinks as Ā = Ā₀ − ζF̄² (Eq. 8), and at the onset of sliding friction is"
        " F̄_s = τ_c Ā_s + F̄_s,nc (Eq. 9), with friction at no contact area. Each series is one interface at"
        f" {len(DEPTHS)} press depths; lines go through the onsets with contact up to δ̄ = 0.6, × is δ̄ = {BEYOND:g}."
    )
    shown = param.Selector(objects=NAMES, label="Series")

    async def compute(self) -> None:
        own = series_of(self.scene)
        if own.surface == "flat":
            raise SceneError("surface", "flat", "it has no edge that can peel", "choose another surface")
        if increments_of(own) > INCREMENTS:
            raise SceneError("du_x", own.du_x, f"allowed here: {INCREMENTS} increments", "enlarge du_x or du_z")
        scenes = [scene.changed(delta_bar=depth) for scene in (own, *PAPER) for depth in DEPTHS]
        await self.run(tasks.onset_of, scenes)

    def series(self) -> dict[str, Runs]:
        """Return {series: {delta_bar: Onset}} of the runs so far."""
        series = {}
        for name, scene in zip(NAMES, (series_of(self.scene), *PAPER), strict=True):
            runs = {depth: self.found.get(scene.changed(delta_bar=depth)) for depth in DEPTHS}
            series[name] = {depth: run for depth, run in runs.items() if run}
        return series

    def laws(self) -> dict[float, tuple[Onset, QuadraticLaw | None]]:
        """Return {delta_bar: (its run, the law of Eq. 8 or None)} of the series shown."""
        nodes = (self.scene if self.shown == OWN else PAPER[0]).nodes
        return {depth: (run, law_of(run, nodes)) for depth, run in self.series()[self.shown].items()}

    def content(self) -> list[Any]:
        F, A = "F̄ (10⁻³)", "Ā (10⁻³)"
        areas = self.chart(self.areas, F, A, title="Area over friction (Fig. 8a)")
        onsets = self.chart(self.onsets, F, A, title="Area at the onset of sliding (Fig. 8b)")
        tables = self.table(self.threshold_rows), self.table(self.quadratic_rows)
        return [pn.widgets.Select.from_param(self.param.shown), side_by_side(areas, onsets), side_by_side(*tables)]

    def areas(self) -> list[Curve]:
        """Return area over friction of the runs of the series shown, and Eq. 8 fitted to each."""
        fit = "Ā₀ − ζF̄² (Eq. 8)"
        curves = [Curve("runs", [], []), Curve(fit, [], [], ORANGE, DASHES[1])]
        for depth, (run, law) in self.laws().items():
            curves.append(Curve("runs", 1e3 * run.F, 1e3 * run.A, values=NAMED(depth)))
            if law:
                A = np.maximum(law.A_0 - law.zeta * run.F**2, 0.0)
                curves.append(Curve(fit, 1e3 * run.F, 1e3 * A, ORANGE, DASHES[1], values=NAMED(depth)))
        return [*curves, marks("onset", self.series()[self.shown], "gray", "circle")]

    def onsets(self) -> list[Curve]:
        """Return area over friction at the onsets of each series, and Eq. 9; onsets at BEYOND are not part of it."""
        curves = []
        for (name, runs), colour, marker in zip(self.series().items(), COLOURS, MARKERS, strict=False):
            law, beyond = line_of(runs), {depth: run for depth, run in runs.items() if depth >= BEYOND}
            if law:
                A = np.array([0.0, max(run.A_s or 0.0 for run in runs.values())])
                curves.append(Curve("", 1e3 * (law.F_nc + law.tau_c * A), 1e3 * A, colour))
            inside = {depth: run for depth, run in runs.items() if depth not in beyond}
            curves += [marks(name, inside, colour, marker), marks(name, beyond, colour, "x")]
        return curves

    def threshold_rows(self) -> pd.DataFrame:
        """Return slope and offset of Eq. 9 of each series, and how far friction at BEYOND lies below that line."""
        rows = []
        for name, runs in self.series().items():
            row, law, deepest = {"series": name}, line_of(runs), runs.get(BEYOND)
            if law:
                row |= {"τ_c (10⁻³)": f"{1e3 * law.tau_c:.3f} ± {1e3 * law.tau_c_error:.3f}"}
                row |= {"F̄_s,nc (10⁻³)": f"{1e3 * law.F_nc:.3f} ± {1e3 * law.F_nc_error:.3f}", "R²": f"{law.r2:.4f}"}
            if law and deepest and deepest.F_s and deepest.A_s is not None:
                row[f"at δ̄ = {BEYOND:g}"] = f"{100 * (deepest.F_s / (law.tau_c * deepest.A_s + law.F_nc) - 1):.1f} %"
            rows.append(row)
        return pd.DataFrame(rows).fillna("–")

    def quadratic_rows(self) -> pd.DataFrame:
        """Return Eq. 8 fitted to each run, its largest deviation over A_0, and the late over the early rate."""
        rows = []
        for depth, (run, law) in self.laws().items():
            row = {"δ̄": f"{depth:.2f}", "L̄₀ (10⁻³)": f"{1e3 * run.L[0]:.3f}", "Ā₀ (10⁻³)": f"{1e3 * run.A_0:.1f}"}
            if law:
                row |= {"ζ": f"{law.zeta:.4g}", "R²": f"{law.r2:.4f}"}
                row |= {"worst": f"{law.worst:.3f}", "rise": f"{law.rise:.2f}"}
            rows.append(row)
        return pd.DataFrame(rows).fillna("–")


def marks(label: str, runs: Runs, colour: str, marker: str) -> Curve:
    """Return the onsets of sliding of runs: area over friction."""
    slips = {NAMED(depth): (run.F_s, run.A_s) for depth, run in runs.items() if run.F_s}
    x, y = 1e3 * np.array([*slips.values()], float).reshape(-1, 2).T
    return Curve(label, x, y, colour, marker=marker, size=9.0, values=[*slips])


def law_of(run: Onset, nodes: int) -> QuadraticLaw | None:
    """Return the quadratic law of a run, or None where its area shrinks by less than a node spacing."""
    try:
        law = quadratic_law(run.F, run.A)
    except ValueError:
        return None
    return law if law.zeta > 0.0 and run.A_0 - run.A.min() > 1.0 / nodes else None


def line_of(runs: Runs) -> ThresholdLaw | None:
    """Return the threshold law of the onsets before BEYOND, or None where they have none."""
    onsets = [(run.A_s, run.F_s) for depth, run in runs.items() if run.F_s and depth < BEYOND]
    try:
        return threshold_law(*zip(*onsets, strict=True)) if onsets else None
    except ValueError:
        return None


view = AreaLaws.view
