"""The paper's laws of friction and of the area's reduction (Eq. 5, 7-9), from runs and, on the flat, in closed form."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, e, pi, sqrt

import numpy as np

from .loadpath import load_path
from .scene import LARGEST_RUN, Scene, SceneError

# Paper Fig. 8: three interfaces, named as in the app's presets, over a range of loads from full separation under
# tension to compression. The paper shows nine loads and names some; the others are ours.
INTERFACES = {
    "fig8-black": {"phi_n": 2.0, "phi_ratio": 1.0},
    "fig8-red": {"phi_n": 1.0, "phi_ratio": 1.0},
    "fig8-blue": {"phi_n": 2.0, "phi_ratio": 0.1},
}
INDENTATIONS = (-0.3, -0.2, -0.15, -0.1, 0.0, 0.1, 0.2, 0.4, 0.6)
FINE = 8192  # points per lattice period of the flat interface's branches
EARLY, LATE = 0.5, 0.9  # of the largest F^2: the first half and the last tenth of a branch


@dataclass(frozen=True)
class QuadraticLaw:
    """A_bar = A_0 - zeta F_bar^2 (Eq. 8): the fit, and how far it holds."""

    A_0: float
    zeta: float
    zeta_error: float  # standard error
    r2: float  # of A_bar about its mean
    worst: float  # largest |deviation| over A_0
    last: float  # deviation at the last point over A_0; negative: less area than the law says
    rise: float  # -dA/d(F^2) in the last tenth of F^2 over that in the first half; 1 where the law holds
    points: int


def quadratic_law(F, A):
    """Least-squares fit of Eq. 8 to a branch from U_x = 0 on: forces F (k,), areas A (k,), the first is A_0.

    Uses the points in contact (A > 0). Raises ValueError with fewer than five of them, or where F does not grow.
    """
    F, A = np.asarray(F, float), np.asarray(A, float)
    F, A = F[A > 0.0], A[A > 0.0]
    if A.size < 5 or not np.ptp(F) > 0.0:
        raise ValueError(f"{A.size} points in contact: at least 5, at forces that differ; press deeper or shorten du_x")
    x = F**2
    zeta = float(x @ (A[0] - A) / (x @ x))
    deviation = A - (A[0] - zeta * x)
    squares = float(deviation @ deviation)
    spread = A - A.mean()
    return QuadraticLaw(
        A_0=float(A[0]),
        zeta=zeta,
        zeta_error=sqrt(squares / (A.size - 1) / float(x @ x)),
        r2=1.0 - squares / float(spread @ spread),
        worst=float(np.abs(deviation).max() / A[0]),
        last=float(deviation[-1] / A[0]),
        rise=_rise(x, A),
        points=A.size,
    )


def _rise(x, A):
    """Ratio of the late to the early rate -dA/dx, up to the largest x."""
    top = int(np.argmax(x)) + 1  # under tension the force passes a flat maximum before the slip
    x, A = x[:top], A[:top]
    half, late = (float(np.interp(part * x[-1], x, A)) for part in (EARLY, LATE))
    return float((late - A[-1]) / (1.0 - LATE) * EARLY / (A[0] - half))


@dataclass(frozen=True)
class ThresholdLaw:
    """F_s = tau_c A_s + F_nc (extended threshold law, Eq. 9; F_nc is the paper's F_s,nc) with standard errors."""

    tau_c: float
    tau_c_error: float
    F_nc: float
    F_nc_error: float
    r2: float
    points: int


def threshold_law(A_s, F_s):
    """Least-squares line through the points (A_s, F_s) with A_s > 0.

    Raises ValueError with fewer than three of them, or where all areas are the same.
    """
    A, F = np.asarray(A_s, float), np.asarray(F_s, float)
    A, F = A[A > 0.0], F[A > 0.0]
    if A.size < 3 or not np.ptp(A) > 0.0:
        raise ValueError(f"{A.size} points in contact at the onset: at least 3, of different area; press deeper")
    from_mean, forces = A - A.mean(), F - F.mean()
    spread = float(from_mean @ from_mean)
    tau_c = float(from_mean @ forces) / spread
    F_nc = float(F.mean() - tau_c * A.mean())
    squares = float(np.sum((F - F_nc - tau_c * A) ** 2))
    variance = squares / (A.size - 2)
    return ThresholdLaw(
        tau_c=tau_c,
        tau_c_error=sqrt(variance / spread),
        F_nc=F_nc,
        F_nc_error=sqrt(variance * (1.0 / A.size + A.mean() ** 2 / spread)),
        r2=1.0 - squares / float(forces @ forces),
        points=A.size,
    )


@dataclass(frozen=True)
class Onset:
    """A run in shear up to its first slip; the three at the slip are None where the contact never slips."""

    U_s: float | None  # nm
    F_s: float | None
    A_s: float | None
    A_0: float
    U: np.ndarray  # (k,) nm: the increments and, last, the end of the branch; U[0] = 0
    F: np.ndarray  # (k,) F_bar
    A: np.ndarray  # (k,) A_bar
    L: np.ndarray  # (k,) L_bar
    A_nodes: float  # A_bar of the last increment before the slip, nodes counted rather than edges interpolated


def onset(scene):
    """The Onset of a scene, u_x_max extended as needed up to `reach`; raises NotConverged as load_path does."""
    rows, nodes, slipped = [], 0, False
    for frame in load_path(_extended(scene)):
        if frame.stage != "shear":
            continue
        slipped = frame.slip
        if slipped:
            first = frame.slips[0]
            rows.append((first.load, first.F_bar, first.A_bar, first.L_bar))
            break
        rows.append((frame.U_x, frame.F_bar, frame.A_bar, frame.L_bar))
        nodes = np.count_nonzero(frame.T[1] > 0.0)
    U, F, A, L = np.array(rows).T.copy()
    end = (float(U[-1]), float(F[-1]), float(A[-1])) if slipped else (None, None, None)
    return Onset(*end, float(A[0]), U, F, A, L, float(nodes / scene.nodes))


def reach(scene):
    """U_x, nm, up to which `onset` looks for a slip: 2 (tau_max h/G + 2 a).

    Twice what shears the layer by the strength of Eq. 5 over its whole width and moves it on by two lattice periods.
    """
    return 2.0 * (tau_max(scene) * scene.height * scene.width / scene.shear_modulus + 2.0 * scene.spacing)


def _extended(scene):
    longest = min(max(scene.u_x_max, reach(scene)), LARGEST_RUN * scene.du_x * scene.delta_t)
    try:
        return scene.changed(u_x_max=longest, path="shear")
    except SceneError:  # so long a run of so soft a layer is beyond its tolerance: as far as the scene goes
        return scene.changed(path="shear")


def figure_8():
    """[(name of the interface, Scene)] of the 27 runs of paper Fig. 8."""
    return [
        (name, Scene(delta_bar=delta_bar, **values))
        for name, values in INTERFACES.items()
        for delta_bar in INDENTATIONS
    ]


@dataclass(frozen=True)
class Friction:
    """Largest and least F_bar during sliding, and their mean, the friction force of Eq. 7."""

    F_s: float
    F_k: float

    @property
    def mean(self):
        return 0.5 * (self.F_s + self.F_k)


def friction_force(scene, frames):
    """The Friction of a run (Eq. 7), from its first slip on; without one, from one lattice period on.

    F_k is that of the increment in which a slip ended, so at most du_x beyond it. Raises ValueError where the
    contact has not slid.
    """
    shear = [f for f in frames if f.stage == "shear"]
    start = next((i for i, f in enumerate(shear) if f.slip), None)
    if start is None:
        start = next((i for i, f in enumerate(shear) if f.u[0].min() >= scene.spacing), None)
    if start is None:
        raise ValueError(f"the contact has not slid by U_x = {scene.u_x_max:g} nm: enlarge u_x_max")
    F = [f.F_bar for f in shear[start:]] + [slip.F_bar for f in shear[start:] for slip in f.slips]
    return Friction(max(F), min(F))


def tau_max(scene):
    """Tangential strength of one spring at dn = 0, GPa (Eq. 5): phi_t / (delta_t sqrt(e/2))."""
    return scene.phi_t / (scene.delta_t * sqrt(0.5 * e))


# On the flat at delta_bar = 0, dn = 0 all over: T_z = 0 and dT_z/du_x = 0 whatever u_x, so that the tangent is
# triangular and u_z, always stable there, has no part in the stability of u_x. What follows is therefore exact.


@lru_cache(maxsize=16)
def _lattice(ratio):
    """(xi, pull, slope) over two periods of springs in registry at dn = 0, a/delta_t = ratio; read-only.

    xi = u_x/a; pull = -T_x in phi_t/delta_t; slope = its derivative in phi_t/delta_t^2. Poisson's sum of Eq. 2
    converges for every ratio: terms m beyond 2 a/delta_t are below round-off of the largest.
    """
    xi = np.arange(2 * FINE + 1) / FINE
    pull, slope = np.zeros(xi.size), np.zeros(xi.size)
    for m in range(1, ceil(2.0 * ratio) + 3):
        weight = 4.0 * pi**1.5 * m / ratio**2 * np.exp(-((pi * m / ratio) ** 2))
        pull += weight * np.sin(2.0 * pi * m * xi)
        slope += weight * 2.0 * pi * m / ratio * np.cos(2.0 * pi * m * xi)
    for array in (xi, pull, slope):
        array.flags.writeable = False
    return xi, pull, slope


def softening(scene):
    """max dT_x/du_x of the flat interface at dn = 0, GPa/nm; to 1e-6 of its value, by the grid."""
    return -float(_lattice(scene.spacing / scene.delta_t)[2].min()) * scene.phi_t / scene.delta_t**2


def critical_modulus(scene):
    """E_c, GPa, at which max dT_x/du_x = G/h: below it a flat contact sticks and slips, from it on it slides.

    E_c = 2 (1 + nu) h max dT_x/du_x, proportional to phi_t (Prandtl 1928; Tomlinson 1929). Flat, delta_bar = 0.
    """
    _check_flat(scene)
    return 2.0 * (1.0 + scene.nu) * scene.height * scene.width * softening(scene)


def regime(scene):
    """'stick-slip' or 'continuous sliding' of a flat contact at delta_bar = 0."""
    return "stick-slip" if critical_modulus(scene) > scene.E else "continuous sliding"


def friction(scene, reference=None):
    """The exact Friction of a flat contact at delta_bar = 0 in steady sliding (Eq. 7), over `reference` GPa (else E).

    As U_x grows, the surface rests at the least u ahead for which U(u) = u + pull(u) h/G reaches U_x: a slip leaps
    over the u at which U(u) is below its maximum so far. Paper Fig. 4 has reference = 70 throughout.
    """
    _check_flat(scene)
    xi, pull, _ = _lattice(scene.spacing / scene.delta_t)
    stress = pull * scene.phi_t / scene.delta_t
    load = xi * scene.spacing + stress * scene.height * scene.width / scene.shear_modulus
    top = np.maximum.accumulate(load)
    visited = load >= top
    first = 0 if visited.all() else int(np.argmin(visited)) - 1  # the first fold; a period on, the same again
    period = slice(first, first + FINE + 1)
    landed = np.flatnonzero(visited[1:] & ~visited[:-1])
    landed = landed[(landed >= first) & (landed < first + FINE)]
    part = (top[landed] - load[landed]) / (load[landed + 1] - load[landed])
    at_landing = stress[landed] + part * (stress[landed + 1] - stress[landed])
    F = np.concatenate([stress[period][visited[period]], at_landing]) / (reference or scene.E)
    return Friction(float(F.max()), float(F.min()))


def _check_flat(scene):
    if scene.surface != "flat":
        raise SceneError("surface", scene.surface, "allowed: flat, which alone has a closed form", "run the scene")
    if scene.delta_bar != 0.0:
        raise SceneError("delta_bar", scene.delta_bar, "allowed: 0, where the closed form holds", "run the scene")
