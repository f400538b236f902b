"""The page "Stick-slip" (paper Figs. 4, 5, Eq. 7): friction of flat on flat at zero gap, from runs and in closed form.

from app.features.stick_slip.research import view; view(Scene(E=140))
"""

from contextlib import suppress
from typing import Any

import numpy as np
import panel as pn
import param
from bokeh.models import LinearColorMapper

from app.document import on_loop
from app.features.lab.base import LabPage, side_by_side
from app.features.lab.feature import TEXT
from app.features.lab.tasks import flat_frames
from app.features.stick_slip.feature import TITLE
from app.limits import INCREMENTS, increments_of
from solver import Scene, SceneError
from solver.analysis.friction_laws import critical_modulus, friction, friction_force, tau_max
from solver.analysis.regimes import END, MODULI, STRENGTHS, flat, mean_friction, sliding
from solver.live_plots import COLOURS, DASHES, ORANGE, Curve
from solver.presets import presets

NORMAL = 70.0  # GPa, over which forces are taken in the paper's Fig. 4
FLATS = {  # preset: label of its curve; E in GPa, phi_t in N/m
    "fig4a-blue": "Fig. 4a: E 70, φₜ 0.2",
    "fig4a-red": "Fig. 4a: 140, 0.2",
    "fig4a-green": "Fig. 4a: 70, 0.1",
    "fig4b-weak": "Fig. 4b: 70, 0.004",
    "fig4b-stiff": "Fig. 4b: 3000, 0.2",
}
PAPER = {label: flat(presets()[name].scene) for name, label in FLATS.items()}
MEAN = "⟨F⟩/(w τₘₐₓ)"
MEASURED = 9  # runs to compare with the closed form
ZERO_MEAN = 0.73  # of the critical modulus, a = 2.44 delta_t


