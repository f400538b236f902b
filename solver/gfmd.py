"""Damped Green's function molecular dynamics (paper section 2.1): the reference method.

Surface modes of unit mass move in Fourier space under T - K (u - U) - gamma du/dt, by the Verlet scheme with gamma
critical for the slowest mode, until max |U + C T(u) - u| is below the tolerance, at every increment.
"""

import numpy as np
from numba import njit

from . import np1
from .contact import Contact
from .layer import Modes, transforms
from .state import Increment, NotConverged, Slip, State

CHECK_EVERY = 20  # steps between two looks at the residual
SAFETY = 0.5  # of the largest stable time step
BUDGET = 1_000_000  # force evaluations of one increment
SLIPPED = 0.5  # of min(delta_n, delta_t), beyond twice the increment of the load: a larger move of a node is a slip


class Gfmd:
    """Advances States of one scene by damped dynamics of all modes; holds no state between calls but buffers."""

    def __init__(self, scene, first, size, leave_out=frozenset(), damping=1.0):
        """damping: in units of the critical damping of the slowest mode."""
        self.scene, self.contact = scene, Contact(scene, first, size)
        self._part = slice(first, first + size)
        self._modes = Modes.of(scene)
        self._traction, self._u, self._spectrum, self._forward, self._backward = transforms(scene.nodes)
        self._stiffest = float(np.max(np.maximum(self._modes.k_xx, self._modes.k_zz) + np.abs(self._modes.k_c)))
        slowest = float(min(self._modes.k_xx.min(), self._modes.k_zz.min()))
        self._gamma = 2.0 * damping * np.sqrt(slowest)
        self._r = np.empty((2, size))

    def undeformed(self, loading, load):
        """The State of a layer that nothing acts on."""
        u = self.contact.undeformed(loading.at(load))
        return State(load, u, self.contact.within_window(u))

    def increment(self, state, loading, target):
        """The equilibrium at load `target` that the damped motion from `state` reaches; raises NotConverged."""
        self.contact.residual(state.u, state.active, loading.at(state.load), self._r)
        before = self.contact.traction()
        u = state.u.copy()
        start = state.load

        def solve(chosen):
            nonlocal start
            self._settle(u, chosen, loading, start, target)
            start = target
            return True

        active = self.contact.settle(solve, u, state.active)
        residual = self.contact.residual(u, active, loading.at(target), self._r)
        farthest = SLIPPED * min(self.scene.delta_n, self.scene.delta_t) + 2.0 * abs(target - state.load)
        slipped = np.abs(u - state.u).max() > farthest
        slips = (Slip(state.load, state.u, before),) if slipped else ()
        return Increment(State(target, u, active), self.contact.traction(), residual, slips)

    def _settle(self, u, active, loading, load, target):
        """Bring u, in place, to rest at load `target`; the surface outside the patch starts in equilibrium with it."""
        contact, nodes = self.contact, self.scene.nodes
        limit = contact.evaluations + BUDGET
        self._traction[:] = 0.0
        traction, shape = self._traction[:, self._part], self._u[:, self._part]
        top = np.array(loading.at(target)) * nodes
        modes = self._equilibrium(u, active, loading.at(load), traction)
        motion = np.zeros_like(modes)
        step = self._time_step(u, active)
        while True:
            for _ in range(CHECK_EVERY):
                self._shape(modes)
                np1.tractions(shape, contact.profile, active, contact.law, contact.work, traction, contact.size)
                self._forward()
                _verlet(modes, motion, self._spectrum, self._modes.stiffness, top, step, self._gamma)
                contact.evaluations += 1
            self._shape(modes)
            u[:] = shape
            residual = contact.residual(u, active, loading.at(target), self._r)
            if residual <= self.scene.tolerance:
                return
            if not np.isfinite(residual) or contact.evaluations > limit:
                raise NotConverged(
                    f"Not converged at {loading.name} = {target:.6g} nm: residual {residual:.2g} nm after {BUDGET}"
                    " force evaluations of gfmd; try a larger tolerance, a smaller du_x or du_z, or method fast"
                )
            smaller = self._time_step(u, active)
            motion *= smaller / step
            step = smaller

    def _shape(self, modes):
        """Displacement of the surface from its modes."""
        self._spectrum[:] = modes
        self._backward()
        self._u *= 1.0 / self.scene.nodes

    def _equilibrium(self, u, active, load, traction):
        """Modes of the whole surface, U + C T(u)."""
        np1.tractions(u, self.contact.profile, active, self.contact.law, self.contact.work, traction, self.contact.size)
        self._forward()
        modes = self._modes.displacement(self._spectrum)
        modes[:, 0] += np.array(load) * self.scene.nodes
        return modes

    def _time_step(self, u, active):
        tangents = np.empty((4, self.contact.size))
        np1.tangents(u, self.contact.profile, active, self.contact.law, self.contact.work, tangents)
        tangents = np.abs(tangents)
        interface = max((tangents[0] + tangents[1]).max(), (tangents[2] + tangents[3]).max())
        return SAFETY * 2.0 / np.sqrt(self._stiffest + interface)


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
