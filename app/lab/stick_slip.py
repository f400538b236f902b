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

from app.lab.base import LabPage, plots
from app.limits import INCREMENTS, increments_of
from app.service import tasks
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
PAPER = {label: flat(presets()[name].scene) for name, label in FLATS.items()}
AXES = "displacement of the top Uₓ (nm)", "F/(w·70 GPa) (10⁻³)"
MEASURED = 9  # runs to compare with the closed form
ZERO_MEAN = 0.73  # of the critical modulus, a = 2.44 delta_t
Found = dict[Scene, list[Frame]]


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
        self.found = {}
        self.exact = await self.call(mean_friction, own)
        await self.run(tasks.flat_frames, [own, *PAPER.values(), *measured(own)])
        self.text = f"{in_words(own)} {self.text}"

    def content(self) -> list[Any]:
        given = self.param.found, self.param.scene
        forces = pn.bind(lambda found, scene: curves(force_curves(found, scene), *AXES), *given)
        mean = pn.bind(mean_plot, self.param.exact, *given)
        regimes = hv.DynamicMap(pn.bind(map_plot, self.param.exact, self.param.scene))
        hv.streams.Tap(source=regimes).add_subscriber(self.go_to)
        return [plots(forces, mean, regimes)]

    def go_to(self, x: float | None, y: float) -> None:
        """Show the interface at a point of the map: logarithms of E and phi_t."""
        if x is not None:
            E, phi_t = np.clip(10.0**x, *MODULI), np.clip(10.0**y, *STRENGTHS)
            self.show(flat(self.scene).changed(E=float(f"{E:.3g}"), phi_ratio=float(f"{phi_t / self.scene.phi_n:.3g}")))


def measured(own: Scene) -> list[Scene]:
    """Return scenes with the strength of `own` over a range of E/tau_max."""
    scenes, critical = [], critical_modulus(own)
    for E in np.geomspace(critical / 30.0, 3.0 * critical, MEASURED) if own.phi_t > 0 else ():
        with suppress(SceneError):
            scenes.append(sliding(own, E))
    return [scene for scene in scenes if increments_of(scene) <= INCREMENTS]


def force_curves(found: Found, scene: Scene) -> dict[str, tuple[Any, Any]]:
    """Return {label: (U_x nm, F/(w 70 GPa) in 1e-3)} of the runs in shear: increments, and where slips begin."""
    drawn = {}
    for label, flats in ({"this interface": flat(scene)} | PAPER).items():
        shear = [frame for frame in found.get(flats, ()) if frame.stage == "shear"]
        rows = [row for f in shear for row in (*((slip.load, slip.F_bar) for slip in f.slips), (f.U_x, f.F_bar))]
        U, F = np.array(rows).reshape(-1, 2).T  # Bokeh needs all curves of a legend from the start
        drawn[label] = U, F * 1000.0 * flats.E / NORMAL
    return drawn


def means(found: Found, own: Scene) -> dict[float, float]:
    """Return {E/tau_max: mean friction over w tau_max} of the runs of `measured` (Eq. 7)."""
    values = {}
    for scene in measured(own):
        ratio = scene.E / tau_max(scene)
        with suppress(KeyError, ValueError):  # it is not there yet, or has not slid far enough
            values[ratio] = friction_force(scene, found[scene]).mean * ratio
    return values


def mean_plot(exact: Any, found: Found, scene: Scene) -> Any:
    """Return mean friction over stiffness, with that of the scene (Fig. 5)."""
    own, tau = flat(scene), tau_max(scene)
    ends = (own.E / tau, critical_modulus(own) / tau) if tau else (inf, inf)
    return mean_curve(exact, means(found, own), *ends)


def map_plot(exact: Any, scene: Scene) -> Any:
    """Return the map of mean friction of flats on the layer of the scene."""
    unit = flat(scene).changed(phi_n=2.0, phi_ratio=0.1)
    slopes = tau_max(unit) / unit.phi_t, critical_modulus(unit) / unit.phi_t
    return friction_map(exact, scene, slopes, MODULI, STRENGTHS)


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
