"""The page "Area laws" (paper Fig. 8, Eqs. 8, 9): runs up to the onset of sliding over a range of indentations.

from app.lab.area_laws import view; view(Scene(phi_ratio=0.5))
"""

from time import monotonic
from typing import Any

import holoviews as hv
import pandas as pd
import panel as pn
import param

from app.lab.base import WIDE, LabPage
from app.limits import INCREMENTS, increments_of
from app.service import tasks
from app.service.jobs import jobs
from solver import Scene, SceneError
from solver.analysis.area_laws import QuadraticLaw, ThresholdLaw, quadratic_law, threshold_law
from solver.analysis.friction_laws import INDENTATIONS, INTERFACES
from solver.live_plots import area_curves, thresholds
from solver.presets import presets

TITLE = "Area laws"
BEYOND = 1.0  # delta_bar beyond those of Fig. 8, where the threshold line bends
DEPTHS = (*INDENTATIONS, BEYOND)
APART = 1.0  # s between two drawings
Results = dict[float, Any]  # by delta_bar: as of tasks.onset_of
Row = tuple[float, float, float]  # F_s, A_s, delta_bar


def series_of(scene: Scene) -> Scene:
    """Return the scene that identifies a series: with a fixed indentation, path and length."""
    return scene.changed(delta_bar=0.0, u_x_max=Scene().u_x_max, path="shear", damping=1.0)


def name_of(scene: Scene) -> str:
    """Return the label of a series: its interface, and its layer if that is not the paper's."""
    text = f"φₙ = {scene.phi_n:g}, φₜ/φₙ = {scene.phi_ratio:g}"
    text += f", E = {scene.E:g}" if scene.E != Scene().E else ""
    other = scene.changed(phi_n=2.0, phi_ratio=1.0, E=70.0) != Scene()
    return f"{text} and other parameters" if other else text


PAPER = {name_of(scene): scene for scene in (series_of(presets()[name].scene) for name in INTERFACES)}


OWN = "this interface"


class AreaLaws(LabPage):
    """Contact area over friction of the interface on screen and of the three of the paper."""

    TITLE = TITLE
    STATEMENT = (
        "Paper: under shear the contact area shrinks as Ā = Ā₀ − ζF̄² (Eq. 8), and at the onset of sliding friction is"
        " F̄_s = τ_c Ā_s + F̄_s,nc (Eq. 9), with friction at no contact area. Each series is one interface at"
        f" {len(DEPTHS)} press depths; lines go through the onsets with contact up to δ̄ = 0.6, × is δ̄ = {BEYOND:g}."
    )
    results = param.Dict({name: {} for name in (OWN, *PAPER)}, doc="{series: {delta_bar: as of tasks.onset_of}}")
    shown = param.Selector(objects=[OWN, *PAPER], label="Series")

    async def compute(self) -> None:
        own = series_of(self.scene)
        if own.surface == "flat":
            raise SceneError("surface", "flat", "it has no edge that can peel", "choose another surface")
        if increments_of(own) > INCREMENTS:
            raise SceneError("du_x", own.du_x, f"allowed here: {INCREMENTS} increments", "enlarge du_x or du_z")
        series, drawn = {OWN: own} | PAPER, 0.0
        known = self.results | {OWN: {}}
        calls = [(name, depth) for name in series for depth in DEPTHS if depth not in known[name]]
        for done, (name, depth) in enumerate(calls):
            self.share = done / len(calls)
            result = await jobs.result(tasks.onset_of, series[name].changed(delta_bar=depth), owner=id(self))
            if isinstance(result, dict):
                result = result | {"nodes": series[name].nodes}
            known[name] = known[name] | {depth: result}
            if monotonic() > drawn + APART or done + 1 == len(calls):
                self.results, drawn = dict(known), monotonic()
        outcomes = [outcome for runs in self.results.values() for outcome in runs.items()]
        self.text = " ".join(f"δ̄ = {depth:g}: {why}." for depth, why in outcomes if isinstance(why, str))

    def content(self) -> list[Any]:
        runs = pn.bind(lambda results, name: found(results.get(name, {})), self.param.results, self.param.shown)
        areas = hv.DynamicMap(pn.bind(lambda runs: area_curves(runs, law_of), runs))
        limits = hv.DynamicMap(
            pn.bind(lambda results: thresholds(onsets(results), line_of, BEYOND), self.param.results)
        )
        tables = pn.bind(threshold_table, self.param.results), pn.bind(quadratic_table, runs)
        look = {"disabled": True, "show_index": False, "sizing_mode": "stretch_width"}
        return [
            pn.widgets.Select.from_param(self.param.shown),
            pn.FlexBox(*(pn.pane.HoloViews(plot, styles=WIDE) for plot in (areas, limits))),
            pn.FlexBox(*(pn.widgets.Tabulator(table, **look) for table in tables)),
        ]


