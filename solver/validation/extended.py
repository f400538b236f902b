"""A frame rechecked: its residual from sums written out spring by spring and mode by mode, in long double.

Shares no code with `mechanics`: the springs are summed one by one in NumPy, the layer's stiffness is
the textbook quotient of hyperbolic functions, inverted 2 x 2, and the transforms cover the whole cell.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

LONG = np.longdouble  # 64 bits of mantissa on x86; elsewhere perhaps 53: then the check is as exact as the solver
HALF_PLANE = 40.0  # q h from which on exp(-2 q h) (q h)^2 < 1e-31: the layer is a half-plane
EPS = float(np.finfo(float).eps)
ROUNDING = 64.0  # roundings of one evaluation that may add up: some ten per exponential, log2(nodes) per transform
SHIFTS = 8.0  # roundings, of half a unit in the last place, on the way to a traction
DROPPED = 0.1  # of delta_n, by which a node may stand on the wrong side of the window's edge


@dataclass(frozen=True)
class Recheck:
    """residual and floor, nm: the recomputed residual, and what round-off in float64 alone can amount to.

    traction, forces: deviation of the frame's T over the largest `gross`, of F_bar and L_bar over its sum / (n E).
    window: how far (delta_n) any node stands on the wrong side of the edge of the interaction window.
    """

    residual: float
    floor: float
    traction: float
    forces: float
    window: float


def recheck(scene, frame):
    """The Recheck on one Frame of a Scene."""
    part = slice(frame.first, frame.first + frame.u.shape[1])
    active = _active(scene, frame)
    T, gross = np.zeros((2, scene.nodes), LONG), np.zeros(scene.nodes, LONG)
    T[:, part], gross[part] = springs(scene, frame.u[0], scene.profile[part] + frame.u[1].astype(LONG), active)
    u, largest = displacement(scene, T)
    rounded = _rounding(scene, frame, active, T[:, part], gross[part])
    top = np.array([[frame.U_x], [-frame.delta]], LONG)
    u += top
    dn = (scene.profile + u[1]) / scene.delta_n
    dn[part] = (scene.profile[part] + frame.u[1]) / scene.delta_n
    inside = np.zeros(scene.nodes, bool)
    inside[part] = active
    wrong = np.where(inside, dn - scene.window_n, scene.window_n - dn)
    forces = np.array([-T[0].sum(), T[1].sum()]) / (scene.nodes * LONG(scene.E)) - (frame.F_bar, frame.L_bar)
    return Recheck(
        residual=float(np.abs(u[:, part] - frame.u).max()),
        floor=_floor(frame, largest + float(np.abs(top).max())) + rounded,
        traction=float(np.abs(T[:, part] - frame.T).max()) / (float(gross.max()) or 1.0),
        forces=float(np.abs(forces).max()) * scene.nodes * scene.E / (float(gross.sum()) or 1.0),
        window=max(0.0, float(wrong.max())),
    )


def _active(scene, frame):
    """Nodes that carry traction in a frame, bool (m,); at dn = 0 and dt = 0 there is none to tell, so the gap does."""
    part = slice(frame.first, frame.first + frame.u.shape[1])
    near = scene.profile[part] + frame.u[1] <= 0.5 * scene.window_n * scene.delta_n
    return (frame.T != 0.0).any(axis=0) | near


def _floor(frame, terms):
    """nm: round-off of u itself and of the sum of `terms`."""
    return ROUNDING * EPS * (terms + float(np.abs(frame.u).max()))


def _rounding(scene, frame, active, T, gross):
    """nm: how far C T moves by the roundings of shift, gap and the sum over springs (whose terms cancel) in float64.

    SHIFTS of them, of half a unit in the last place, at random for each node; all nodes alike where they move alike.
    """
    part = slice(frame.first, frame.first + frame.u.shape[1])
    profile, shape = scene.profile[part], (4, 1 if scene.surface == "flat" else active.size)
    sign = np.random.default_rng(0).uniform(-1.0, 1.0, shape) if shape[1] > 1 else np.ones(shape)
    share = SHIFTS * 0.5 * EPS * sign.astype(LONG)
    u = frame.u + share[:2] * np.array([np.abs(frame.u[0]), np.abs(frame.u[1]) + profile])
    change = np.zeros((2, scene.nodes), LONG)
    change[:, part] = springs(scene, u[0], profile + u[1], active)[0] - T + share[2:] * gross
    return float(np.abs(displacement(scene, change)[0][:, part]).max())


def springs(scene, ux, gap, active):
    """T (2, m) GPa, paper Eq. 2-4 site by site in long double, for nodes displaced by ux at that gap, nm.

    And gross (m,), GPa, the springs' size: the same sum with |dn| + 1 and |dt| + 1 for the factors that pass through
    zero; at least that of one spring at dt = 0 (a node between sites has none but at the edge of the window).
    """
    a, delta_t, delta_n = LONG(scene.spacing), LONG(scene.delta_t), LONG(scene.delta_n)
    ux, dn = np.asarray(ux, LONG), np.asarray(gap, LONG) / delta_n
    nearest, shear, press, all_shear = np.rint(ux / a), *np.zeros((3, ux.size), LONG)
    reach = int(np.ceil(scene.window_t * scene.delta_t / scene.spacing)) + 1
    for k in range(-reach, reach + 1):
        dt = ((nearest + k) * a - ux) / delta_t
        bell = np.where(np.abs(dt) <= scene.window_t, np.exp(-dt * dt), LONG(0))
        shear += dt * bell
        all_shear += (np.abs(dt) + 1) * bell
        press += bell
    force = np.where(active, np.exp(-dn), LONG(0))
    t, n = 2 * LONG(scene.phi_t) / delta_t * force, LONG(scene.phi_n) / delta_n * force
    gross = t * np.maximum(all_shear, 1) + n * (np.abs(dn) + 1) * np.maximum(press, 1)
    return np.array([t * shear, -n * dn * press]), gross


@lru_cache(maxsize=4)
def compliance(nodes, width, height, E, nu):
    """(C_xx, C_zz, C_c), long double (3, nodes//2 + 1), by inverting the textbook stiffness as printed."""
    q = 2 * LONG("3.14159265358979323846264") * np.arange(nodes // 2 + 1, dtype=LONG) / LONG(width)
    h, nu = LONG(height) * LONG(width), LONG(nu)
    G, kappa = LONG(E) / (2 * (1 + nu)), 3 - 4 * nu
    deep = q * h > HALF_PLANE
    y = np.where(deep, LONG(1), q * h)
    y[0] = 1
    s, c = np.sinh(y), np.cosh(y)
    d = kappa**2 * s**2 - y**2
    xx = np.where(deep, 4 * G * (1 - nu) * q / kappa, 4 * G * (1 - nu) * q * (kappa * s * c - y) / d)
    zz = np.where(deep, 4 * G * (1 - nu) * q / kappa, 4 * G * (1 - nu) * q * (kappa * s * c + y) / d)
    cc = np.where(deep, 2 * G * (1 - 2 * nu) * q / kappa, 2 * G * q * (kappa * (1 - 2 * nu) * s**2 - y**2) / d)
    xx[0], zz[0], cc[0] = G / h, 2 * G * (1 - nu) / ((1 - 2 * nu) * h), 0
    if nodes % 2 == 0:
        cc[-1] = 0  # the coupling of the Nyquist mode has no real phase
    det = xx * zz - cc**2
    return np.array([zz / det, xx / det, cc / det])


def displacement(scene, T):
    """(C T, size of its terms): nm, long double (2, nodes), and the sum over all modes of |C| |T|, which bounds C T."""
    c_xx, c_zz, c_c = compliance(scene.nodes, scene.width, scene.height, scene.E, scene.nu)
    x, z = np.fft.rfft(T, axis=1)
    out = np.fft.irfft(np.array([c_xx * x + 1j * c_c * z, c_zz * z - 1j * c_c * x]), scene.nodes, axis=1)
    terms = (c_xx + np.abs(c_c)) * np.abs(x) + (c_zz + np.abs(c_c)) * np.abs(z)
    return out, 2.0 * float(terms.sum()) / scene.nodes
