"""Closed forms to hold runs against: Maugis and Griffith for a circular punch, Prandtl-Tomlinson for a flat.

None of them uses a run. They leave out the coupling of normal and shear in the layer, as for nu = 1/2. Sources: Maugis
(1992), Baney & Hui (1997) for cylinders; Savkoor & Briggs (1977) for Griffith's balance under shear; Prandtl (1928),
Tomlinson (1929).
"""

from math import e, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root
from scipy.special import j0, j1

from solver.analysis.toughness import toughness
from solver.mechanics.layer import Modes
from solver.run.load_steps import lifts
from solver.scene import Scene

ANGLES = np.radians(range(0, 81, 10))  # mode angles at which the toughness is computed
DRAWN = 200  # of a curve
M = np.arange(1, 60)[:, None]  # harmonics of the sum over sites: exact to round-off for any spacing in range


class Theory(NamedTuple):
    """A closed form as a curve of `of`, "A" (nm) or "F" (N/m), over `along`, "delta" or "U_x" (nm)."""

    name: str
    of: str
    along: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    limit: str  # a sentence: where it ceases to hold


def theory(scene: Scene) -> tuple[Theory, ...]:
    """The closed forms that apply to a scene: none for wavy, rough and measured surfaces.

    A circular punch has its contact area over the indentation at U_x = 0 (Maugis), if Maugis' number is 0.8 and more
    and nu 0.25 and more, and over U_x up to the first slip (Griffith). A flat has F over U_x (Prandtl-Tomlinson).

    Parameters: scene.
    Returns a Theory for each: its name, its curve, and a sentence on where it ceases to hold.
    Raises ValueError where `toughness` finds no crack tip, at extreme phi_ratio.

    Example: `theory(Scene(surface="flat"))[0].y.max()`
    """
    slides = scene.phi_t > 0.0 and not lifts(scene) and not scene.legs
    if scene.surface == "flat":
        return _flat(scene) if slides and scene.hold == "delta" else ()
    # at nu = 0 the coupling that is left out makes the area of a soft punch 9 % smaller
    return _punch(scene, slides) if scene.surface == "circular" and scene.nu >= 0.25 else ()


def _zero(f, low, high, *given):
    """The zeros of increasing f(x, *given), arrays of one shape, between low and high; high where there is none."""
    found = find_root(f, (low, high), args=given)
    return np.where(found.success, found.x, high)


def _flat(scene):
    """F = w f(u), U_x = u + (h/G + 1/k_t) f(u), where f is the shear traction of a node displaced by u."""
    u = np.linspace(0.0, max(scene.u_x_max, scene.spacing), DRAWN * (1 + int(scene.u_x_max / scene.spacing)))
    f, n = _node(scene, u)
    if n.max() > 1.0 - 1e-6 or f[1] < 0.0:
        return ()  # apart by delta_n, waves of the surface grow; overlapping, Xu-Needleman repels nodes from sites
    U_x = u + scene.shear_compliance * f
    falls = np.flatnonzero(np.diff(U_x) < 0.0)
    if not falls.size:
        limit = "It holds everywhere, as nothing slips."
        return (Theory("Prandtl–Tomlinson", "F", "U_x", U_x, scene.width * f, limit),)
    u = u[falls[0] + 1] * (1.0 - np.linspace(1.0, 0.0, DRAWN) ** 2)  # closer together towards the slip
    f, _ = _node(scene, u)
    U_x = u + scene.shear_compliance * f
    upto = slice(int(np.argmax(U_x)) + 1)
    U_x, F = U_x[upto], scene.width * f[upto]
    limit = f"It ends at the first slip, at Uₓ = {U_x[-1]:.2f} nm with F = {F[-1]:.3g} N/m."
    return (Theory("Prandtl–Tomlinson", "F", "U_x", U_x, F, limit),)


def _node(scene, u):
    """(shear traction f (GPa), gap/delta_n) of a node displaced by u: sums over sites by Poisson's formula."""
    a, C_n = scene.spacing, float(Modes.of(scene).compliance[1, 0])
    weight, wave = np.exp(-((pi * M * scene.delta_t / a) ** 2)), 2.0 * pi * M / a
    springs = pi**0.5 * scene.delta_t / a * (1.0 + 2.0 * (weight * np.cos(wave * u)).sum(axis=0))
    sheared = 4.0 * pi**1.5 * scene.phi_t * scene.delta_t / a**2 * (M * weight * np.sin(wave * u)).sum(axis=0)
    depth, pull = scene.delta / scene.delta_n, C_n * scene.phi_n / scene.delta_n**2 * springs
    low, high = np.full(u.shape, -max(depth, 0.0)), np.ones(u.shape)
    n = _zero(lambda n, pull: n + depth + pull * n * np.exp(-n), low, high, pull)
    return sheared * np.exp(-n) * (1.0 + n if scene.law == "xu-needleman" else 1.0), n


