"""The page "Interface law" (paper Fig. 3, Eq. 4): the traction on a node, summed over the lattice, and all nodes on it.

The server draws the law once per scene; the browser has the frames and draws the nodes (page.js). The slip distance s
is that of a node from the nearest lattice site; the law is periodic in s with the node spacing a. It factors:
T_t = phi_t/delta_t S1(s) g(gap/delta_n), T_n = -phi_n/delta_n S0(s) (gap/delta_n) exp(-gap/delta_n).
NP1 has g(x) = exp(-x), the law of Xu & Needleman (1 + x) exp(-x). The toughness of the interface over the mode angle is
that of single springs (`solver.toughness`); the browser reads J and psi of both edges from the increment shown.
"""

from functools import partial
from typing import Any

import numpy as np
from bokeh.models.glyphs import Line, Scatter

from app.pages import Sheet
from app.schema import EDGES, RIDERS
from app.service import tasks
from app.views.plots import add_zero, blank, draw, draw_image
from solver.mechanics import cohesive_law

TITLE, ORDER = "Interface law", 1
FIGURES = "shear_map", "normal_map", "shear_law", "normal_law", "toughness"
OFFSET, GAP = "slip distance from the nearest site (nm)", "gap (nm)"
FINE = 160  # pixels of a map, and steps of a curve, along an axis
LOWEST, HIGHEST = -1.0, 6.0  # range of gaps, in delta_n
PARAMETERS = ("law", "phi_n", "phi_ratio", "delta_n", "delta_t", "spacing")  # of the interface law
ANGLES = tuple(float(angle) for angle in range(0, 81, 10))  # degrees, at which the toughness is computed
COMPARED = (  # (toughness at 45 degrees over phi_n, words for less); within 2 % shear and opening count as alike
    (0.98, "weaker than opened: its edges peel sooner"),
    (1.02, "as tough as opened"),
    (np.inf, "tougher than opened: its edges peel later"),
)


def _riders(plot, x, y):
    for label, node in RIDERS.items():
        draw(plot, Scatter, label, node.colour, x, y, marker=node.marker, size=node.size)
    return plot


def _map(name, symbol):
    """Return the map of a traction over slip distance and gap, with the nodes."""
    plot = blank(name, OFFSET, GAP)
    draw_image(plot, "map", [("s", "$x{0.00} nm"), ("gap", "$y{0.00} nm"), (symbol, "@image{0.000} GPa")])
    return _riders(plot, "s", "gap")


def _law(plot, x):
    """Return the curve of a factor of the law over column x, that of a single spring, and the nodes."""
    add_zero(plot)
    draw(plot, Line, "spring", "--soft", x, "value", line_width=2, line_dash="dotted")
    draw(plot, Line, "law", "--text", x, "value", line_width=2)
    return _riders(plot, x, "value")


def compose() -> list[Any]:
    return [
        _map("law_shear_map", "Tₜ"),
        _map("law_normal_map", "Tₙ"),
        _law(blank("law_shear_law", OFFSET, "Tₜ exp(gap/δₙ) δₜ/φₜ", y=(-1.1, 1.1)), "s"),
        _law(blank("law_normal_law", GAP, "Tₙ δₙ/(φₙ Σ)", y=(-0.6, 1.2)), "gap"),
        _toughness(),
    ]


def _toughness():
    """Return the toughness over the mode angle, Griffith's constant one, and the two edges of the contact."""
    plot = blank("law_toughness", "mode angle ψ: opening 0°, shear 90° (°)", "Γ and J (N/m)", x=(0.0, 80.0))
    draw(plot, Line, "griffith", "--soft", "angle", "value", line_width=2, line_dash="dotted")
    draw(plot, Line, "gamma", "--text", "angle", "value", line_width=2)
    for label, edge in EDGES.items():
        draw(plot, Scatter, label, edge.colour, "angle", "value", marker=edge.marker, size=edge.size)
    return plot


