"""The limits of floating point: the error attained there, and that of the textbook formula in float64."""

from dataclasses import dataclass
from math import inf

import numpy as np
from extended import inverse, springs, stiffness
from recheck import EPS, ROUNDING

from solver.mechanics import layer
from solver.mechanics.cohesive_law import traction
from solver.scene import Scene

# name: nu, height (nm), wavenumbers (1/nm), E (GPa); together q h from 1e-3 to 5000, nu from 0 to the largest allowed
WAVES = {
    "nu = 0.4999, q h = 1e-3 .. 1": (0.4999, 1.0, np.geomspace(1e-3, 1.0, 40), 70.0),
    "nu = 0.4999, thinnest layer's longest wave": (0.4999, 1.0, np.array([0.02 * np.pi]), 70.0),
    "thin layer, h = 0.01 w, 16384 nodes": (0.45, 25.0, 2 * np.pi * np.arange(1, 8193) / 2500.0, 70.0),
    "thick layer, q h up to 5000": (0.45, 250.0, np.linspace(0.1, 20.0, 200), 70.0),
    "E = 1e6 GPa, nu = 0": (0.0, 2500.0, 2 * np.pi * np.arange(1, 513) / 2500.0, 1e6),
}
DEPTHS = (-5.0, -30.0, -50.0)  # dn/delta_n; exp(50) = 5e21


@dataclass(frozen=True)
class Limit:
    """A place where digits cancel or overflow.

    attained, textbook: relative error of the solver, and of the printed formula (nan: overflows; None: the same).
    """

    name: str
    attained: float
    textbook: float | None
    allowed: float
    remedy: str


def conditioning() -> list[Limit]:
    """Every Limit; the reference is `extended` (test_closed_forms.py compares that with mpmath)."""
    return [limit for name, wave in WAVES.items() for limit in _layer(name, *wave)] + [_overclosure(n) for n in DEPTHS]


def _layer(name, nu, height, q, E):
    """The Limits of stiffness and compliance."""
    exact, plain = stiffness(q, height, E, nu), stiffness(q, height, E, nu, np.float64, inf)
    factored = "D as a product of sums, sinh y - y by its series, all scaled by exp(-2 y)"
    inverted = "the inverse of K, mode by mode"
    allowed = ROUNDING * EPS
    yield Limit(
        f"stiffness: {name}", _off(layer.stiffness(q, height, E, nu), exact), _off(plain, exact), allowed, factored
    )
    attained, exact = _off(layer.compliance(q, height, E, nu), inverse(exact)), inverse(exact)
    with np.errstate(invalid="ignore"):
        plain = inverse(plain)
    yield Limit(f"compliance: {name}", attained, _off(plain, exact), allowed, inverted)


def _off(blocks, exact):
    """The largest relative error; of the coupling, which passes through zero, over the larger diagonal entry."""
    scale = np.maximum(np.abs(exact), np.maximum(exact[0], exact[1]) * np.array([[0], [0], [1]]))
    with np.errstate(invalid="ignore"):
        return float((np.abs(np.array(blocks) - exact) / scale).max())


def _overclosure(depth):
    """The Limit of the tractions at gap = depth delta_n."""
    scene, x = Scene(), np.linspace(-3.0, 3.0, 61)
    gap = np.full(x.size, depth)
    exact, gross = springs(scene, x, gap)
    error = float(np.abs(traction(scene, x, gap) - exact).max() / gross.max())
    remedy = "exponential good to round-off; its argument is exact"
    return Limit(f"traction at dn = {depth:g} delta_n", error, None, ROUNDING * EPS, remedy)
