"""Linear fracture mechanics of an adhesive contact under load and shear: the theory alone, without a line of `solver`.

An elastic half-plane with a wavy surface, amplitude (1 - cos k x), k = 2 pi/w, is bonded to a rigid plane over
|x - s| < a in every period w (plane strain). Per period and depth it carries the load P (compression > 0) and the
friction force F. With b = (1 - 2 nu)/(2 (1 - nu)), Dundurs' parameter, and f = T_z + i T_x, the bond requires

    H f + i b (f - mean f) = E*/2 (amplitude k sin k x),    H f = (1/w) PV int f(t) cot(pi (x - t)/w) dt,

a Riemann-Hilbert problem (Muskhelishvili) whose solution is a trigonometric polynomial over a root. The energy release
rate is G = (1 - b^2) |K|^2/(2 E*) (Rice 1988). Lengths in nm, moduli in GPa, forces and rates in N/m.
"""

from dataclasses import dataclass
from math import cosh, log, pi, sin

import numpy as np
from scipy.optimize import brentq, fsolve, minimize_scalar

ODD = np.array([-3, -1, 1, 3])  # harmonics exp(i pi n x/w) of the polynomial
FINE = np.geomspace(1.0, 1e-6, 300)  # distances from an edge, over a, where a zero of the pressure is searched


@dataclass(frozen=True)
class Strip:
    """A bonded strip of half-width a around s in a wavy half-plane."""

    E_star: float  # GPa, E/(1 - nu^2)
    nu: float
    width: float  # nm, period
    radius: float  # nm, of the crest

    @property
    def b(self) -> float:
        """Dundurs' parameter against a rigid body."""
        return (1.0 - 2.0 * self.nu) / (2.0 * (1.0 - self.nu))

    @property
    def eta(self) -> float:
        """Index of the oscillation at the edges."""
        return log((1.0 + self.b) / (1.0 - self.b)) / (2.0 * pi)

    def polynomial(self, a, s, P, F):
        """Coefficients (4,) of exp(i pi n x/w), n in ODD: no growth far from the surface, and the forces P and F."""
        w, eta = self.width, self.eta
        powers = -0.5 + 1j * eta * np.array([1.0, -1.0])
        turn = np.exp(-2j * pi * np.array([s - a, s + a]) / w)
        up = -2j * np.exp(-1j * pi * s / w + 2.0 * pi * eta * a / w)
        down = 2j * np.exp(1j * pi * s / w - 2.0 * pi * eta * a / w)
        growth = self.E_star * w / (2.0 * pi * self.radius) / 8.0  # E* amplitude k/8
        total = (P - 1j * F) / (2.0 * w)
        first, last = growth / up, -growth / down
        second = total * (1.0 + self.b) / up + (powers @ turn) * first
        third = -total * (1.0 - self.b) / down + (powers @ turn.conj()) * last
        return np.array([first, second, third, last])

    def _value(self, c, x):
        return np.exp(1j * pi / self.width * np.multiply.outer(x, ODD)) @ c

    def traction(self, x, a, s, P, F):
        """T_z + i T_x on the half-plane at x within the strip, GPa."""
        left, right = (np.sin(pi * d / self.width) for d in (x - s + a, s + a - x))
        oscillating = np.exp(1j * self.eta * np.log(left / right))
        value = self._value(self.polynomial(a, s, P, F), x)
        return -2j * cosh(pi * self.eta) * oscillating * value / np.sqrt(left * right)

    def rates(self, a, s, P, F):
        """(2,) G of the left and the right edge."""
        value = self._value(self.polynomial(a, s, P, F), np.array([s - a, s + a]))
        return 4.0 * self.width / (self.E_star * sin(2.0 * pi * a / self.width)) * np.abs(value) ** 2

    def angle(self, a, s, P, F):
        """Mode angle of the right edge, rad; for nu = 1/2, where it does not depend on a length."""
        value = self._value(self.polynomial(a, s, P, F), np.array(s + a))  # T_z + i T_x = -2 i value/root
        return float(np.arctan2(abs(value.real), abs(value.imag)))

    def zeros(self, a, s, P, F):
        """(2,) nm: where the pressure changes its sign near each edge, or the edge itself where it does not."""
        found = []
        for side in (-1.0, 1.0):
            x = s + side * a * (1.0 - FINE)
            p = self.traction(x, a, s, P, F).real
            k = np.flatnonzero(np.diff(np.sign(p)))
            pressure = lambda at: float(self.traction(np.array(at), a, s, P, F).real)  # noqa: E731
            found.append(brentq(pressure, x[k[0]], x[k[0] + 1], xtol=1e-9) if k.size else s + side * a)
        return np.array(found)

    def jkr(self, P, gamma):
        """The largest half-width in equilibrium without shear, nu = 1/2: the stable one."""
        widths = np.linspace(0.4, 0.002, 400) * self.width
        over = [self.rates(a, 0.0, P, 0.0)[1] - gamma for a in widths]
        k = next(k for k in range(len(over) - 1) if over[k] * over[k + 1] <= 0.0 < over[k])
        return brentq(lambda a: self.rates(a, 0.0, P, 0.0)[1] - gamma, widths[k + 1], widths[k], xtol=1e-9)

    def equilibrium(self, P, F, gamma, start):
        """(a, s) at which both rates are gamma(mode angle of the strip); raises ValueError where there is none."""
        found, _, flag, _ = fsolve(
            lambda v: self.rates(*v, P, F) / gamma(self.angle(*v, P, F)) - 1.0, start, xtol=1e-12, full_output=True
        )
        if flag != 1:
            raise ValueError(f"no strip in equilibrium at P = {P:.4g}, F = {F:.4g} N/m")
        return found

    def strip_of(self, zeros, P, F):
        """(a, s) whose pressure changes its sign at `zeros` (2,), nm."""
        start = np.array([0.575 * (zeros[1] - zeros[0]), zeros.mean()])
        return fsolve(lambda v: self.zeros(*v, P, F) - zeros, start, xtol=1e-10)

    def largest_shear(self, P, gamma):
        """The largest F of any strip in equilibrium under P with a constant gamma, for nu = 1/2, where s = 0."""

        def shear(a):  # |value|^2 is even in F
            opening = self.rates(a, 0.0, P, 0.0)[1]
            sheared = self.rates(a, 0.0, P, 1.0)[1] - opening
            return -(max(0.0, (gamma - opening) / sheared) ** 0.5)

        top = self.jkr(P, gamma)
        return -minimize_scalar(shear, bounds=(0.2 * top, top), method="bounded").fun
