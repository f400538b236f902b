"""Cautions: a sentence for every choice that affects a result, for the page and the command line."""

import numpy as np

from .mechanics.layer import Modes
from .mechanics.surface import too_soft
from .run.frame import largest_overlap, largest_safe_damping
from .run.summary import widest

FINEST = 1.25  # a / delta_t, least: below, springs of neighbouring nodes overlap and smooth the lattice away
COARSEST = 4.0  # a / delta_t, most: above, a node moved sideways without friction leaves the reach of its spring
# of w, the width within which nodes act. At 0.62 neighbours as near change A_0 by 2 % and F_s by 4 %, at 0.81 by 9 and
# 13 % (256 nodes of the default spacing, radius 2.5 w, against a cell twice as wide with the same punch and layer)
WIDE = 0.6
SOFT = 0.25  # phi_t/(E delta_t): above, GFMD's slips end elsewhere with another time step (E = 14, 10 at friction 2)
# (|delta| + u_x_max) / h less what the drive takes, a bound of the layer's mean strain: beyond, the quadratic term of
# Green's strain is over 5 %
STRAIN = 0.1
# of the surface, or of the punch where the contact ends: beyond, more than a tenth of the pressure acts along x
SLOPE = 0.1
SENSITIVE = (
    "Which equilibrium a slip of this run reaches is sensitive: motions with other time steps or from another"
    " start came to rest elsewhere, or a symmetric contact could move either way. Later slips may differ, too."
)


def cautions(scene, widest=0.0, safe_damping=0.0, sensitive=False, overlap=0.0) -> list[str]:
    """One sentence for every choice that affects the result.

    widest: the largest width within which nodes acted, over w; safe_damping: the largest of the run's frames;
    sensitive: whether a slip of the run is; overlap: the largest of the surfaces, over delta_n.
    """
    return [
        *_of_the_lattice(scene),
        *flutter(scene, safe_damping),
        *([SENSITIVE] if sensitive else []),
        *_of_the_law(scene, overlap),
        *_of_the_layer(scene),
        *_of_the_surface(scene, widest),
    ]


def cautions_of(scene, frames) -> list[str]:
    """The cautions of a run, from all its Frames."""
    sensitive = any(frame.sensitive for frame in frames)
    return cautions(scene, widest(frames), largest_safe_damping(frames), sensitive, largest_overlap(frames))


def _of_the_lattice(scene):
    ratio = scene.spacing / scene.delta_t
    if ratio < FINEST:
        yield (
            f"Node spacing a = {ratio:.2g} δₜ is below {FINEST:g} δₜ: the corrugation, and with it the friction, is"
            " smoothed away. Use fewer nodes, or a smaller δₜ."
        )
    # from nu = 0.499 on, pressure moves nodes sideways by 0.2 % of the way it presses them in
    if ratio > COARSEST and scene.nu < 0.499:
        yield (
            f"Node spacing a = {ratio:.2g} δₜ is above {COARSEST:g} δₜ and ν = {scene.nu:g} below 0.5: pressed nodes"
            " move sideways, out of reach of their springs, and the contact grows too wide. Use more nodes, or a larger"
            " δₜ."
        )


def flutter(scene, safe_damping) -> list[str]:
    """[a sentence] where short waves, which the solver does not check in every frame, may flutter; else []."""
    if scene.damping >= safe_damping:
        return []
    return [
        f"Damping {scene.damping:g} is low for this contact: parts of it may flutter where a frame shows"
        f" an equilibrium. Use {safe_damping:.2g} or more, at which none can."
    ]


def _of_the_law(scene, overlap):
    if scene.law == "xu-needleman" and overlap > 1.0:
        yield (
            f"The surfaces overlap by up to {overlap:.2g} δₙ. Beyond 1 δₙ the law of Xu and Needleman pushes sheared"
            " nodes on instead of back. Use law=np1, or a smaller delta_bar."
        )


def _of_the_layer(scene):
    softness = scene.phi_t / (scene.E * scene.delta_t)
    if softness > SOFT and scene.surface != "flat":
        yield (
            f"The layer is soft against the friction, φₜ/(E δₜ) = {softness:.2g}, above {SOFT:g}: the time step of the"
            " motion may decide where single nodes come to rest after a slip."
        )
    if stiffer := too_soft(scene):
        yield (
            "Where the approach begins, 10 δₙ above the surface, the attraction already draws so soft a layer into"
            f" contact: the run may find no state to begin from. {stiffer[0].upper()}{stiffer[1:]}."
        )
    h, k = scene.height * scene.width, Modes.of(scene).stiffness[:2, 0]  # of layer and drive; the layer's share:
    shares = 1.0 - k * scene.drive_compliance
    sheared, pressed = scene.farthest * shares[0], abs(scene.deepest) * shares[1]
    strain = (sheared + pressed) / h
    if strain > STRAIN:
        yield (
            f"The layer is strained by up to {100 * strain:.0f} %. Beyond {100 * STRAIN:.0f} % it is not linear:"
            f" {'shear less far' if sheared > pressed else 'press less deep'}, or use a higher layer."
        )


def _of_the_surface(scene, widest):
    """Sentences on slopes, and on the width of the contact, which has no meaning but for a punch."""
    if scene.surface != "circular":
        steepest = float(np.abs(np.diff(scene.profile)).max()) / scene.spacing
        if steepest > SLOPE:
            beyond = f"beyond {SLOPE:g} they are not small"
            yield f"The surface has slopes of up to {steepest:.2g}: {beyond}. Use a smoother one."
        return
    if widest > WIDE:
        yield (
            f"The contact and what it attracts take up to {100 * widest:.0f} % of the width w, more than"
            f" {100 * WIDE:.0f} %:"
            " the punch feels its periodic neighbours. Use a wider cell, or a smaller radius."
        )
    slope = 0.5 * widest / scene.radius
    if slope > SLOPE:
        yield (
            f"The punch has a slope of {slope:.2g} where the contact ends: beyond {SLOPE:g} slopes are not small."
            " Use a larger radius."
        )
