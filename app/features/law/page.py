"""The page "Interface law" (paper Fig. 3, Eq. 4): the traction on a node, summed over the lattice, and all nodes on it.

The browser has the law and the frames, and draws both (page.js). The slip distance s is that of a node from the nearest
lattice site; the law is periodic in s with the node spacing a. It factors:
T_t = phi_t/delta_t S1(s) g(gap/delta_n), T_n = -phi_n/delta_n S0(s) (gap/delta_n) exp(-gap/delta_n).
NP1 has g(x) = exp(-x), the law of Xu & Needleman (1 + x) exp(-x). The toughness of the interface over the mode angle is
that of single springs (`solver.toughness`); the browser reads J and psi of both edges from the increment shown.
"""

from functools import partial

import numpy as np

from app.features.law import tasks
from app.features.pages.sheet import Sheet
from solver.mechanics.cohesive_law import law_constants

TITLE, ORDER = "Interface law", 1
PARAMETERS = ("law", "phi_n", "phi_ratio", "delta_n", "delta_t", "spacing")  # of the interface law
ANGLES = tuple(float(angle) for angle in range(0, 81, 10))  # degrees, at which the toughness is computed
COMPARED = (  # (toughness at 45 degrees over phi_n, words for less); within 2 % shear and opening count as alike
    (0.98, "weaker than opened: its edges peel sooner"),
    (1.02, "as tough as opened"),
    (np.inf, "tougher than opened: its edges peel later"),
)


class Page(Sheet):
    """The page of one visitor; see app/features/pages. `drawn`: the PARAMETERS of the law that is drawn."""

    drawn = None

    def scene_changed(self) -> None:
        """Draw the law of the scene, unless it is the one that is drawn."""
        scene = self.session.scene
        law = [getattr(scene, name) for name in PARAMETERS]
        if law == self.drawn:
            return
        self.drawn = law
        self.single.cancel()
        drawn = {"constants": law_constants(scene).tolist(), "phi_n": scene.phi_n, "toughness": None}
        self.publish(law=drawn, texts={"law-numbers": _numbers(scene), "law-toughness-text": ""})
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
        toughness = [scene.phi_n * gamma for gamma in found]
        self.publish(law=self.published["law"] | {"toughness": {"angle": ANGLES, "value": toughness}})
        sheared = float(np.interp(45.0, ANGLES, found))
        text = next(words for limit, words in COMPARED if sheared < limit)
        text = f"Sheared, this interface is {text} (toughness {sheared:.2f} φₙ at 45°)."
        return self._say(text)


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
