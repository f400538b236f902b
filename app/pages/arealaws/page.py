"""The page "Area laws" (paper Fig. 8, Eqs. 8, 9): runs up to the onset of sliding over a range of indentations.

A series is one interface on one layer at all INDENTATIONS: the three of Fig. 8, and those that a visitor adds. All
visitors share the results (requests.py).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from bokeh.models.glyphs import Line, Scatter

from app.limits import INCREMENTS, increments_of
from app.pages import Sheet
from app.pages.notebook import laid_out, page_of
from app.service import tasks
from app.views.plots import blank, draw
from solver import Scene, SceneError
from solver.analysis.area_laws import quadratic_law, threshold_law
from solver.analysis.friction_laws import INDENTATIONS, INTERFACES
from solver.presets import presets

TITLE, ORDER, FIGURES = "Area laws", 3, ("runs", "threshold")
BEYOND = 1.0  # delta_bar beyond those of Fig. 8, where the threshold line bends
DEPTHS = (*INDENTATIONS, BEYOND)
MARKS = (  # of the series: marker, its character, colour, dash; their number is the maximum of series
    ("circle", "●", "--text", "solid"),
    ("square", "■", "--adhering", "dashed"),
    ("triangle", "▲", "--repulsive", "dotted"),
    ("diamond", "◆", "--slip", "dotdash"),
    ("star", "★", "--shear", "dashdot"),
)
FORCE, AREA = "F̄ (10⁻³)", "Ā (10⁻³)"
THOUSAND = 1000.0
NONE = "–"  # an empty cell of a table


def compose() -> list[Any]:
    """Return the figures of the page."""
    tooltips = [("δ̄", "@delta_bar{0.00}"), ("F̄", "@F{0.000}·10⁻³"), ("Ā", "@A{0.00}·10⁻³")]
    runs = blank("arealaws_runs", FORCE, AREA)
    draw(runs, Line, "runs", "--repulsive", "F", "A", "delta_bar", tooltips=tooltips, line_width=2)
    draw(runs, Line, "fits", "--adhering", "F", "A", line_width=2, line_dash="dashed")
    draw(runs, Scatter, "onsets", "--text", "F", "A", marker="circle", size=8)
    threshold = blank("arealaws_threshold", FORCE, AREA)
    for k, (_, _, colour, dash) in enumerate(MARKS):
        draw(threshold, Line, f"line{k}", colour, "F", "A", line_width=2, line_dash=dash)
    for k, (marker, _, colour, _) in enumerate(MARKS):
        look = {"tooltips": tooltips, "marker": marker, "size": 9}
        draw(threshold, Scatter, f"points{k}", colour, "F", "A", "delta_bar", **look)
        draw(threshold, Scatter, f"beyond{k}", colour, "F", "A", marker="x", size=9)
    return [runs, threshold]


def series_of(scene: Scene) -> Scene:
    """Return the scene that identifies a series: with a fixed indentation, path and length."""
    return scene.changed(delta_bar=0.0, u_x_max=Scene().u_x_max, path="shear", damping=1.0)


PAPER = [series_of(presets()[name].scene) for name in INTERFACES]  # they have the first marks


@dataclass
class Series:
    """A series: the scene that identifies it, its index in MARKS, and the results of its runs {delta_bar: result}."""

    scene: Scene
    mark: int
    results: dict = field(default_factory=dict)

    @property
    def found(self) -> list[tuple[float, dict]]:
        """[(delta_bar, result)] of the runs that succeeded."""
        return sorted((depth, result) for depth, result in self.results.items() if isinstance(result, dict))

    @property
    def onsets(self) -> list[tuple[float, float, float]]:
        """[(F_s, A_s, delta_bar)] of the runs that slipped, forces and areas times 1000."""
        return [(THOUSAND * r["F_s"], THOUSAND * r["A_s"], depth) for depth, r in self.found if r["F_s"]]

    @property
    def name(self) -> str:
        """Label: its interface, and its layer if that is not the paper's."""
        scene = self.scene
        text = f"φₙ = {scene.phi_n:g}, φₜ/φₙ = {scene.phi_ratio:g}"
        text += f", E = {scene.E:g}" if scene.E != Scene().E else ""
        other = scene.changed(phi_n=2.0, phi_ratio=1.0, E=70.0) != Scene()
        return f"{text} and other parameters" if other else text

    def quadratic(self, result: Any) -> Any:
        """Fit the quadratic law to a run; None if the area shrinks by less than a node spacing."""
        try:
            law = quadratic_law(result["F"], result["A"])
        except ValueError:
            return None
        return law if law.zeta > 0.0 and result["A"][0] - result["A"].min() > 1.0 / self.scene.nodes else None

    def threshold(self, beyond: bool = False) -> Any:
        """Fit the threshold law to the onsets; None if impossible."""
        points = [(A / THOUSAND, F / THOUSAND) for F, A, depth in self.onsets if beyond or depth < BEYOND]
        try:
            return threshold_law(*zip(*points, strict=True)) if points else None
        except ValueError:
            return None

    def row(self) -> list[str]:
        """Return the row of this series: slope and offset of its law, R^2, and the bend beyond."""
        law, bent, deepest = self.threshold(), self.threshold(beyond=True), dict(self.found).get(BEYOND)
        done = "" if len(self.results) == len(DEPTHS) else f"{len(self.results)} of {len(DEPTHS)} runs"
        if not law:
            return [NONE, NONE, NONE, done or NONE]
        bend = NONE
        if bent and deepest and deepest["F_s"]:
            below = 1.0 - deepest["F_s"] / (law.tau_c * deepest["A_s"] + law.F_nc)
            bend = f"{-100.0 * below:.1f} %, {bent.r2:.3f}"
        values = (law.tau_c, law.tau_c_error), (law.F_nc, law.F_nc_error)
        both = [f"{THOUSAND * value:.3f} ± {THOUSAND * error:.3f}" for value, error in values]
        return [*both, f"{law.r2:.4f}", done or bend]

    def rows(self) -> Iterator[list[str]]:
        """Yield the rows of the table of its runs."""
        for depth, result in self.found:
            law = self.quadratic(result)
            fit = [f"{law.zeta:.4g}", f"{law.r2:.4f}", f"{law.worst:.3f}", f"{law.rise:.2f}"] if law else [NONE] * 4
            yield [f"{depth:.2f}", f"{THOUSAND * result['L_0']:.3f}", f"{THOUSAND * result['A_0']:.1f}", *fit]


