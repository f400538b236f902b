"""The page "Stick-slip" (paper Figs. 4, 5, Eq. 7): flat on flat, from runs and from the exact branch.

Forces are divided by w times E = 70 GPa, as in the paper's Fig. 4.
"""

from contextlib import suppress
from typing import Any

import numpy as np
from bokeh.models import BoxAnnotation, FixedTicker
from bokeh.models.glyphs import Line, Scatter
from bokeh.palettes import cividis

from app.limits import INCREMENTS, increments_of
from app.pages import Sheet
from app.pages.notebook import shown
from app.schema import FLATS
from app.service import tasks
from app.views.plots import add, add_zero, blank, draw, draw_image
from solver import LIMITS, Scene, SceneError
from solver.analysis.friction_laws import critical_modulus, friction, tau_max
from solver.analysis.regimes import END, MODULI, STRENGTHS, flat, sliding
from solver.presets import presets

TITLE, ORDER, FIGURES = "Stick-slip", 2, ("forces", "mean", "map")
NORMAL = 70.0  # GPa, normalises the forces
ROWS = 120  # of the map
RATIOS = 200  # points on the curve of mean friction
MEASURED = 9  # runs to compare with that curve
ZERO_MEAN = 0.73  # of the critical modulus, a = 2.44 delta_t


def compose() -> list[Any]:
    tooltips = [("Uₓ", "@U_x{0.0} nm"), ("F", "@F{0.000}·10⁻³")]
    forces = blank("stickslip_forces", "displacement of the top Uₓ (nm)", "F/(w·70 GPa) (10⁻³)", (0, END))
    add_zero(forces)
    for name, curve in FLATS.items():
        draw(forces, Line, name, curve.colour, "U_x", "F", line_width=2, line_dash=curve.dash)
    along = {"mode": "vline"}
    draw(forces, Line, "own", "--text", "U_x", "F", tooltips=tooltips, hover=along, line_width=3)
    mean = blank("stickslip_mean", "E/τₘₐₓ", "⟨F⟩/(w τₘₐₓ)", (1.0, 1e3), (-0.05, 1.0), x_axis_type="log")
    add(mean, "low", BoxAnnotation(left=1.0, right=2.0, fill_alpha=0.18, line_alpha=0), "--shear")
    tooltips = [("E/τₘₐₓ", "@ratio{0}"), ("⟨F⟩/(w τₘₐₓ)", "@mean{0.000}")]
    draw(mean, Line, "exact", "--soft", "ratio", "mean", tooltips=tooltips, hover=along, line_width=2)
    draw(mean, Scatter, "runs", "--text", "ratio", "mean", marker="circle", size=9)
    draw(mean, Scatter, "own", "--slip", "ratio", "mean", marker="diamond", size=14)
    return [forces, mean, _map()]


def _map():
    """Return mean friction over the logarithms of stiffness and strength: a Bokeh image needs linear axes."""
    bounds = tuple(np.log10([MODULI[0], STRENGTHS[0], MODULI[1], STRENGTHS[1]]))
    plot = blank("stickslip_map", "E (GPa)", "φₜ (N/m)", (bounds[0], bounds[2]), (bounds[1], bounds[3]))
    draw_image(plot, "map", [("⟨F⟩/(w τₘₐₓ)", "@image{0.00}")], bounds, cividis(256))
    draw(plot, Line, "boundary", "--cut", "E", "phi_t", line_width=3)
    draw(plot, Scatter, "presets", "--cut", "E", "phi_t", marker="circle", size=9)
    draw(plot, Scatter, "own", "--cut", "E", "phi_t", marker="diamond", size=14)
    decades = {1: "10", 2: "100", 3: "1000"}, {-2: "0.01", -1: "0.1", 0: "1"}
    for axis, powers in zip((plot.xaxis, plot.yaxis), decades, strict=True):
        axis.update(ticker=FixedTicker(ticks=list(powers)), major_label_overrides=powers)
    return plot


def figure(scene: Scene) -> Any:
    """Return the figures for a Scene, for a notebook."""
    return shown(compose, Page, scene)


