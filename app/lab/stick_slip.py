"""The page "Stick-slip" (paper Figs. 4, 5, Eq. 7): friction of flat on flat at zero gap, from runs and in closed form.

from app.lab.stick_slip import view; view(Scene(E=140))
"""

from contextlib import suppress
from math import inf
from typing import Any

import holoviews as hv
import numpy as np
import panel as pn
import param

from app.lab.base import WIDE, LabPage
from app.limits import INCREMENTS, increments_of
from app.service import tasks
from app.service.jobs import jobs
from solver import Frame, Scene, SceneError
from solver.analysis.friction_laws import critical_modulus, friction, friction_force, tau_max
from solver.analysis.regimes import END, MODULI, STRENGTHS, flat, mean_friction, sliding
from solver.live_plots import curves, friction_map, mean_curve
from solver.presets import presets

TITLE = "Stick-slip"
NORMAL = 70.0  # GPa, over which forces are taken in the paper's Fig. 4
FLATS = {  # preset: label of its curve; E in GPa, phi_t in N/m
    "fig4a-blue": "Fig. 4a: E 70, φₜ 0.2",
    "fig4a-red": "Fig. 4a: 140, 0.2",
    "fig4a-green": "Fig. 4a: 70, 0.1",
    "fig4b-weak": "Fig. 4b: 70, 0.004",
    "fig4b-stiff": "Fig. 4b: 3000, 0.2",
}
OWN = "this interface"
EMPTY = dict.fromkeys([OWN, *FLATS.values()], ([], []))  # Bokeh needs all curves of a legend from the start
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
    forces = param.Dict(EMPTY, doc="{label: (U_x nm, F/(w 70 GPa) in 1e-3)}")
    means = param.Dict({}, doc="{E/tau_max: mean friction over w tau_max} of runs")
    exact = param.Parameter(doc="(E/tau_max, mean friction over w tau_max) in closed form, of the layer")

    async def compute(self) -> None:
        own = flat(self.scene)
        if increments_of(own) > INCREMENTS:
            what = f"allowed here: {INCREMENTS} increments up to {END:g} nm"
            raise SceneError("du_x", own.du_x, what, "enlarge it")
        self.means, self.forces = {}, dict(EMPTY)
        self.exact = await jobs.result(mean_friction, own, owner=id(self))
        shown = {OWN: own} | {label: flat(presets()[name].scene) for name, label in FLATS.items()}
        runs = [*shown.items(), *((None, scene) for scene in measured(own))]
        for done, (label, scene) in enumerate(runs):
            self.share = done / len(runs)
            frames = await jobs.result(tasks.flat_frames, scene, owner=id(self))
            if label:
                self.forces = self.forces | {label: force_curve(scene, frames)}
            else:
                with suppress(ValueError):  # it has not slid far enough
                    self.means = self.means | mean_of(scene, frames)
        self.text = in_words(own)

    def content(self) -> list[Any]:
        labels = "displacement of the top Uₓ (nm)", "F/(w·70 GPa) (10⁻³)"
        forces = hv.DynamicMap(pn.bind(lambda drawn: curves(drawn, *labels), self.param.forces))
        mean = hv.DynamicMap(pn.bind(mean_plot, self.param.exact, self.param.means, self.param.scene))
        regimes = hv.DynamicMap(pn.bind(map_plot, self.param.exact, self.param.scene))
        hv.streams.Tap(source=regimes).add_subscriber(self.go_to)
        return [pn.FlexBox(*(pn.pane.HoloViews(plot, styles=WIDE) for plot in (forces, mean, regimes)))]

    def go_to(self, x: float | None, y: float) -> None:
        """Show the interface at a point of the map: logarithms of E and phi_t."""
        if x is not None:
            E, phi_t = np.clip(10.0**x, *MODULI), np.clip(10.0**y, *STRENGTHS)
            self.show(flat(self.scene).changed(E=float(f"{E:.3g}"), phi_ratio=float(f"{phi_t / self.scene.phi_n:.3g}")))


def mean_plot(exact: Any, means: dict[float, float], scene: Scene) -> Any:
    """Return mean friction over stiffness, with that of the scene (Fig. 5)."""
    own, tau = flat(scene), tau_max(scene)
    return mean_curve(exact, means, own.E / tau if tau else inf, critical_modulus(own) / tau if tau else inf)


def map_plot(exact: Any, scene: Scene) -> Any:
    """Return the map of mean friction of flats on the layer of the scene."""
    unit = flat(scene).changed(phi_n=2.0, phi_ratio=0.1)
    slopes = tau_max(unit) / unit.phi_t, critical_modulus(unit) / unit.phi_t
    return friction_map(exact, scene, slopes, MODULI, STRENGTHS)


def measured(own: Scene) -> list[Scene]:
    """Return scenes with the strength of `own` over a range of E/tau_max."""
    scenes, critical = [], critical_modulus(own)
    for E in np.geomspace(critical / 30.0, 3.0 * critical, MEASURED) if own.phi_t > 0 else ():
        with suppress(SceneError):
            scenes.append(sliding(own, E))
    return [scene for scene in scenes if increments_of(scene) <= INCREMENTS]


def force_curve(scene: Scene, frames: list[Frame]) -> tuple[np.ndarray, np.ndarray]:
    """Return (U_x, F/(w 70 GPa) in 1e-3) of a run in shear: its increments, and where slips begin."""
    shear = [frame for frame in frames if frame.stage == "shear"]
    rows = [row for f in shear for row in (*((slip.load, slip.F_bar) for slip in f.slips), (f.U_x, f.F_bar))]
    U, F = np.array(rows).T
    return U, F * 1000.0 * scene.E / NORMAL


def mean_of(scene: Scene, frames: list[Frame]) -> dict[float, float]:
    """Return {E/tau_max: mean friction over w tau_max} of a run (Eq. 7)."""
    ratio = scene.E / tau_max(scene)
    return {ratio: friction_force(scene, frames).mean * ratio}


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


def view(scene: Scene | None = None) -> pn.viewable.Viewable:
    """Return the page for a Scene (default: the default Scene)."""
    return StickSlip(scene).view()