class StickSlip(LabPage):
    """Friction of the interface between two flats over displacement, and its mean over stiffness."""

    TITLE = TITLE
    STATEMENT = (
        "Flat on flat at zero gap, with a rigid drive: nothing but shear. Paper: a strong or soft interface sticks and"
        " slips (Fig. 4a); a weak or stiff one slides continuously, almost without friction (Fig. 4b). Mean friction"
        " is ⟨F⟩ = (F_s + F_k)/2 (Eq. 7); over E/τₘₐₓ it falls on one curve (Fig. 5). Click the map to go there."
    )
    exact = param.Parameter(doc="(E/tau_max, mean friction over w tau_max) in closed form, of the layer")

    async def compute(self) -> None:
        own = flat(self.scene)
        if increments_of(own) > INCREMENTS:
            what = f"allowed here: {INCREMENTS} increments up to {END:g} nm"
            raise SceneError("du_x", own.du_x, what, "enlarge it")
        self.param.update(found={}, exact=await self.call(mean_friction, own))
        await self.run(flat_frames, [own, *PAPER.values(), *measured(own)])
        self.text = f"{in_words(own)} {self.text}"

    def content(self) -> list[Any]:
        ends = {"x_range": np.log10(MODULI).tolist(), "y_range": np.log10(STRENGTHS).tolist()}
        regimes = self.chart(self.boundary, "E (GPa)", "φₜ (N/m)", title="Mean friction of flats", **ends)
        plot, (left, right), (low, high) = regimes.object, *ends.values()
        plot.xaxis.ticker, plot.yaxis.ticker = [1, 2, 3], [-2, -1, 0]
        plot.grid.visible = False
        plot.axis.major_label_overrides = {k: f"{10.0**k:g}" for k in range(-2, 4)}
        look = {"color_mapper": LinearColorMapper("Cividis256", low=0.0, high=1.0), "level": "image"}
        image = plot.image([self.map()], x=left, y=low, dw=right - left, dh=high - low, **look)
        bar = image.construct_color_bar(title=MEAN, title_text_font_size=TEXT, major_label_text_font_size=TEXT)
        plot.add_layout(bar, "right")
        plot.hover.update(renderers=[image], tooltips=[(MEAN, "@image")])
        # Bokeh takes plain functions only here
        plot.on_event("tap", lambda event: pn.state.execute(on_loop(self.go_to, event.x, event.y), schedule=True))
        self._follow.append(lambda: image.data_source.data.update(image=[self.map()]))
        of = "displacement of the top Uₓ (nm)", "F/(w·70 GPa) (10⁻³)"
        forces = self.chart(self.forces, *of, title="Friction over displacement (Fig. 4)")
        means = self.chart(self.means, "E/τₘₐₓ", MEAN, title="Mean friction over stiffness (Fig. 5)", x_axis_type="log")
        return [side_by_side(forces, means, regimes)]

    def go_to(self, x: float, y: float) -> None:
        """Show the interface at a point of the map: logarithms of E and phi_t."""
        E, phi_t = np.clip(10.0**x, *MODULI), np.clip(10.0**y, *STRENGTHS)
        self.show(flat(self.scene).changed(E=float(f"{E:.3g}"), phi_ratio=float(f"{phi_t / self.scene.phi_n:.3g}")))

    def forces(self) -> list[Curve]:
        """Return F/(w 70 GPa) in 1e-3 over U_x of the runs in shear: increments, and where slips begin."""
        curves, scenes = [], {"this interface": flat(self.scene)} | PAPER
        for (label, scene), colour, dash in zip(scenes.items(), COLOURS, DASHES, strict=True):
            shear = [frame for frame in self.found.get(scene, ()) if frame.stage == "shear"]
            rows = [row for f in shear for row in (*((slip.load, slip.F_bar) for slip in f.slips), (f.U_x, f.F_bar))]
            U, F = np.array(rows).reshape(-1, 2).T
            curves.append(Curve(label, U, F * 1000.0 * scene.E / NORMAL, colour, dash))
        return curves

    def means(self) -> list[Curve]:
        """Return mean friction over w tau_max over E/tau_max: in closed form, of runs (Eq. 7), and of this scene."""
        own, runs, (ratios, means) = flat(self.scene), {}, self.exact or ([], [])
        for scene in measured(own):
            with suppress(KeyError, ValueError):  # it is not there yet, or has not slid far enough
                ratio = scene.E / tau_max(scene)
                runs[ratio] = friction_force(scene, self.found[scene]).mean * ratio
        known = bool(self.exact and own.phi_t > 0)
        at, smooth = np.array([own.E, critical_modulus(own)])[:, None] / tau_max(own) if known else np.empty((2, 0))
        mean = np.interp(np.log(at), np.log(ratios), means) if known else at
        return [
            Curve("closed form", ratios, means),
            Curve("sliding is smooth beyond", [*smooth, *smooth], [0.0, 1.0] * known, "gray", DASHES[1]),
            Curve("runs", [*runs], [*runs.values()], "gray", marker="circle", size=9.0),
            Curve("this scene", at, mean, ORANGE, marker="diamond", size=14.0),
        ]

    def boundary(self) -> list[Curve]:
        """Return the critical modulus over strength, left of which flats stick and slip, and this scene on the map."""
        strengths, unit, scene = np.array(STRENGTHS), unit_flat(self.scene), self.scene
        line = np.log10(critical_modulus(unit) / unit.phi_t * strengths), np.log10(strengths)
        E, phi_t = np.log10([[scene.E], [scene.phi_t]]) if scene.phi_t >= STRENGTHS[0] else np.empty((2, 0))
        return [Curve("", *line, "white", size=3.0), Curve("", E, phi_t, "white", marker="diamond", size=14.0)]

    def map(self) -> np.ndarray:
        """Return mean friction over w tau_max over the logarithms of E and phi_t."""
        unit, (ratios, means) = unit_flat(self.scene), self.exact or (np.ones(1), np.zeros(1))
        E, phi_t = (np.geomspace(*ends, 120) for ends in (MODULI, STRENGTHS))
        over = E / (phi_t[:, None] * tau_max(unit) / unit.phi_t)
        return np.interp(np.log(over), np.log(ratios), means, left=means[0], right=0.0)


def unit_flat(scene: Scene) -> Scene:
    """Return a flat on the layer of a scene, to whose strength tau_max and the critical modulus are proportional."""
    return flat(scene).changed(phi_n=2.0, phi_ratio=0.1)


def measured(own: Scene) -> list[Scene]:
    """Return scenes with the strength of `own` over a range of E/tau_max."""
    scenes, critical = [], critical_modulus(own)
    for E in np.geomspace(critical / 30.0, 3.0 * critical, MEASURED) if own.phi_t > 0 else ():
        with suppress(SceneError):
            scenes.append(sliding(own, E))
    return [scene for scene in scenes if increments_of(scene) <= INCREMENTS]


def in_words(own: Scene) -> str:
    """Return the regime of an interface between flats, and where it changes."""
    critical = critical_modulus(own)
    first = friction(own).F_s * own.E * own.shear_compliance
    regime = f"stick, and slip first at about Uₓ = {first:.0f} nm" if critical > own.E else "slide continuously"
    return (
        f"This interface (E = {own.E:g} GPa, φₜ = {own.phi_t:g} N/m) would {regime}. Sliding is continuous above"
        f" E = {critical:,.0f} GPa, where the stiffness of the layer (G/h) equals the softening of the interface"
        f" (max dT/dx). The mean of Eq. 7 is zero above {ZERO_MEAN:g} times this modulus."
    )


view = StickSlip.view
