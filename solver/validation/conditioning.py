"""Where floating point itself limits: the error attained there, and that of the textbook formula in float64."""

from dataclasses import dataclass

import numpy as np

from ..mechanics.cohesive_law import traction
from ..mechanics.layer import compliance, stiffness
from ..scene import Scene
from .extended import LONG, springs

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Limit:
    """A place where digits cancel or overflow.

    attained, textbook: relative error reached, and that of the formula as printed (nan: overflows; None: the same).
    """

    name: str
    attained: float
    textbook: float | None
    allowed: float
    remedy: str


def printed(q, height, E, nu, kind=LONG):
    """(K_xx, K_zz, K_c) GPa/nm by the textbook formulas, in arithmetic of that kind; inf or nan where they overflow."""
    q, h, E, nu = np.asarray(q, kind), kind(height), kind(E), kind(nu)
    G, kappa, y = E / (2 * (1 + nu)), 3 - 4 * nu, q * h
    with np.errstate(all="ignore"):
        s, c = np.sinh(y), np.cosh(y)
        d = kappa**2 * s**2 - y**2
        long_xx, long_zz = (4 * G * (1 - nu) * q * (kappa * s * c + sign * y) / d for sign in (-1, 1))
        return np.array([long_xx, long_zz, 2 * G * q * (kappa * (1 - 2 * nu) * s**2 - y**2) / d])


def conditioning():
    """Every Limit; long double is the reference (against mpmath: tests/test_closed_forms.py)."""
    waves = (
        ("nu = 0.4999, q h = 1e-3 .. 1", 0.4999, 1.0, np.geomspace(1e-3, 1.0, 40), 70.0),
        ("nu = 0.4999, thinnest layer's longest wave", 0.4999, 1.0, np.array([0.02 * np.pi]), 70.0),
        ("thin layer, h = 0.01 w, 16384 nodes", 0.45, 25.0, 2 * np.pi * np.arange(1, 8193) / 2500.0, 70.0),
        ("thick layer, q h up to 5000", 0.45, 250.0, np.linspace(0.1, 20.0, 200), 70.0),
        ("E = 1e6 GPa, nu = 0", 0.0, 2500.0, 2 * np.pi * np.arange(1, 513) / 2500.0, 1e6),
    )
    rows = [_layer(*wave) for wave in waves]
    rows += [_inverse(nu, y) for nu, y in ((0.4999, 1e-3), (0.4999, 0.06), (0.0, 1e-3))]
    rows += [_overclosure(depth) for depth in (-5.0, -30.0, -50.0)]
    return rows


def _layer(name, nu, height, q, E):
    exact = printed(q, height, E, nu)
    scale = np.maximum(np.abs(exact), exact[0])  # K_c passes through zero
    attained = np.abs(np.array(stiffness(q, height, E, nu)) - exact) / scale
    plain = np.abs(printed(q, height, E, nu, np.float64) - exact) / scale
    return Limit(f"stiffness: {name}", float(attained.max()), float(plain.max()), 64 * EPS,
                 "D as a product of sums, sinh y - y by its series, all scaled by exp(-2 y)")  # fmt: skip


def _inverse(nu, y):
    """C K = 1 in long double, C and K as the solver has them: what one product with each loses."""
    k = np.array(stiffness(np.array([y]), 1.0, 70.0, nu), LONG)[:, 0]
    c = np.array(compliance(np.array([y]), 1.0, 70.0, nu), LONG)[:, 0]
    # u_x by u_z = 1 and back, in units of the larger stiffness: rows of C K
    error = max(abs(k[0] * c[0] - k[2] * c[2] - 1), abs(k[1] * c[1] - k[2] * c[2] - 1))
    return Limit(f"compliance times stiffness: nu = {nu:g}, q h = {y:g}", float(error), None, 64 * EPS,
                 "both in closed form, neither by inverting the other")  # fmt: skip


def _overclosure(depth):
    """Tractions at gap = depth delta_n: exp(50) = 5e21."""
    scene, x = Scene(), np.linspace(-3.0, 3.0, 61)
    gap = np.full(x.size, depth)
    exact, gross = springs(scene, x, gap, np.ones(x.size, bool))
    error = np.abs(traction(scene, x, gap) - exact).max() / gross.max()
    return Limit(f"traction at dn = {depth:g} delta_n", float(error), None, 64 * EPS,
                 "exponential good to round-off; its argument is exact")  # fmt: skip
