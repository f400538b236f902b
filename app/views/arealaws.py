"""The page "Area laws" (paper Fig. 8, Eqs. 8, 9): runs up to the onset of sliding over a range of indentations.

A series is one interface on one layer at all INDENTATIONS: the three of Fig. 8 and those on screen since. Results are
kept for all visitors (sweep.py).
"""

import holoviews as hv
import numpy as np

from app.limits import INCREMENTS, increments_of
from app.service import tasks
from app.service.sweep import Sweep
from app.views.pages import Sheet
from app.views.plots import curve, dots, rendered
from solver import Scene, SceneError
from solver.analysis.area_laws import quadratic_law, threshold_law
from solver.analysis.friction_laws import INDENTATIONS, INTERFACES

BEYOND = 1.0  # delta_bar beyond those of Fig. 8, where the threshold line has begun to bend
DEPTHS = (*INDENTATIONS, BEYOND)
MOST = 5  # series at a time
MARKS = (  # of a series: marker, the same as text, colour, dash
    ("circle", "●", "--text", "solid"),
    ("square", "■", "--adhering", "dashed"),
    ("triangle", "▲", "--repulsive", "dotted"),
    ("diamond", "◆", "--slip", "dotdash"),
    ("star", "★", "--shear", "dashdot"),
)
FORCE = hv.Dimension("F", label="F̄", unit="10⁻³")
AREA = hv.Dimension("A", label="Ā", unit="10⁻³")
THOUSAND = 1000.0


def compose():
    """The views of the page."""
    said = [("δ̄", "@delta_bar{0.00}"), ("F̄", "@F{0.000}·10⁻³"), ("Ā", "@A{0.00}·10⁻³")]
    both = hv.Curve(([], [], []), FORCE, [AREA, "delta_bar"], label="runs")
    runs = rendered(
        "arealaws_runs",
        [
            both.opts(default_tools=[], line_width=2, tools=["hover"], hover_tooltips=said),
            curve("fits", FORCE, AREA, line_width=2, line_dash="dashed"),
            dots("onsets", FORCE, AREA, marker="circle", size=8),
        ],
        {"runs": "--repulsive", "fits": "--adhering", "onsets": "--text"},
    )
    lines, points, beyond, colours = [], [], [], {}
    for k, (marker, _, colour, dash) in enumerate(MARKS):
        lines.append(curve(f"line{k}", FORCE, AREA, line_width=2, line_dash=dash))
        onsets = hv.Scatter(([], [], []), FORCE, [AREA, "delta_bar"], label=f"points{k}")
        points.append(onsets.opts(default_tools=[], marker=marker, size=9, tools=["hover"], hover_tooltips=said))
        beyond.append(dots(f"beyond{k}", FORCE, AREA, marker="x", size=9))
        colours |= {f"line{k}": colour, f"points{k}": colour, f"beyond{k}": colour}
    threshold = rendered("arealaws_threshold", [*lines, *points, *beyond], colours)
    return [runs, threshold]


def series_of(scene):
    """The scene that stands for its series: whatever the indentation, the path and its length."""
    return scene.changed(delta_bar=0.0, u_x_max=Scene().u_x_max, path="shear", damping=1.0)


def named(scene):
    """What a series is called: its interface, and its layer if that is not the paper's."""
    text = f"φₙ = {scene.phi_n:g}, φₜ/φₙ = {scene.phi_ratio:g}"
    other = scene.changed(phi_n=2.0, phi_ratio=1.0, E=70.0) != Scene()
    return text + (f", E = {scene.E:g}" if scene.E != Scene().E else "") + (" and other parameters" if other else "")