def figure(scene: Scene) -> Any:
    """Return the figures of the series of a Scene, for a notebook."""
    page = page_of(compose, Page, scene)
    page.add_series(series_of(scene))
    return laid_out(page)


class Page(Sheet):
    """The page of one visitor; see app/pages."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.series, self.shown = {}, None  # {scene that identifies it: Series}, in order of addition

    def start(self) -> None:
        """Add the series on screen first, then those of Fig. 8."""
        for scene in (self._own()[0], *PAPER):
            if scene:
                self.add_series(scene)
        self._publish()

    def scene_changed(self) -> None:
        """Update the button that adds the series of the scene on screen."""
        self._publish()

    def order(self, values: dict[str, Any]) -> None:
        """Add the series on screen, show the curves of another series, or cancel."""
        what, place = values.get("what"), int(values.get("series", 0))
        own, _ = self._own()
        if what == "add" and own:
            self.add_series(own)
        elif what == "cancel":
            self.sweep.cancel()
        elif what == "show" and 0 <= place < len(self.series):
            self.shown = [*self.series.values()][place]
            self._draw_runs()
        self._publish()

    def _own(self):
        """Return (scene that identifies the series on screen, "") or (None, why there is none)."""
        try:
            scene = series_of(self.session.scene)
            _calls(scene)
        except SceneError as error:
            return None, f"No series: {error}"
        if scene.surface == "flat":
            return None, "The surface on screen is flat and has no edge that can peel. Choose another surface."
        if increments_of(scene) > INCREMENTS:
            why = f"A run would take more than {INCREMENTS} increments: enlarge du_x or du_z for a series here."
            return None, why
        return scene, ""

    def add_series(self, scene: Scene) -> None:
        """Add a series; if there are too many, it replaces the oldest."""
        if scene not in self.series:
            own = [one for one in self.series.values() if one.mark >= len(PAPER)]
            if scene not in PAPER and len(own) == len(MARKS) - len(PAPER):
                oldest = next(one for one in own if one is not self.shown)
                self.sweep.cancel(_calls(oldest.scene))  # the results stay in the cache
                own.remove(oldest)
                del self.series[oldest.scene]
            free = set(range(len(PAPER), len(MARKS))) - {one.mark for one in own}
            self.series[scene] = Series(scene, PAPER.index(scene) if scene in PAPER else min(free))
        self.shown = self.shown or self.series[scene]
        self.sweep.add(_calls(scene))

    def take(self, call: Any, result: Any) -> None:
        """Take the result of a run."""
        one = self.series.get(series_of(call[1]))
        if one:
            one.results[call[1].delta_bar] = result
            self._draw_threshold()
            if one is self.shown:
                self._draw_runs()
            self._publish()

    # drawing

    def _draw_runs(self):
        """Draw area over force of one series, with gaps between curves, and the quadratic law fitted to each."""
        curves, fits = [([], [], [])], [([], [])]
        for depth, result in self.shown.found:
            F, A = (np.append(THOUSAND * result[name], np.nan) for name in "FA")
            curves.append((F, A, np.full(F.size, depth)))
            law = self.shown.quadratic(result)
            if law:
                A = THOUSAND * law.A_0 - law.zeta * F**2 / THOUSAND
                fits.append((F, np.where(A < 0, np.nan, A)))
        (F, A, depths), (F_fit, A_fit) = (map(np.concatenate, zip(*rows, strict=True)) for rows in (curves, fits))
        self.draw("runs", "runs", F=F, A=A, delta_bar=depths)
        self.draw("runs", "fits", F=F_fit, A=A_fit)
        self.draw("runs", "onsets", **_columns(self.shown.onsets))
        self._fit("runs", F, A)

    def _draw_threshold(self):
        """Draw the onsets of all series with the extended threshold law."""
        drawn, every = {one.mark: one for one in self.series.values()}, []
        for k in range(len(MARKS)):
            one = drawn.get(k)
            points, law, line = one.onsets if one else [], one and one.threshold(), []
            if law:
                top = max(A for _, A, _ in points)
                line = [(THOUSAND * law.F_nc + law.tau_c * A, A, None) for A in (0.0, top)]
            self.draw("threshold", f"points{k}", **_columns([point for point in points if point[2] < BEYOND]))
            self.draw("threshold", f"beyond{k}", **_columns([point for point in points if point[2] >= BEYOND]))
            self.draw("threshold", f"line{k}", **_columns(line))
            every += points
        self._fit("threshold", [F for F, _, _ in every], [A for _, A, _ in every])

    def _fit(self, slot, F, A):
        figure = self.views[slot].figure
        for axis, values in ((figure.x_range, F), (figure.y_range, A)):
            low, high = np.nanmin([0.0, *values]), np.nanmax([0.0, *values]) or 1.0
            axis.update(start=low - 0.03 * (high - low), end=high + 0.07 * (high - low))

    def _publish(self):
        own, why = self._own()
        series = []
        for k, one in enumerate(self.series.values()):
            pick = {"label": one.name, "pressed": one is self.shown, "ask": {"what": "show", "series": k}}
            series.append([MARKS[one.mark][1], pick, *one.row()])
        results = [each for one in self.series.values() for each in one.results.items()]
        failures = [f"δ̄ = {depth:g}: {result}" for depth, result in results if not isinstance(result, dict)]
        texts = {"of": f"of {self.shown.name}" if self.shown else "", "own": why, "failures": " ".join(failures)}
        self.publish(
            busy=self.sweep.part,
            texts={f"arealaws-{name}": text for name, text in texts.items()},
            tables={"arealaws-series": series, "arealaws-rows": [*self.shown.rows()] if self.shown else []},
            hidden={"arealaws-add": own is None or own in self.series, "arealaws-failures": not failures},
        )


def _calls(scene):
    return [(tasks.onset_of, scene.changed(delta_bar=depth)) for depth in DEPTHS]


def _columns(points):
    """Return the columns of [(F, A, delta_bar)]."""
    return {name: [point[k] for point in points] for k, name in enumerate(("F", "A", "delta_bar"))}
