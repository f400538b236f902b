"""The overdamped flow u' = U + C T(u) - u, which carries the state through an instability to the next equilibrium.

Runge-Kutta-Chebyshev, second order, step by error control: explicit, with as many stages as the stiffest mode asks for
(Sommeijer, Shampine & Verwer 1998, doi:10.1016/S0377-0427(97)00219-7). Which branch is reached is part of the answer.
"""

from functools import cache
from math import ceil, sqrt

import numpy as np
from numba import njit

from .secants import dot

STEP_ERROR = 0.02  # of min(delta_n, delta_t), in one step; the branch reached does not depend on it (test_slip.py)
# NP1 has no potential, so some modes turn while they decay: more damping than usual (2/13) widens the stable strip
DAMPING = 1.5
REACH = 1.5 / (1.0 - 2.0 * DAMPING / 15.0)  # stages^2 - 1 per step times stiffest mode
MOST_STAGES = 200
MOST_GROWTH = 2.0  # of one step over the one before
SAFE = 1.1  # on the spectral radius, which power iteration approaches from below
MOST_CHANGES = 10
LOOK_BACK = 16  # steps
TO_AND_FRO = 0.2  # of the way gone: a smaller displacement in LOOK_BACK steps is an oscillation
PROBE_EVERY = 4  # steps between two looks at the stiffest mode
PROBE = 1e-6  # nm, length of the probe along the stiffest mode


class Flow:
    """State of the flow at fixed load: u, its velocity r (the residual), and the step in use."""

    def __init__(self, contact, u, load, error):
        self.contact, self.load, self.error = contact, load, error
        self.u = np.array(u)
        self.active = contact.within_window(u)
        self.r = np.empty_like(u)
        self.speed = contact.residual(self.u, self.active, load, self.r)
        self.peak = self.speed
        self.step = 0.1
        self._steps = 0
        self._changes = np.zeros(contact.size, int)
        self._last = self.step, 1.0  # the last step and its error, of what is allowed
        self._milestone, self._path = self.u, 0.0  # state at the last look back, and the way gone since, nm
        self._mode = np.random.default_rng(0).normal(size=u.shape)
        self.radius = 1.0
        for _ in range(6):
            self._probe()

    @property
    def residual(self):
        """The residual, nm, is the speed."""
        return self.speed

    def _probe(self):
        """One nonlinear power iteration for the spectral radius of dr/du, the direction kept between steps."""
        scale = PROBE / sqrt(dot(self._mode.ravel(), self._mode.ravel()) + 1e-300)
        self._mode *= scale
        there = np.empty_like(self.r)
        self.contact.residual(self.u + self._mode, self.active, self.load, there)
        there -= self.r
        self.radius = max(1.0, sqrt(dot(there.ravel(), there.ravel())) / PROBE)
        self._mode = there

    def advance(self):
        """One accepted step; returns the speed max |u'| (nm per unit of time) after it."""
        grow = MOST_GROWTH
        while True:
            stages = max(2, ceil(sqrt(1.0 + REACH * self.step * SAFE * self.radius)))
            if stages > MOST_STAGES:
                stages = MOST_STAGES
                self.step = (stages**2 - 1) / (REACH * SAFE * self.radius)
            there, r = self._stages(stages)
            speed = self.contact.residual(there, self.active, self.load, r)
            share = _step_error(self.u.ravel(), there.ravel(), self.r.ravel(), r.ravel(), self.step) / self.error
            step = self.step
            self.step *= min(grow, max(0.2, self._next_step(share, step)))
            if share <= 1.0:
                break
            grow = 1.0
        self._last = step, max(share, 1e-6)
        self.u, self.r, self.speed = there, r, speed
        self.peak = max(self.peak, speed)
        self._steps += 1
        self._path += step * speed
        if self._steps % PROBE_EVERY == 0:
            self._probe()
        if self._steps % LOOK_BACK == 0:
            self._see_whether_it_gets_on()
        self._choose_active()
        return self.speed

    def _choose_active(self):
        """Nodes within the window; those that came and went MOST_CHANGES times stay as they are, or it never ends."""
        active = self.contact.within_window(self.u)
        changed = active != self.active
        if changed.any():
            self._changes += changed
            self.active = np.where(self._changes > MOST_CHANGES, self.active, active)
            self.speed = self.contact.residual(self.u, self.active, self.load, self.r)

    def nudge(self, distance):
        """Move every node by a random distance of that order (nm): off a saddle the flow would stay on."""
        self.u = self.u + distance * np.random.default_rng(self._steps).normal(size=self.u.shape)
        self.speed = self.peak = self.contact.residual(self.u, self.active, self.load, self.r)
        self.step, self._last = 0.1, (0.1, 1.0)

    def _see_whether_it_gets_on(self):
        """Allow less error where modes go to and fro within it and never die away."""
        if np.abs(self.u - self._milestone).max() < TO_AND_FRO * self._path:
            self.error = max(0.25 * self.error, 1e-3 * self.contact.scene.tolerance)
        self._milestone, self._path = self.u, 0.0

    def _next_step(self, share, step):
        """Factor on the step that should bring the error to what is allowed, if it goes on changing as it did."""
        usual = 0.8 * max(share, 1e-6) ** (-1.0 / 3.0)
        before, share_before = self._last
        return min(usual, usual * step / before * (share_before / max(share, 1e-6)) ** (1.0 / 3.0))

    def _stages(self, stages):
        first, table = _chebyshev(stages)
        load, h = self.load, self.step
        before, now = self.u, self.u + first * h * self.r
        for coefficients in table:
            response = self.contact.response(now, self.active)
            before, now = now, _stage(self.u, now, before, response, load[0], load[1], self.r, *coefficients, h)
        return now, np.empty_like(now)