class Page(Sheet):
    """See pages.py."""

    def __init__(self, *given):
        super().__init__(*given)
        self.sweep = Sweep(self.session, self._take)
        self.series = {}  # scene: {delta_bar: result}
        self.marks = {series_of(Scene(**values)): k for k, values in enumerate(INTERFACES.values())}  # as in the paper
        self.shown = None

    def start(self):
        """The series on screen first, then those of Fig. 8."""
        self._add(self.session.scene)
        for values in INTERFACES.values():
            self._add(Scene(**values))
        self._publish()

    def scene_changed(self):
        """Whether the scene on screen could be a series of its own is said; it is added by a button."""
        self._publish()

    def order(self, values):
        """Add the series on screen, show another one's curves, or cancel."""
        what = values.get("what")
        if what == "add":
            self._add(self.session.scene)
        elif what == "cancel":
            self.sweep.cancel()
        elif what == "show":
            place, series = int(values.get("series", 0)), list(self.series)
            if 0 <= place < len(series):
                self.shown = series[place]
                self._draw_runs()
        self._publish()

    def close(self):
        """Ask for nothing any longer."""
        self.sweep.cancel()

    def _add(self, scene):
        """A series, in place of the oldest if there are too many; a circular punch only, as the flat has no edge."""
        try:
            scene = series_of(scene)
            self._calls(scene)
        except SceneError:
            return
        if self._why_not(scene):
            return
        if scene not in self.series:
            own = [s for s in self.series if self.marks[s] >= len(INTERFACES)]
            if scene not in self.marks and len(own) == MOST - len(INTERFACES):
                self._drop(next(s for s in own if s is not self.shown))
            taken = {self.marks[s] for s in self.series}
            self.marks.setdefault(scene, next(k for k in range(len(INTERFACES), MOST + 1) if k not in taken))
            self.series[scene] = {}
        if not self.shown:
            self.shown = scene
        self.sweep.add(self._calls(scene))

    def _calls(self, scene):
        return [(tasks.onset_of, scene.changed(delta_bar=depth)) for depth in DEPTHS]

    def _drop(self, scene):
        """Take a series off the page; what is known of it is kept (sweep.py)."""
        self.sweep.drop(self._calls(scene))
        del self.series[scene], self.marks[scene]

    def _take(self, call, result):
        scene = call[1]
        series = series_of(scene)
        if series in self.series:
            self.series[series][scene.delta_bar] = result
            self._draw_threshold()
            if series == self.shown:
                self._draw_runs()
            self._publish()

    # drawing

    def _draw_runs(self):
        """Area against force of one series, curves with gaps between them, and the quadratic law fitted to each."""
        rows, fits, onsets = [], [], []
        for depth, result in sorted(_found(self.series[self.shown])):
            F, A = THOUSAND * result["F"], THOUSAND * result["A"]
            rows += [(F, A, np.full(F.size, depth)), ([np.nan],) * 3]
            if result["F_s"] is not None:
                onsets.append((THOUSAND * result["F_s"], THOUSAND * result["A_s"]))
            law = _quadratic(self.shown, result)
            if law:
                fits += [(F, THOUSAND * (law.A_0 - law.zeta * result["F"] ** 2)), ([np.nan],) * 2]
        F, A, depth = _joined(rows, 3)
        self.draw("runs", "runs", F=F, A=A, delta_bar=depth)
        F_fit, A_fit = _joined(fits, 2)
        self.draw("runs", "fits", F=F_fit, A=np.where(A_fit < 0, np.nan, A_fit))
        self.draw("runs", "onsets", F=[f for f, _ in onsets], A=[a for _, a in onsets])
        self._fit("runs", F, A)

    def _draw_threshold(self):
        """The onsets of all series with the extended threshold law."""
        most_F = most_A = 0.0
        drawn = {self.marks[scene]: results for scene, results in self.series.items()}
        for k in range(MOST):
            results = drawn.get(k, {})
            points = [(d, THOUSAND * r["F_s"], THOUSAND * r["A_s"]) for d, r in sorted(_found(results)) if r["F_s"]]
            inside = [p for p in points if p[0] < BEYOND]
            self.draw(
                "threshold",
                f"points{k}",
                F=[p[1] for p in inside],
                A=[p[2] for p in inside],
                delta_bar=[p[0] for p in inside],
            )
            self.draw(
                "threshold",
                f"beyond{k}",
                F=[p[1] for p in points[len(inside) :]],
                A=[p[2] for p in points[len(inside) :]],
            )
            law, line = _threshold(results), ([], [])
            if law:
                top = max(p[2] for p in points)
                line = [THOUSAND * law.F_nc, THOUSAND * law.F_nc + law.tau_c * top], [0.0, top]
            self.draw("threshold", f"line{k}", F=line[0], A=line[1])
            most_F, most_A = max([most_F, *(p[1] for p in points)]), max([most_A, *(p[2] for p in points)])
        self._fit("threshold", [most_F], [most_A])

    def _fit(self, slot, F, A):
        figure = self.views[slot].figure
        for axis, values in ((figure.x_range, F), (figure.y_range, A)):
            known = np.asarray(values, float)
            known = known[np.isfinite(known)]
            low, high = min([0.0, *known]), max([1e-3, *known])
            axis.update(start=low - 0.03 * (high - low), end=high + 0.07 * (high - low))

    def _why_not(self, scene):
        """Why a scene is no series, if it is none."""
        if scene.surface == "flat":
            return "The surface on screen is flat, without an edge that could peel: it has no series here."
        if increments_of(scene) > INCREMENTS:
            return f"A run would take more than {INCREMENTS} increments: enlarge du_x or du_z for a series here."
        return ""

    def _own(self):
        """Why the scene on screen is no series, if it is none."""
        try:
            return self._why_not(series_of(self.session.scene))
        except SceneError as error:
            return f"No series: {error}"

    def _publish(self):
        try:
            own = series_of(self.session.scene)
            addable = own not in self.series and not self._why_not(own)
        except SceneError:
            addable = False
        self.publish(
            busy=self.sweep.part,
            texts={"arealaws-of": f"of {named(self.shown)}" if self.shown else "", "arealaws-own": self._own()},
            series=[
                {
                    "name": named(scene),
                    "mark": MARKS[self.marks[scene]][1],
                    "done": len(results),
                    "of": len(DEPTHS),
                    "shown": scene is self.shown,
                }
                | _threshold_row(results)
                for scene, results in self.series.items()
            ],
            rows=[_row(self.shown, depth, result) for depth, result in sorted(_found(self.series[self.shown]))]
            if self.shown
            else [],
            failures=[
                f"δ̄ = {d:g}: {r}"
                for results in self.series.values()
                for d, r in results.items()
                if not isinstance(r, dict)
            ],
            addable=addable,
        )