class _Contact(NamedTuple):
    """A punch, and the displacements of strips of half-widths t against the stage; arrays are (DRAWN,).

    round: indentation (nm) under the pressure E*/(2R) sqrt(t^2 - x^2) of Hertz; flat, sheared: indentation and U_x over
    the force (nm m/N) of a bonded strip, whose traction is 1/(pi sqrt(t^2 - x^2)).
    """

    E: float  # E*, GPa
    R: float  # nm
    springs: float  # sum of exp(-dt^2/delta_t^2) over the sites of a node
    t: NDArray[np.float64]  # nm
    round: NDArray[np.float64]
    flat: NDArray[np.float64]
    sheared: NDArray[np.float64]

    @staticmethod
    def of(scene):
        """That of a Scene with a circular punch."""
        E, R, C = scene.E / (1.0 - scene.nu**2), scene.radius * scene.width, Modes.of(scene).compliance / scene.width
        springs = float(np.exp(-((np.arange(-200, 201) * scene.spacing / scene.delta_t) ** 2)).sum())
        t, q = np.geomspace(1e-3, 0.3, DRAWN) * scene.width, 2.0 * pi * np.arange(1, C.shape[1]) / scene.width
        tq = np.outer(t, q)
        strip, hertz = 2.0 * j0(tq), 2.0 * j1(tq) / tq
        round = pi * E * t**2 / (2.0 * R) * (0.5 * C[1, 0] + hertz @ C[1, 1:])
        return _Contact(E, R, springs, t, round, C[1, 0] + strip @ C[1, 1:], C[0, 0] + strip @ C[0, 1:])


def _punch(scene, slides):
    """Maugis' area over the indentation, and Griffith's over U_x."""
    contact = _Contact.of(scene)
    gamma = scene.phi_n * contact.springs
    pull = gamma / (e * scene.delta_n)
    number = 4.0 * pull / (pi**2 * contact.E**2 * gamma / contact.R) ** (1.0 / 3.0)
    # largest half-width of a contact over the width of the cell and over the height of the layer
    delta, A, P = _maugis(contact, gamma, pull, number, 0.2 * scene.width * min(1.0, scene.height))
    # Maugis' number: at 0.5 the area is 6 % off, as the tail of NP1 bears a part of the load
    if number < 0.8 or not delta.size:
        return ()
    limit = f"It holds without shear, once the surfaces have jumped together; better the larger λ, here {number:.2g}."
    found = [Theory("Maugis", "A", "delta", delta, A, limit)]
    # a node then feels mostly one site, as `toughness` supposes
    if slides and delta[0] < scene.delta < delta[-1] and scene.spacing >= 2.0 * scene.delta_t:
        load = float(np.interp(scene.delta, delta, P)) if scene.hold == "load" else None
        limit = "It holds up to the first slip, where nodes at the edges move to the next site."
        found.append(Theory("Griffith", "A", "U_x", *_griffith(scene, contact, load), limit))
    return tuple(found)


def _maugis(contact, gamma, pull, number, widest):
    """(delta, A, L) of the stable branch. A is the length under pressure, less than that of the contact in theory.

    Around a contact of half-width a the surfaces attract each other by `pull` up to m a. That is the pressure of Hertz
    less bonded strips of half-widths t from a to m a, each of load 2 pull ds, t^2 = (m a)^2 - s^2.
    """
    m = 1.0 + np.geomspace(1e3, 1e-4, DRAWN)
    mu = np.sqrt(m * m - 1.0)
    square = number / 2.0 * (m * mu - np.log(m + mu))
    linear = number**2 / 2.0 * (mu * np.log(m + mu) - m * np.log(m))
    a = 4.0 * (gamma * contact.R**2 / (pi * contact.E)) ** (1.0 / 3.0) / (linear + np.sqrt(linear**2 + 4.0 * square))
    inside = (a < widest) & (m * a < contact.t[-1]) & (a > contact.t[0])
    a, m, zone = a[inside], m[inside], (a * mu)[inside]
    s = (np.arange(DRAWN)[:, None] + 0.5) / DRAWN * zone
    strips = np.interp(np.sqrt((m * a) ** 2 - s**2), contact.t, contact.flat).mean(axis=0)
    delta, slope = np.interp(a, contact.t, contact.round) - 2.0 * pull * zone * strips, contact.E / (2.0 * contact.R)
    # r = sqrt(a^2 - x^2)
    r = _zero(lambda r, zone: slope * r - 2.0 * pull / pi * np.arctan2(zone, r), np.zeros(a.shape), a, zone)
    stable = slice(int(np.argmin(delta)) if delta.size else 0, None)
    load = 0.5 * pi * slope * a**2 - 2.0 * pull * zone
    return delta[stable], 2.0 * np.sqrt(a**2 - r**2)[stable], load[stable]


def _griffith(scene, contact, load):
    """(U_x, A): both edges of a bonded strip of half-width a release Gamma(psi): N^2 + F^2 = 2 pi E* a Gamma.

    N = H - P is the load that adhesion bears, H the load of Hertz, and tan psi = F/N.
    """
    gammas, a = contact.springs * toughness(scene, ANGLES), np.linspace(contact.t[0], contact.t[-1], 4 * DRAWN)
    round, flat, sheared = (np.interp(a, contact.t, each) for each in (contact.round, contact.flat, contact.sheared))
    N = (round - scene.delta) / flat if load is None else pi * contact.E * a**2 / (4.0 * contact.R) - load

    def excess(psi, N=N, a=a):
        return N - np.sqrt(2.0 * pi * contact.E * a * np.interp(psi, ANGLES, gammas)) * np.cos(psi)

    held = (N > 0.0) & (excess(0.0) <= 0.0) & (excess(ANGLES[-1]) >= 0.0)
    psi = _zero(excess, np.zeros(a.shape), np.full(a.shape, ANGLES[-1]), N, a)
    U_x, A = sheared * N * np.tan(psi), 2.0 * np.sqrt(np.maximum(a**2 - 2.0 * contact.R * N / (pi * contact.E), 0.0))
    U_x, A = np.append(0.0, U_x[held][::-1]), np.append(A[held][-1:], A[held][::-1])
    rises = U_x > np.append(-1.0, np.maximum.accumulate(U_x)[:-1])  # up to the fold; interpolation may turn round
    return U_x[rises], A[rises]
