"""The onset of sliding, and the paper's friction (Eq. 5, 7), from runs and, for flats, in closed form."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, e, inf, pi, sqrt

import numpy as np

from ..continuation.state import ROUND_OFF, NotConverged
from ..run.slices import first_slip
from ..scene import LARGEST_RUN, SceneError, refuse_other

# Paper Fig. 8: three interfaces, presets, over a range of loads from full separation under tension to compression. The
# paper shows nine loads and names some; the others are ours.
INTERFACES = "fig8-black", "fig8-red", "fig8-blue"
INDENTATIONS = (-0.3, -0.2, -0.15, -0.1, 0.0, 0.1, 0.2, 0.4, 0.6)
# points per lattice period of the flat interface's branches: the maximum of a sine lies between two of them, and is
# (pi/PLACES)^2/2 = 7e-8 above the higher one
PLACES = 8192


@dataclass(frozen=True)
class Onset:
    """A run in shear up to its first slip; U_s, F_s and A_s are None without a slip."""

    U_s: float | None  # nm
    F_s: float | None
    A_s: float | None
    A_0: float
    U: np.ndarray  # (k,) nm: the increments and, last, the end of the branch; U[0] = 0
    F: np.ndarray  # (k,) F_bar
    A: np.ndarray  # (k,) A_bar
    L: np.ndarray  # (k,) L_bar


def onset(scene, state=(None, ()), budget=inf, limit=inf) -> Onset | tuple:
    """The Onset of a scene, with u_x_max extended as needed, or the `state` after a slice; raises NotConverged.

    state: (Checkpoint, rows U_x, F_bar, A_bar, L_bar of the shear); budget, limit: as of `advance`. Without a slip, the
    run ends at its u_x_max, or farther: at the `reach` of the strength of its springs under pressure, as far as the
    scene allows.
    """
    least = max(scene.u_x_max, reach(scene))

    def beyond(frame):
        springs = float(np.exp(-frame.gap / scene.delta_n).sum()) / scene.nodes
        return frame.U_x >= max(least, reach(scene, tau_max(scene) * springs))  # the springs' mean strength there

    found, frames, checkpoint = first_slip(_longest(scene), state[0], budget, limit, beyond)
    slipping, at = found or (None, None)
    shear = [frame for frame in frames if frame.stage == "shear" and frame is not slipping]
    rows = [*state[1], *((frame.U_x, frame.F_bar, frame.A_bar, frame.L_bar) for frame in shear)]
    if at:
        return _onset([*rows, (at.load, at.F_bar, at.A_bar, at.L_bar)], True)
    if checkpoint.failure:
        raise NotConverged(checkpoint.failure, checkpoint.outcome)
    ended = checkpoint.done or (shear and beyond(shear[-1]))
    return _onset(rows, False) if ended else (checkpoint, rows)


def _onset(rows, slipped):
    U, F, A, L = np.array(rows).T.copy()
    end = (float(U[-1]), float(F[-1]), float(A[-1])) if slipped else (None, None, None)
    return Onset(*end, float(A[0]), U, F, A, L)


def reach(scene, strength=None) -> float:
    """U_x, nm, up to which `onset` searches for a slip: 2 (strength/k + 2 a), strength in GPa (tau_max if None).

    1/k = h/G + 1/k_t is the compliance of layer and drive. The reach is twice the way on which such a traction shears
    both, and moves the surface on by two lattice periods.
    """
    strength = tau_max(scene) if strength is None else strength
    return 2.0 * (strength * scene.shear_compliance + 2.0 * scene.spacing)


def _longest(scene):
    """The scene with the largest u_x_max that it allows, to a factor of two."""
    longest = 0.5 * LARGEST_RUN * scene.du_x * scene.delta_t
    while longest > scene.u_x_max:
        try:
            return scene.changed(u_x_max=longest, path="shear")
        except SceneError:  # on a soft layer, so long a run is beyond its tolerance
            longest *= 0.5
    return scene.changed(path="shear")


@dataclass(frozen=True)
class Friction:
    """Largest and least F_bar during sliding, and their mean, the friction force of Eq. 7."""

    F_s: float
    F_k: float

    @property
    def mean(self) -> float:
        """(F_s + F_k)/2, over w E."""
        return 0.5 * (self.F_s + self.F_k)


def friction_force(scene, frames) -> Friction:
    """The Friction of a run (Eq. 7), from its first slip on; without one, from one lattice period on.

    F_k is that of an increment in which a slip ended, at most du_x beyond its landing. Raises ValueError where the
    contact has not slid, or by less than a lattice period, SceneError for frames of another scene.
    """
    for frame in frames:
        refuse_other(scene, frame.scene, "run")
    shear = [f for f in frames if f.stage == "shear"]
    start = next((i for i, f in enumerate(shear) if f.slip), None)
    if start is None:
        start = next((i for i, f in enumerate(shear) if f.u[0].min() >= scene.spacing), None)
    if start is None:
        raise ValueError(f"the contact has not slid by U_x = {scene.u_x_max:g} nm: enlarge u_x_max")
    begin, seen = shear[start].slips[0].load if shear[start].slip else shear[start].U_x, shear[-1].U_x
    if seen - begin < (1.0 - ROUND_OFF) * scene.spacing:
        raise ValueError(
            f"sliding from U_x = {begin:.4g} to {seen:.4g} nm, less than a lattice period of {scene.spacing:.4g} nm:"
            f" enlarge u_x_max to {begin + scene.spacing + scene.du_x * scene.delta_t:.4g} nm"
        )
    F = [f.F_bar for f in shear[start:]] + [slip.F_bar for f in shear[start:] for slip in f.slips]
    return Friction(max(F), min(F))


def tau_max(scene) -> float:
    """Tangential strength of one spring at dn = 0, GPa (Eq. 5): phi_t / (delta_t sqrt(e/2))."""
    return scene.phi_t / (scene.delta_t * sqrt(0.5 * e))


# On a flat at delta_bar = 0, dn = 0 at all nodes: T_z = 0 and dT_z/du_x = 0 for any u_x. So the tangent is triangular,
# u_z is stable and does not affect the stability of u_x, and the following is exact.


@lru_cache(maxsize=16)
def _lattice(ratio):
    """(xi, pull, slope) over two periods of springs in registry at dn = 0, a/delta_t = ratio; read-only.

    xi = u_x/a; pull = -T_x in phi_t/delta_t; slope = its derivative in phi_t/delta_t^2. Poisson's sum of Eq. 2
    converges for every ratio: terms m beyond 2 a/delta_t are below round-off of the largest.
    """
    xi = np.arange(2 * PLACES + 1) / PLACES
    pull, slope = np.zeros(xi.size), np.zeros(xi.size)
    for m in range(1, ceil(2.0 * ratio) + 3):
        weight = 4.0 * pi**1.5 * m / ratio**2 * np.exp(-((pi * m / ratio) ** 2))
        pull += weight * np.sin(2.0 * pi * m * xi)
        slope += weight * 2.0 * pi * m / ratio * np.cos(2.0 * pi * m * xi)
    for array in (xi, pull, slope):
        array.flags.writeable = False
    return xi, pull, slope


def softening(scene) -> float:
    """max dT_x/du_x of the flat interface at dn = 0, GPa/nm; to 1e-6 of its value, by the grid."""
    return -float(_lattice(scene.spacing / scene.delta_t)[2].min()) * scene.phi_t / scene.delta_t**2


def critical_modulus(scene) -> float:
    """E_c, GPa, at which max dT_x/du_x = k: below it a flat contact sticks and slips, from it on it slides.

    1/k = h/G + 1/k_t (Prandtl 1928; Tomlinson 1929). With a rigid drive, E_c = 2 (1 + nu) h max dT_x/du_x is
    proportional to phi_t. It is inf where the drive alone is soft enough to stick and slip. Flat, delta_bar = 0.
    """
    _check_flat(scene)
    steepest = softening(scene)
    left = 1.0 - steepest * scene.drive_compliance[0]
    return 2.0 * (1.0 + scene.nu) * scene.height * scene.width * steepest / left if left > 0.0 else inf


def friction(scene, reference=None) -> Friction:
    """The exact Friction of a flat contact at delta_bar = 0 in steady sliding (Eq. 7), over `reference` GPa (else E).

    As U_x grows, the surface is at the least u ahead for which U(u) = u + pull(u)/k reaches U_x. A slip skips the u
    at which U(u) is below its maximum so far. Paper Fig. 4 uses reference = 70 throughout.
    """
    _check_flat(scene)
    xi, pull, _ = _lattice(scene.spacing / scene.delta_t)
    stress = pull * scene.phi_t / scene.delta_t
    load = xi * scene.spacing + stress * scene.shear_compliance
    top = np.maximum.accumulate(load)
    visited = load >= top
    first = 0 if visited.all() else int(np.argmin(visited)) - 1  # the first fold; everything repeats after a period
    period = slice(first, first + PLACES + 1)
    landed = np.flatnonzero(visited[1:] & ~visited[:-1])
    landed = landed[(landed >= first) & (landed < first + PLACES)]
    part = (top[landed] - load[landed]) / (load[landed + 1] - load[landed])
    at_landing = stress[landed] + part * (stress[landed + 1] - stress[landed])
    F = np.concatenate([stress[period][visited[period]], at_landing]) / (reference or scene.E)
    return Friction(float(F.max()), float(F.min()))


def _check_flat(scene):
    if scene.surface != "flat":
        raise SceneError("surface", scene.surface, "allowed: flat, which alone has a closed form", "run the scene")
    if scene.delta_bar != 0.0:
        raise SceneError("delta_bar", scene.delta_bar, "allowed: 0, where the closed form holds", "run the scene")