def _found(results):
    """(delta_bar, result) of the runs that came to an end."""
    return [(depth, result) for depth, result in results.items() if isinstance(result, dict)]


def _joined(rows, columns):
    """Rows of tuples of arrays, end to end."""
    if not rows:
        return tuple(np.empty(0) for _ in range(columns))
    return tuple(np.concatenate([np.asarray(row[c], float) for row in rows]) for c in range(columns))


def _quadratic(scene, result):
    """The fitted law, or None where the area does not fall by as much as a node spacing."""
    try:
        law = quadratic_law(result["F"], result["A"])
    except ValueError:
        return None
    return law if law.zeta > 0.0 and result["A"][0] - result["A"].min() > 1.0 / scene.nodes else None


def _threshold(results, beyond=False):
    points = [(r["A_s"], r["F_s"]) for d, r in _found(results) if r["F_s"] and (beyond or d < BEYOND)]
    try:
        return threshold_law(*zip(*points, strict=True)) if points else None
    except ValueError:
        return None


def _threshold_row(results):
    law, bent = _threshold(results), _threshold(results, beyond=True)
    if law is None:
        return {}
    row = {name: getattr(law, name) for name in ("tau_c", "tau_c_error", "F_nc", "F_nc_error", "r2")}
    deepest = dict(_found(results)).get(BEYOND)
    if bent and deepest and deepest["F_s"]:
        row |= {"r2_beyond": bent.r2, "bend": 1.0 - deepest["F_s"] / (law.tau_c * deepest["A_s"] + law.F_nc)}
    return row


def _row(scene, depth, result):
    law = _quadratic(scene, result)
    row = {"delta_bar": depth, "L_0": result["L_0"], "A_0": result["A_0"], "F_s": result["F_s"], "A_s": result["A_s"]}
    return row | ({"zeta": law.zeta, "r2": law.r2, "worst": law.worst, "rise": law.rise} if law else {})