@cache
def _chebyshev(s):
    """Coefficients of the s-stage formula: of the first stage, then (mu, nu, mu~, gamma~) of each later one."""
    w0 = 1.0 + DAMPING / (s * s)
    t, d, dd = [1.0, w0], [0.0, 1.0], [0.0, 0.0]
    for _ in range(2, s + 1):
        dd.append(4.0 * d[-1] + 2.0 * w0 * dd[-1] - dd[-2])
        d.append(2.0 * t[-1] + 2.0 * w0 * d[-1] - d[-2])
        t.append(2.0 * w0 * t[-1] - t[-2])
    w1 = d[s] / dd[s]
    b = [0.0, 0.0] + [dd[j] / d[j] ** 2 for j in range(2, s + 1)]
    b[0] = b[1] = b[2]
    table = []
    for j in range(2, s + 1):
        rate = 2.0 * b[j] * w1 / b[j - 1]
        table.append((2.0 * b[j] * w0 / b[j - 1], -b[j] / b[j - 2], rate, -(1.0 - b[j - 1] * t[j - 1]) * rate))
    return b[1] * w1, tuple(table)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _stage(u0, now, before, response, load_x, load_z, r0, mu, nu, rate, start, h):
    later, rest = np.empty_like(now), 1.0 - mu - nu
    for c in range(2):
        load = load_x if c == 0 else load_z
        for i in range(u0.shape[1]):
            r = load + response[c, i] - now[c, i]
            later[c, i] = rest * u0[c, i] + mu * now[c, i] + nu * before[c, i] + h * (rate * r + start * r0[c, i])
    return later


@njit(cache=True, nogil=True)
def _step_error(u0, u1, r0, r1, h):
    largest = 0.0
    for i in range(u0.size):
        error = abs(0.8 * (u0[i] - u1[i]) + 0.4 * h * (r0[i] + r1[i]))
        if not np.isfinite(error):
            return np.inf
        largest = max(largest, error)
    return largest