def found(results: Results) -> Results:
    """Return {delta_bar: result} of the runs that succeeded, in order."""
    return {depth: results[depth] for depth in sorted(results) if isinstance(results[depth], dict)}


def onsets(results: dict[str, Results]) -> dict[str, list[Row]]:
    """Return {series: rows of its onsets}."""
    return {name: onsets_of(found(each)) for name, each in results.items()}


def onsets_of(runs: Results) -> list[Row]:
    """Return rows (F_s, A_s, delta_bar) of the runs that slipped."""
    return [(run["F_s"], run["A_s"], depth) for depth, run in runs.items() if run["F_s"]]


def law_of(run: dict[str, Any]) -> QuadraticLaw | None:
    """Return the quadratic law of a run; None if its area shrinks by less than a node spacing."""
    try:
        law = quadratic_law(run["F"], run["A"])
    except ValueError:
        return None
    return law if law.zeta > 0.0 and run["A"][0] - run["A"].min() > 1.0 / run["nodes"] else None


def line_of(onsets: list[Row]) -> ThresholdLaw | None:
    """Return the threshold law of onsets up to BEYOND; None if impossible."""
    points = [(A, F) for F, A, depth in onsets if depth < BEYOND]
    try:
        return threshold_law(*zip(*points, strict=True)) if points else None
    except ValueError:
        return None


def threshold_table(results: dict[str, Results]) -> pd.DataFrame:
    """Return slope and offset of Eq. 9 of each series, and how far friction at BEYOND lies below that line."""
    rows = []
    for name, each in results.items():
        runs, row = found(each), {"series": name}
        law, deepest = line_of(onsets_of(runs)), runs.get(BEYOND)
        if law:
            row |= {"τ_c (10⁻³)": f"{1e3 * law.tau_c:.3f} ± {1e3 * law.tau_c_error:.3f}"}
            row |= {"F̄_s,nc (10⁻³)": f"{1e3 * law.F_nc:.3f} ± {1e3 * law.F_nc_error:.3f}", "R²": f"{law.r2:.4f}"}
        if law and deepest and deepest["F_s"]:
            row[f"at δ̄ = {BEYOND:g}"] = f"{100 * (deepest['F_s'] / (law.tau_c * deepest['A_s'] + law.F_nc) - 1):.1f} %"
        rows.append(row)
    return pd.DataFrame(rows).fillna("–")


def quadratic_table(runs: Results) -> pd.DataFrame:
    """Return Eq. 8 fitted to each run, its largest deviation over A_0, and the late over the early rate."""
    rows = []
    for depth, run in runs.items():
        law, row = law_of(run), {"δ̄": f"{depth:.2f}", "L̄₀ (10⁻³)": f"{1e3 * run['L_0']:.3f}"}
        row["Ā₀ (10⁻³)"] = f"{1e3 * run['A_0']:.1f}"
        if law:
            row |= {"ζ": f"{law.zeta:.4g}", "R²": f"{law.r2:.4f}"}
            row |= {"worst": f"{law.worst:.3f}", "rise": f"{law.rise:.2f}"}
        rows.append(row)
    return pd.DataFrame(rows).fillna("–")


def view(scene: Scene | None = None) -> pn.viewable.Viewable:
    """Return the page for a Scene (default: the default Scene)."""
    return AreaLaws(scene).view()