class Page(Sheet):
    """The page of one visitor; see app/pages. `drawn`: the PARAMETERS of the law that is drawn."""

    drawn = None

    def scene_changed(self) -> None:
        """Draw the law of the scene, unless it is the one that is drawn."""
        scene = self.session.scene
        law = [getattr(scene, name) for name in PARAMETERS]
        if law == self.drawn:
            return
        self.drawn = law
        a, d_n, d_t = scene.spacing, scene.delta_n, scene.delta_t
        s, gap = np.linspace(-0.5 * a, 0.5 * a, FINE + 1), np.linspace(LOWEST * d_n, HIGHEST * d_n, FINE + 1)
        middles = [0.5 * (edges[1:] + edges[:-1]) for edges in (s, gap)]  # centres of pixels: T_t is 0 at the borders
        shear, normal = cohesive_law.traction(scene, *np.meshgrid(*middles))
        shear = -shear  # as in the bands below the punch, traction against the motion is positive
        limits = {}
        for slot, field in (("shear_map", shear), ("normal_map", normal)):
            place = {"x": [s[0]], "y": [gap[0]], "dw": [s[-1] - s[0]], "dh": [gap[-1] - gap[0]]}
            self.draw(slot, "map", image=[field.astype(np.float32)], **place)
            limits[f"law_{slot}.map"] = [min(float(field.min()), -1e-9), max(float(field.max()), 1e-9)]
        ahead = cohesive_law.traction(scene.changed(phi_ratio=1.0), s, 0.0)
        rise = -ahead[0] * d_t / scene.phi_n
        self.draw("shear_law", "law", s=s, value=rise)
        self.draw("shear_law", "spring", s=s, value=2.0 * (s / d_t) * np.exp(-((s / d_t) ** 2)))
        force = -gap / d_n * np.exp(-gap / d_n)
        self.draw("normal_law", "law", gap=gap, value=force)
        self._fit(scene, float(np.abs(rise).max()))
        peak = float(abs(s[np.argmax(rise)]))
        self.publish(
            images=limits,
            law={"spacing": a, "peak": peak, "opening": cohesive_law.OPENING[scene.law]},
            texts={"law-numbers": _numbers(scene), "law-toughness-text": ""},
        )
        self._draw_toughness(scene)

    def _draw_toughness(self, scene):
        """Request the toughness of the interface from a worker; without a resistance to shear there is none."""
        self.draw("toughness", "gamma", angle=[], value=[])
        self.draw("toughness", "griffith", angle=[ANGLES[0], ANGLES[-1]], value=2 * [scene.phi_n])
        self.views["toughness"].figure.y_range.update(start=0.0, end=1.5 * scene.phi_n)
        self.single.cancel()
        if scene.phi_ratio == 0.0:
            return self._say("Without friction the edges peel by opening alone.")
        call = tasks.relative_toughness, scene.law, scene.phi_ratio, scene.delta_t / scene.delta_n, ANGLES
        return self.single.ask(call, partial(self._take_toughness, scene))

    def _say(self, text):
        """Show a sentence below the toughness."""
        self.publish(texts=self.published.get("texts", {}) | {"law-toughness-text": text})

    def _take_toughness(self, scene, found):
        if found is None:
            return self._say("The toughness was not found; change a parameter.")
        gamma = scene.phi_n * np.asarray(found)
        self.draw("toughness", "gamma", angle=ANGLES, value=gamma)
        self.views["toughness"].figure.y_range.update(start=0.0, end=1.15 * max(float(gamma.max()), scene.phi_n))
        sheared = float(np.interp(45.0, ANGLES, found))
        text = next(words for limit, words in COMPARED if sheared < limit)
        text = f"Sheared, this interface is {text} (toughness {sheared:.2f} φₙ at 45°)."
        return self._say(text)

    def _fit(self, scene, largest):
        half, d_n = 0.5 * scene.spacing, scene.delta_n
        for slot, view in self.views.items():
            if slot == "toughness":
                continue
            across = (LOWEST * d_n, HIGHEST * d_n) if slot == "normal_law" else (-half, half)
            view.figure.x_range.update(start=across[0], end=across[1])
            if slot.endswith("_map"):
                view.figure.y_range.update(start=LOWEST * d_n, end=HIGHEST * d_n)
        largest = max(largest, 0.86)
        self.views["shear_law"].figure.y_range.update(start=-1.15 * largest, end=1.15 * largest)


TEXTS = {
    "np1": "With NP1 the resistance to shear grows where the surfaces overlap (gap < 0).",
    "xu-needleman": (
        "With this law the resistance to shear falls where the surfaces overlap (gap < 0), and changes sign below −δₙ:"
        " a deeper contact would slide more easily. Therefore the paper uses NP1."
    ),
}


def _numbers(scene):
    sigma = scene.phi_n / scene.delta_n / np.e
    tau = scene.phi_t / scene.delta_t * np.sqrt(2.0 / np.e)
    return (
        f"One spring (Eq. 5): σₘₐₓ = φₙ/(e δₙ) = {sigma:.3g} GPa, τₘₐₓ = √(2/e) φₜ/δₜ = {tau:.3g} GPa at zero gap."
        f" All sites within range act on a node; their spacing is a = {scene.spacing / scene.delta_t:.3g} δₜ."
        f" {TEXTS[scene.law]}"
    )
