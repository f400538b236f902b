"""Cautions: a sentence for every choice on which a result depends, for the page and the command line."""

import numpy as np

COARSE = 1.25  # a / delta_t, least: below, springs of neighbouring nodes overlap and smooth the lattice away
FAR = 4.0  # a / delta_t, most: above, a node moved sideways without friction leaves the reach of its spring
NEARLY_RIGID = 0.499  # nu: from here on the layer hardly moves sideways
WIDE = 0.6  # of w between the outermost nodes that act: the gap to the next punch is the smaller part
SOFT = 0.25  # phi_t/(E delta_t): above, GFMD's slips end elsewhere with another time step (E = 14, 10 at friction 2)
STRAIN = 0.1  # (|delta| + u_x_max) / h, a bound of the layer's mean strain
SLOPE = 0.1  # half that width over R, the slope of the punch where the contact ends


def cautions(scene, widest=0.0, safe_damping=0.0, sensitive=False) -> list[str]:
    """One sentence for every choice that shows in the result.

    widest: the largest width that acted, over w; safe_damping: the largest of the run's frames; sensitive: whether a
    slip of the run is.
    """
    sentences = []
    ratio = scene.spacing / scene.delta_t
    if ratio < COARSE:
        sentences.append(
            f"Node spacing a = {ratio:.2g} δₜ is below {COARSE:g} δₜ:"
            " the corrugation, hence the friction, is smoothed away."
        )
    if ratio > FAR and scene.nu < NEARLY_RIGID:
        sentences.append(
            f"Node spacing a = {ratio:.2g} δₜ is above {FAR:g} δₜ and ν = {scene.nu:g} below 0.5: pressed nodes move"
            " sideways, out of reach of their springs, and the contact grows too wide."
        )
    sentences += flutter(scene, safe_damping)
    if sensitive:
        sentences.append(
            "Which equilibrium a slip of this run reaches is sensitive: motions with other time steps or from another"
            " start came to rest elsewhere, so that later slips may differ as well."
        )
    softness = scene.phi_t / (scene.E * scene.delta_t)
    if softness > SOFT and scene.surface != "flat":
        sentences.append(
            f"The layer is soft against the friction, φₜ/(E δₜ) = {softness:.2g}, above {SOFT:g}: where single nodes"
            " come to rest after a slip may depend on the time step of the motion."
        )
    strain = (abs(scene.delta) + scene.u_x_max) / (scene.height * scene.width)
    if strain > STRAIN:
        sentences.append(
            f"The layer is strained by up to {100 * strain:.0f} %: beyond {100 * STRAIN:.0f} % it is no longer linear."
        )
    if scene.surface == "circular":
        sentences += _of_the_punch(scene, widest)
    elif scene.surface != "flat":
        sentences += _of_the_profile(scene)
    return sentences


def flutter(scene, safe_damping) -> list[str]:
    """[a sentence] where waves may flutter in frames whose short modes the solver does not check, else []."""
    if scene.damping >= safe_damping:
        return []
    return [
        f"Damping {scene.damping:g} is low for this contact: parts of it may flutter on where it is said to rest."
        f" From {safe_damping:.2g} on none can."
    ]


def _of_the_profile(scene):
    """[a sentence] where the surface is too steep for a theory of small slopes, else []."""
    steepest = float(np.abs(np.diff(scene.profile)).max()) / scene.spacing
    if steepest <= SLOPE:
        return []
    return [f"The surface is as steep as {steepest:.2g} in places: beyond {SLOPE:g} slopes are not small."]


def _of_the_punch(scene, widest):
    """Sentences on the width of the contact, which has no meaning on a flat surface."""
    sentences = []
    if widest > WIDE:
        sentences.append(
            f"The contact takes up to {100 * widest:.0f} % of the width w, more than {100 * WIDE:.0f} %:"
            " the punch feels its periodic neighbours."
        )
    slope = 0.5 * widest / scene.radius
    if slope > SLOPE:
        sentences.append(
            f"The punch is as steep as {slope:.2g} where the contact ends: beyond {SLOPE:g} slopes are not small."
        )
    return sentences
