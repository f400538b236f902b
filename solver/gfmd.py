"""Damped Green's function molecular dynamics (paper section 2.1): the reference method, and its mass-weighted variant.

Surface modes move in Fourier space under T - K (u - U), less friction, by the Verlet scheme, until
max |U + C T(u) - u| is below the tolerance, at every increment. `Gfmd` gives all modes one mass and a damping critical
for the slowest; `MassWeighted` gives each mode a mass in proportion to its stiffness, so that all move equally fast.
"""

import numpy as np
from numba import njit

from . import np1
from .held import contact_of
from .layer import Modes, transforms
from .state import Increment, NotConverged, Slip, State

CHECK_EVERY = 20  # steps between two looks at the residual
SAFETY = 0.5  # of the largest stable time step
PROBE = 1e-6  # nm, length of the probe along the stiffest direction
FIRST_PROBES = 6  # power iterations from a random direction, before the first step; later ones go on from the last
BUDGET = 1_000_000  # force evaluations of one increment
FINER = (1, 4, 20)  # divisions of the step, each where the one before has diverged
DIVERGED = 1e9  # nm
SLIPPED = 0.5  # of min(delta_n, delta_t), beyond twice the increment of the load: a larger move of a node is a slip


class Gfmd:
    """Advances States of one scene by damped dynamics of all modes; holds no state between calls but buffers."""

    def __init__(self, scene, first, size, leave_out=frozenset(), pressure=None, damping=None, budget=None):
        """pressure: mean normal traction to hold, GPa, or None; damping: as of the scene, unless given.

        budget: force evaluations of one increment, BUDGET unless given.
        Where the load is held, the uniform normal mode moves freely under p - p_0, and the top follows it at rest.
        """
        self.scene, self.contact = scene, contact_of(scene, first, size, pressure)
        self._size, self._pressure, self._budget = size, pressure, budget or BUDGET
        self._part = slice(first, first + size)
        self._modes = Modes.of(scene)
        self._stiffness = self._modes.stiffness.copy()
        if pressure is not None:
            self._stiffness[1, 0] = 0.0
        self._traction, self._u, self._spectrum, self._forward, self._backward = transforms(scene.nodes)
        self._stiffest = float(np.max(np.maximum(self._modes.k_xx, self._modes.k_zz) + np.abs(self._modes.k_c)))
        slowest = float(min(self._modes.k_xx.min(), self._modes.k_zz.min()))
        self._gamma = 2.0 * (scene.damping if damping is None else damping) * np.sqrt(slowest)
        self._r = np.empty((2, self.contact.size))
        self._motion = self._step = None
        self._remedy = "a larger tolerance, a smaller du_x or du_z, or method fast"
        if scene.damping < 1.0:  # the law has no potential, so that it may feed an oscillation
            self._remedy = f"a damping larger than {scene.damping:g}: with so little the contact may never come to rest"

    def undeformed(self, loading, load):
        """The State of a layer that nothing acts on."""
        u = self.contact.undeformed(loading.at(load))
        return State(load, u, self.contact.within_window(u))

    def increment(self, state, loading, target):
        """The equilibrium at load `target` that the damped motion from `state` reaches; raises NotConverged."""
        self.contact.residual(state.u, state.active, loading.at(state.load), self._r)
        before = self.contact.traction()
        u = state.u.copy()
        active = self.come_to_rest(u, state.active, loading, state.load, target)
        residual = self.contact.residual(u, active, loading.at(target), self._r)
        farthest = SLIPPED * min(self.scene.delta_n, self.scene.delta_t) + 2.0 * abs(target - state.load)
        slipped = np.abs(u - state.u).max() > farthest
        slips = (Slip(state.load, state.u, before),) if slipped else ()
        return Increment(State(target, u, active), self.contact.traction(), residual, slips)

    def come_to_rest(self, u, active, loading, load, target):
        """Move u, in place, from rest at `load` to rest at load `target`; the active nodes there."""

        def solve(chosen):
            nonlocal load
            self._settle(u, chosen, loading, load, target)
            load = target
            return True

        return self.contact.settle(solve, u, active)

    def _settle(self, u, active, loading, load, target):
        """Bring u, in place, to rest at load `target`: with finer steps where surfaces that clash made it diverge."""
        start = u.copy()
        for finer in FINER:
            u[:] = start
            if self._rests(u, active, loading, load, target, finer):
                return
        raise NotConverged(
            f"Not converged at {loading.name} = {target:.6g} nm: the damped motion diverges; try a larger damping or E"
        )

    def _rests(self, u, active, loading, load, target, finer):
        """Whether the motion came to rest, u in place, rather than diverged; raises NotConverged if it did neither.

        The surface outside the patch starts in equilibrium with u. finer: division of steps, and of CHECK_EVERY.
        """
        contact, nodes = self.contact, self.scene.nodes
        limit = contact.evaluations + self._budget
        self._traction[:] = 0.0
        traction, shape = self._traction[:, self._part], self._u[:, self._part]
        top = np.array(loading.at(target)) * nodes
        modes = self._equilibrium(u, active, self._top(u, loading.at(load)), traction)
        self._begin(modes, self._time_step(u, active, loading.at(target)) / finer)
        while True:
            for _ in range(CHECK_EVERY // finer):
                self._shape(modes)
                np1.tractions(shape, contact.profile, active, contact.law, contact.work, traction, self._size)
                self._forward()
                self._move(modes, top)
                contact.evaluations += 1
            self._shape(modes)
            self._take(u, shape, modes, loading.at(target))
            residual = contact.residual(u, active, loading.at(target), self._r)  # passes over nan
            if not (np.isfinite(u).all() and residual < DIVERGED):
                return False
            if residual <= self.scene.tolerance:
                return True
            if contact.evaluations > limit:
                raise NotConverged(
                    f"Not converged at {loading.name} = {target:.6g} nm: residual {residual:.2g} nm after"
                    f" {self._budget} force evaluations of damped motion; try {self._remedy}"
                )
            self._limit(self._time_step(u, active, loading.at(target)) / finer)

    def _begin(self, modes, limit):
        """At rest, with steps of the length `limit`."""
        self._motion, self._step = np.zeros_like(modes), limit

    def _limit(self, limit):
        """Go on at the same velocity with steps of the length `limit`."""
        self._motion *= limit / self._step
        self._step = limit

    def _take(self, u, shape, modes, load):
        """Fill u, in place, from the surface on the patch; under a held load, with the top that carries it there."""
        if self._pressure is None:
            u[:] = shape
            return
        u[:, :-1] = shape
        u[:, -1] = load[0], modes[1, 0].real / self.scene.nodes - self._modes.compliance[1, 0] * self._pressure
        self.contact.within_window(u)

    def _top(self, u, load):
        return load if self._pressure is None else u[:, -1]

    def _move(self, modes, top):
        """One step of all modes, in place, from the traction in self._spectrum."""
        if self._pressure is not None:
            self._spectrum[1, 0] -= self._pressure * self.scene.nodes
        _verlet(modes, self._motion, self._spectrum, self._stiffness, top, self._step, self._gamma)

    def _shape(self, modes):
        """Displacement of the surface from its modes."""
        self._spectrum[:] = modes
        self._backward()
        self._u *= 1.0 / self.scene.nodes

    def _equilibrium(self, u, active, load, traction):
        """Modes of the whole surface, U + C T(u)."""
        np1.tractions(u, self.contact.profile, active, self.contact.law, self.contact.work, traction, self._size)
        self._forward()
        modes = self._modes.displacement(self._spectrum)
        modes[:, 0] += np.array(load) * self.scene.nodes
        return modes

    def _time_step(self, u, active, load):
        """A stable step: bounded by the stiffest mode, plus the stiffest node of the interface."""
        tangents = np.abs(self.contact.tangents(u, active)[:, : self._size])
        interface = max((tangents[0] + tangents[1]).max(), (tangents[2] + tangents[3]).max())
        return SAFETY * 2.0 / np.sqrt(self._stiffest + interface)


class MassWeighted(Gfmd):
    """The same motion with mass K and friction gamma K: u'' = r - gamma u', r = U + C T(u) - u, for every mode.

    All modes of the free layer have the period 2 pi, and gamma = 2 damping is critical for all of them at once; only
    the interface makes some faster. Masses as in Zhou, Moseler & Mueser 2019, doi:10.1103/PhysRevB.99.144103.
    """

    def __init__(self, scene, first, size, leave_out=frozenset(), pressure=None, damping=1.0):
        """damping: in units of the critical damping of a free layer's mode."""
        super().__init__(scene, first, size, leave_out)  # holds no load: `variants` compares runs at held delta
        self._gamma = 2.0 * damping
        self._direction = None

    def _move(self, modes, top):
        c = self._modes.compliance
        _verlet_weighted(modes, self._motion, self._spectrum, c, top, self._step, self._gamma)

    def _time_step(self, u, active, load):
        """A stable step, from the spectral radius of dr/du by nonlinear power iteration on the patch."""
        contact, probes = self.contact, 1
        if self._direction is None or self._direction.shape != u.shape:
            self._direction, probes = np.random.default_rng(0).normal(size=u.shape), FIRST_PROBES
        here, there = np.empty_like(u), np.empty_like(u)
        contact.residual(u, active, load, here)
        for _ in range(probes):
            self._direction *= PROBE / max(np.linalg.norm(self._direction), 1e-300)
            contact.residual(u + self._direction, active, load, there)
            self._direction = there - here
        radius = max(1.0, np.linalg.norm(self._direction) / PROBE)
        return SAFETY * 2.0 / np.sqrt(radius)


@njit(cache=True, nogil=True)
def product_at(c, x, z, q):
    """The matrix of mode q, c: (3, modes) rows xx, zz, c with xz = i c, zx = -i c, times (x, z)."""
    cx, cz, cc = c[0, q], c[1, q], c[2, q]
    return (
        complex(cx * x.real - cc * z.imag, cx * x.imag + cc * z.real),
        complex(cz * z.real + cc * x.imag, cz * z.imag - cc * x.real),
    )


@njit(cache=True, nogil=True)
def residual_at(u, traction, c, top, q):
    """(r_x, r_z) = U + C T - u of mode q."""
    r_x, r_z = product_at(c, traction[0, q], traction[1, q], q)
    r_x -= u[0, q]
    r_z -= u[1, q]
    if q == 0:
        r_x += top[0]
        r_z += top[1]
    return r_x, r_z


@njit(cache=True, nogil=True)
def _verlet_weighted(u, motion, traction, c, top, step, gamma):
    """One step of all modes with mass K; motion is the last change of u; c: the compliance, as in `product_at`."""
    keep = (1.0 - 0.5 * gamma * step) / (1.0 + 0.5 * gamma * step)
    push = step * step / (1.0 + 0.5 * gamma * step)
    for q in range(u.shape[1]):
        r_x, r_z = residual_at(u, traction, c, top, q)
        motion[0, q] = keep * motion[0, q] + push * r_x
        motion[1, q] = keep * motion[1, q] + push * r_z
        u[0, q] += motion[0, q]
        u[1, q] += motion[1, q]


@njit(cache=True, nogil=True)
def _verlet(u, motion, traction, k, top, step, gamma):
    """One step of all modes; motion is the last change of u; k: (3, modes) rows xx, zz, c."""
    keep = (1.0 - 0.5 * gamma * step) / (1.0 + 0.5 * gamma * step)
    push = step * step / (1.0 + 0.5 * gamma * step)
    for q in range(u.shape[1]):
        x, z = u[0, q], u[1, q]
        if q == 0:
            x -= top[0]
            z -= top[1]
        force_x = traction[0, q] - k[0, q] * x + 1j * k[2, q] * z
        force_z = traction[1, q] - k[1, q] * z - 1j * k[2, q] * x
        motion[0, q] = keep * motion[0, q] + push * force_x
        motion[1, q] = keep * motion[1, q] + push * force_z
        u[0, q] += motion[0, q]
        u[1, q] += motion[1, q]
