"""Other transients to the same equilibria, as methods of `load_path`; the bench `curves` compares them.

Mass-weighted GFMD: every mode of the free layer moves equally fast (Zhou, Moseler & Mueser 2019,
doi:10.1103/PhysRevB.99.144103). FIRE, the fast inertial relaxation engine (Bitzek et al. 2006,
doi:10.1103/PhysRevLett.97.170201), with the same masses: modes move without friction while the power F.v is positive,
their velocity turned towards the force; otherwise they stop. NP1 has no potential, so that power alone decides.
Inertia is not damped: from the end of a branch FIRE may reach another equilibrium than the damped transient.

`Halving` is the paper's GFMD alone, from equilibrium to equilibrium. It halves an increment with a slip until that is
shorter than SHORT: the transient then starts at rest just beyond the end of the branch, as the remainder of a long
increment would set it swinging.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from solver.continuation.gfmd import Gfmd
from solver.continuation.state import Increment

SHORT = 2e-3  # of the problem's unit: the increment in which a slip begins; the end of the branch is not located
SAFETY = 0.5  # of the longest stable step: the interface may stiffen before the next look at it
# power iterations from a random direction; later ones go on from the last. Where two radii differ by a third, six leave
# an error of (3/4)^12 = 3 %, for which SAFETY has room
PROBES = 6


@dataclass(frozen=True)
class Engine:
    """Parameters of FIRE, as Bitzek et al. 2006 give them."""

    least: int = 5  # steps before the time step grows
    growth: float = 1.1  # factors of the time step
    fall: float = 0.5
    mixing: float = 0.1  # of the velocity with the force, at the start
    less: float = 0.99  # factor of the mixing
    start: float = 0.1  # of the longest step


ENGINE = Engine()


class MassWeighted(Gfmd):
    """u'' = r - 2 u', r = U + C T(u) - u, for every mode: critical for all modes of the free layer at once."""

    def __init__(self, problem, damping, closed):
        super().__init__(problem, damping, closed)
        self._direction = None

    def _motion(self, dynamics, y, load):
        return Weighted(dynamics, y, load)

    def _stiffness(self, dynamics, v):
        """Spectral radius of dr/du, by power iteration."""
        product, probes = self.problem.linearised(v).tangent, 1
        if self._direction is None or self._direction.size != v.size:
            self._direction, probes = np.random.default_rng(0).normal(size=v.size), PROBES
        for _ in range(probes):
            self._direction = product(self._direction / max(np.linalg.norm(self._direction), 1e-300))
        return max(1.0, np.linalg.norm(self._direction))


class Fire(MassWeighted):
    """Advances States by FIRE."""

    def _motion(self, dynamics, y, load):
        return FireMotion(dynamics, y, load)


class Weighted:
    """The motion of y, complex (2, modes), with mass K, from rest under `load`, nm."""

    def __init__(self, dynamics, y, load):
        self.dynamics, self.y, self.load = dynamics, y, load
        xx, zz, c = self._stiffness = dynamics.stiffness
        self._compliance = np.array([zz, xx, -c]) / (xx * zz - c * c)
        self._velocity, self.step = np.zeros_like(y), 0.0

    def soften(self, stiffness, pace=1.0) -> None:
        """Adapt the step to that spectral radius of dr/du."""
        self.step = pace * SAFETY * 2.0 / np.sqrt(stiffness)

    def advance(self, steps) -> None:
        """Make so many steps; a force evaluation each."""
        for _ in range(steps):
            residual = self.dynamics.force(self.y, self.load)
            _to_residual(residual, self.y, self._compliance)
            keep, push = self._law(residual)
            _move(self.y, self._velocity, residual, keep, push, self.step)

    def _law(self, residual):
        """(keep, push): the next velocity is keep velocity + push residual."""
        return (1.0 - self.step) / (1.0 + self.step), self.step / (1.0 + self.step)


class FireMotion(Weighted):
    """FIRE in place of damped motion."""

    def __init__(self, dynamics, y, load, engine=ENGINE):
        super().__init__(dynamics, y, load)
        self._engine, self._mixing, self._since = engine, engine.mixing, 0  # steps since the power was negative

    def soften(self, stiffness, pace=1.0) -> None:
        """Adapt the longest step."""
        self._longest = pace * SAFETY * 2.0 / np.sqrt(stiffness)
        self.step = min(self.step or self._engine.start * self._longest, self._longest)

    def _law(self, residual):
        engine = self._engine
        power, speed, force = _power(residual, self._velocity, self._stiffness)
        if power <= 0.0:
            if speed > 0.0:
                self.step, self._mixing, self._since = self.step * engine.fall, engine.mixing, 0
            return 0.0, self.step
        mixing, self._since = self._mixing, self._since + 1
        if self._since > engine.least:
            self.step = min(self.step * engine.growth, self._longest)
            self._mixing *= engine.less
        return 1.0 - mixing, mixing * np.sqrt(speed / force) + self.step


class Halving(Gfmd):
    """GFMD that halves increments in which the surface slips."""

    def increment(self, state, target) -> Increment:
        """The Increment from `state` to load `target`, nm; raises NotConverged."""
        problem = self.problem
        done = super().increment(state, target)
        if not done.slips or target - state.load <= SHORT * problem.unit:
            return done
        self.problem = problem  # it may have grown
        first = self.increment(state, 0.5 * (state.load + target))
        second = self.increment(first.state, target)
        return second._replace(slips=first.slips + second.slips)


@njit(cache=True, nogil=True)
def _to_residual(force, y, c):
    """Turn the force T + K U (2, modes) into U + C T - y, in place; c: compliance, rows xx, zz, c."""
    for q in range(y.shape[1]):
        x, z = force[0, q], force[1, q]
        force[0, q] = c[0, q] * x - 1j * c[2, q] * z - y[0, q]
        force[1, q] = c[1, q] * z + 1j * c[2, q] * x - y[1, q]


@njit(cache=True, nogil=True)
def _move(y, v, r, keep, push, step):
    """One step of all modes, (2, modes), in place."""
    for i in range(2):
        for q in range(y.shape[1]):
            v[i, q] = keep * v[i, q] + push * r[i, q]
            y[i, q] += step * v[i, q]


@njit(cache=True, nogil=True)
def _power(r, v, k):
    """(F.v, v.K v, F.C F) over all modes, F = K r."""
    power = speed = force = 0.0
    for q in range(r.shape[1]):
        count = 1.0 if q == 0 else 2.0  # a mode and its conjugate
        f_x = k[0, q] * r[0, q] - 1j * k[2, q] * r[1, q]
        f_z = k[1, q] * r[1, q] + 1j * k[2, q] * r[0, q]
        p_x = k[0, q] * v[0, q] - 1j * k[2, q] * v[1, q]
        p_z = k[1, q] * v[1, q] + 1j * k[2, q] * v[0, q]
        power += count * (f_x.conjugate() * v[0, q] + f_z.conjugate() * v[1, q]).real
        speed += count * (p_x.conjugate() * v[0, q] + p_z.conjugate() * v[1, q]).real
        force += count * (f_x.conjugate() * r[0, q] + f_z.conjugate() * r[1, q]).real
    return power, speed, force
