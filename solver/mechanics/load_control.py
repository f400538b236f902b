"""A held normal load: a problem at given height of the top, wrapped into one in which the height follows.

A dead weight: the top has no mass and bears no other force, so that the layer always carries p_0, the mean of T_z over
the cell. Unknowns: those of the problem, and the height U_z of the top, nm. Residual for the top: `scale` (p - p_0),
with `scale` a compliance that merely turns a pressure into nm. In the motion the uniform normal mode then has no
stiffness, and p_0 acts on it as a force.
"""

import numpy as np

from ..continuation.state import PulledOff
from .linearised import Linearised
from .surface import Surface


class LoadControl:
    """An `equilibrium.Equilibrium` under the mean normal traction `pressure`, GPa; the methods are those it has."""

    def __init__(self, problem, pressure):
        self.inner, self.pressure, self.contact, self.loading = problem, pressure, problem.contact, problem.loading
        self.unit, self.tolerance, self.nodes = problem.unit, problem.tolerance, problem.nodes
        self.size = problem.size + 1
        self.direction = np.append(problem.direction, 0.0)
        self.direction[self.nodes : -1] = 0.0
        scene = self.contact.scene
        self.scale = max(float(self.contact.modes.compliance[1, 0]), scene.delta_n**2 / scene.phi_n)  # nm/GPa
        self._surface = None

    @property
    def evaluations(self):
        """Force evaluations so far, of the contact."""
        return self.contact.evaluations

    def surface(self, v):
        """u (2, m) nm, a view of v."""
        return self.inner.surface(v[:-1])

    def top(self, v, s):
        """(U_x, U_z) of the top at load s, nm."""
        return self.loading.at(s)[0], float(v[-1])

    def undeformed(self, s):
        """The unknowns (size,), nm, of a layer that nothing acts on at load s, nm."""
        return np.append(self.inner.undeformed(s), self.loading.at(s)[1])

    def residual(self, v, active, s, out):
        """Fill out (size,) with R, nm; returns its largest magnitude. One force evaluation."""
        worst = self.inner.residual_under(v[:-1], active, self.top(v, s), out[:-1])
        out[-1] = self.scale * (self.contact.pressure(self.contact.last_traction) - self.pressure)
        return max(worst, abs(out[-1]))

    def traction(self, v, active):
        """T (2, m), GPa; a new array."""
        return self.inner.traction(v[:-1], active)

    def active(self, v, s, before=None, settled=None):
        """As of the problem; raises PulledOff if no node interacts and the load is tensile."""
        active = self.inner.active(v[:-1], s, before, settled)
        if self.pressure < 0.0 and not active.any():
            raise PulledOff(
                f"The contact has pulled off at U_x = {round(self.loading.at(s)[0], 6) + 0.0:g} nm: the motion that"
                f" began there under the held load L_bar = {self.pressure / self.contact.scene.E:.4g} led away from the"
                " surface; hold delta instead, or press harder"
            )
        return active

    def preconditioner(self, v, active, sharp=False):
        """That of the problem; a sharp one is bordered by the height that keeps the load."""
        inner = self.inner.preconditioner(v[:-1], active, sharp)
        if inner is None or not sharp:
            return inner and (lambda r: np.append(inner(r[:-1]), r[-1]))
        J = self.contact.tangents(self.surface(v), active)
        raised = inner(np.repeat([0.0, 1.0], self.nodes))  # by a unit of height
        gained = self.pressure_of(J, raised)
        if gained == 0.0:
            return None

        def bordered(r):
            w = inner(r[:-1])
            height = -(r[-1] / self.scale + self.pressure_of(J, w)) / gained
            return np.append(w + height * raised, height)

        return bordered

    def pressure_of(self, J, w):
        """Mean of the normal traction J w over the cell, GPa, of J (4, m) GPa/nm and w (2 m,) nm."""
        x, z = self.inner.surface(w)
        return self.contact.pressure([None, J[2] * x + J[3] * z])

    def grown(self, v, active, s, hidden=False):
        """As of the problem."""
        wider = self.inner.grown_under(v[:-1], active, self.top(v, s), hidden)
        return wider and (LoadControl(wider[0], self.pressure), np.append(wider[1], v[-1]), wider[2])

    def linearised(self, v, active):
        """The HeldLinearised at an equilibrium."""
        return HeldLinearised(self.motion(), v, active)

    def motion(self):
        """The HeldSurface, whose rests are the equilibria of this problem."""
        if self._surface is None:
            self._surface = HeldSurface(self)
        return self._surface


class HeldSurface(Surface):
    """The motion under a top that carries the load: the uniform normal mode is free, and the load pulls at it."""

    def __init__(self, problem):
        super().__init__(problem)
        self.stiffness = self.stiffness.copy()
        self.stiffness[1, 0] = 0.0

    def unknowns(self, y):
        """v (size,), nm, of y; the top is where the layer carries the load."""
        height = float(y[1, 0].real) / self.count - float(self.compliance[1, 0]) * self.problem.pressure
        return np.append(self._displacement(y), height)

    def force(self, y, active, s):
        """That of Surface, less the load."""
        spectrum = super().force(y, active, s)
        spectrum[1, 0] -= self.problem.pressure * self.count
        return spectrum


class HeldLinearised(Linearised):
    """A Linearised with the top's height as the last unknown."""

    def tangent(self, w):
        """As of Linearised; w (problem size,)."""
        problem, out = self.surface.problem, super().tangent(w[:-1])
        out[self.m :] += w[-1]
        return np.append(out, problem.scale * problem.pressure_of(self.J, w[:-1]))

    def _unknowns(self, field):
        return np.append(super()._unknowns(field), field[1].mean())  # the layer bears the same load

    def _load(self, field):
        scale = self.surface.problem.scale
        return np.append(super()._load(field), scale * field[1].sum() / self.surface.count)

    def _raised(self, w, field):
        field[1] += w[-1]
        return field

    def _stiffness_of_waves(self):
        k = super()._stiffness_of_waves().copy()
        k[1, 0] = 0.0
        return k