class Page(Sheet):
    """The page of one visitor; see app/pages."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.runs, self.own, self.curve = {}, None, ()  # {ratio: mean}, scene, (ratios, means)
        self.chosen = {name: flat(presets()[name].scene) for name in FLATS}

    def scene_changed(self) -> None:
        """Draw the curve of the scene on screen, and if the layer changed, the exact curve and the map."""
        self.sweep.cancel()
        before, self.own = self.own, None
        try:
            own = flat(self.session.scene)
            if increments_of(own) > INCREMENTS:
                raise SceneError(
                    "du_x", own.du_x, f"allowed here: {INCREMENTS} increments up to {END:g} nm", "enlarge it"
                )
            if before is None or before.changed(E=own.E, phi_ratio=own.phi_ratio, phi_n=own.phi_n) != own:
                self._draw_layer(own)
        except SceneError as error:
            return self.publish(texts={"stickslip-text": f"Not drawn: {error}"}, busy=None)
        self.own = own
        self._draw_own()
        self.sweep.add([(tasks.flat_curve, scene) for scene in (own, *self.chosen.values())])
        self.sweep.add([(tasks.flat_friction, scene) for scene in _measured(own)])
        self._describe()

    def order(self, values: dict[str, Any]) -> None:
        """Show the scene of a click on the map, or cancel."""
        if values.keys() >= {"E", "phi_t"} and self.own is not None:
            scene = flat(self.session.scene)
            E = float(np.clip(float(values["E"]), *MODULI))
            ratio = float(np.clip(float(values["phi_t"]), *STRENGTHS)) / scene.phi_n
            self.session.show(scene.changed(E=float(f"{E:.3g}"), phi_ratio=float(f"{ratio:.3g}")), "fig4a-blue")
        elif values.get("what") == "cancel" and self.own is not None:
            self.sweep.cancel()
            self._describe("cancelled; ")

    # drawing

    def _draw_layer(self, own):
        """Draw the exact curve and the map: mean friction depends only on E/tau_max."""
        own = own.changed(phi_n=2.0, phi_ratio=0.1)
        critical = critical_modulus(own) / tau_max(own)
        ratios = critical * np.geomspace(1e-4, 10.0, RATIOS)
        low, high = LIMITS["E"][:2]
        ratios = ratios[(ratios * tau_max(own) >= low) & (ratios * tau_max(own) <= high)]
        if ratios.size == 0:
            raise SceneError(
                "delta_t",
                own.delta_t,
                f"allowed here: one with friction between E = {low:g} and {high:g} GPa",
                "make it smaller, or use fewer nodes",
            )
        mean = np.array([_mean(own, ratio) for ratio in ratios])
        self.curve = ratios, mean
        self.draw("mean", "exact", ratio=ratios, mean=mean)
        self.views["mean"].parts["low"].update(left=critical, right=ratios[-1] * 10)
        E, phi_t = np.geomspace(*MODULI, ROWS), np.geomspace(*STRENGTHS, ROWS)
        over = E / (phi_t[:, None] * tau_max(own) / own.phi_t)
        image = np.interp(np.log(over), np.log(ratios), mean, left=mean[0], right=0.0).astype(np.float32)
        self.draw("map", "map", image=[image])
        self.views["map"].parts["map"].glyph.color_mapper.update(low=0.0, high=float(mean.max()))
        line = critical * phi_t * tau_max(own) / own.phi_t
        self.draw("map", "boundary", E=np.log10(line), phi_t=np.log10(phi_t))
        self.draw("map", "presets", **_place(*self.chosen.values()))

    def _draw_own(self):
        own, (ratios, means) = self.own, self.curve
        self.draw("map", "own", **_place(own))
        ratio = [own.E / tau_max(own)] if own.phi_t > 0 else []
        self.draw("mean", "own", ratio=ratio, mean=np.interp(np.log(ratio), np.log(ratios), means, right=0.0))
        start = min([1e-3 * ratios[-1], *(0.7 * one for one in ratio)])
        self.views["mean"].figure.x_range.update(start=max(start, ratios[0]), end=ratios[-1])
        self.draw("forces", "own", U_x=[], F=[])
        self.runs = {}
        self.draw("mean", "runs", ratio=[], mean=[])

    def take(self, call: Any, result: Any) -> None:
        """Take the result of a run."""
        kind, scene = call
        if isinstance(result, Exception):
            return self._describe(f"One run failed: {result}. ")
        if kind is tasks.flat_curve:
            for name, one in (self.chosen | {"own": self.own}).items():
                if one == scene:
                    self._draw_curve(name, scene, result)
        else:
            F_s, F_k, _ = result
            self.runs[scene.E / tau_max(scene)] = 0.5 * (F_s + F_k) * scene.E / tau_max(scene)
            self.draw("mean", "runs", ratio=list(self.runs), mean=list(self.runs.values()))
        self._describe()

    def _draw_curve(self, label, scene, result):
        U, F = result
        self.draw("forces", label, U_x=U, F=F * np.float32(1000 * scene.E / NORMAL))
        drawn = [self.views["forces"].parts[name].data_source.data["F"] for name in (*FLATS, "own")]
        high = max(float(np.max(values, initial=0.0)) for values in drawn)
        low = min(float(np.min(values, initial=0.0)) for values in drawn)
        self.views["forces"].figure.y_range.update(start=low - 0.08 * high, end=1.1 * high + 1e-6)

    def _describe(self, before=""):
        own = self.own
        sticks = critical_modulus(own) > own.E
        first = friction(own).F_s * own.E * own.shear_compliance if sticks else 0.0
        regime = (
            f"stick, and slip first at about Uₓ = {first:.0f} nm"
            if sticks
            else "slide continuously, almost without friction"
        )
        text = (
            f"{before}Flat on flat and with a rigid drive, this interface (E = {own.E:g} GPa,"
            f" φₜ = {own.phi_t:g} N/m) would {regime}. Sliding is continuous above"
            f" E = {critical_modulus(own):,.0f} GPa. There the stiffness of the layer (G/h) equals the softening of"
            f" the interface (max dT/dx). The mean of Eq. 7 is zero above {ZERO_MEAN:g} times this modulus,"
            " as every slip swings back to the opposite force."
        )
        most = f"{self.curve[1].max():.2g}"  # of the map's colours; it depends on the node spacing
        self.publish(texts={"stickslip-text": text, "stickslip-most": most}, busy=self.sweep.part)


def _mean(scene, ratio):
    """Return the exact mean friction over tau_max at E/tau_max = ratio."""
    E = ratio * tau_max(scene)
    return friction(scene.changed(E=E)).mean * E / tau_max(scene)


def _measured(own):
    """Yield scenes with the strength of `own` over the range of E/tau_max that the solver allows."""
    critical = critical_modulus(own)
    for E in np.geomspace(critical / 30.0, 3.0 * critical, MEASURED) if own.phi_t > 0 else ():
        with suppress(SceneError):
            scene = sliding(own, E)
            if increments_of(scene) <= INCREMENTS:
                yield scene


def _place(*scenes):
    """Return the coordinates of scenes on the map."""
    inside = [scene for scene in scenes if scene.phi_t >= STRENGTHS[0]]
    return {name: np.log10([getattr(scene, name) for scene in inside]) for name in ("E", "phi_t")}
