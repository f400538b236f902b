"""A held normal load, as of a dead weight: the contact as a problem whose unknowns include the height of the top.

The top has no mass and bears no other force, so the layer always carries p_0, the mean of T_z over the cell. Unknowns:
those at a given height, and the height U_z of the top, nm. Residual of the top: `scale` (p - p_0), with a compliance
`scale` that turns a pressure into nm. In the motion the uniform normal mode has no stiffness, and p_0 is a force on it.
"""

import numpy as np

from ..continuation.state import PulledOff
from .equilibrium import Equilibrium
from .linearised import Linearised
from .surface import Surface


class HeldSurface(Surface):
    """The motion of a surface under a held load: the uniform normal mode is free, and the load acts on it."""

    def __init__(self, problem):
        super().__init__(problem)
        self.stiffness = self.stiffness.copy()
        self.stiffness[1, 0] = 0.0

    def unknowns(self, y) -> np.ndarray:
        """v (size,), nm, of y, with the top at the height where the layer carries the load; a new array."""
        height = float(y[1, 0].real) / self.count - float(self.compliance[1, 0]) * self.problem.pressure
        return np.append(self._displacement(y), height)

    def force(self, y, active, s) -> np.ndarray:
        """As of Surface, less the load."""
        spectrum = super().force(y, active, s)
        spectrum[1, 0] -= self.problem.pressure * self.count
        return spectrum


class HeldLinearised(Linearised):
    """A Linearised with the top's height as the last unknown."""

    def tangent(self, w):
        """As of Linearised; w (problem size,)."""
        problem, out = self.surface.problem, super().tangent(w[:-1])
        out[self.m :] += w[-1]
        return np.append(out, problem.scale * problem.pressure_of(self.J, w))

    def transposed(self, w):
        """As of Linearised; w (problem size,)."""
        out = super().transposed(w)
        out[-1] = w[self.m : -1].sum()
        return out

    def by_traction(self, w):
        """As of Linearised; the height's residual is the pressure's."""
        out = super().by_traction(w)
        out[1] += self.surface.problem.scale * w[-1] / self.surface.count
        return out

    def mirrored(self, w):
        """As of Linearised: C J w + w[-1] is w, and its mirror image carries the height as a pressure."""
        return np.append(super().mirrored(w), w[-1] * self.surface.count / self.surface.problem.scale)

    def matrix(self):
        """As of Linearised."""
        inner, column = super().matrix(), np.repeat([0.0, 1.0], self.m)
        rise = self.surface.problem.scale / self.surface.count * self.J[2:].ravel()
        return None if inner is None else np.block([[inner, column[:, None]], [rise, 0.0]])

    def _unknowns(self, field):
        return np.append(super()._unknowns(field), field[1].mean())  # the layer bears the same load

    def _load(self, field):
        scale = self.surface.problem.scale
        return np.append(super()._load(field), scale * field[1].sum() / self.surface.count)

    def _raised(self, w, x, force):
        x[1] += w[-1]
        force[1] -= force[1].mean()  # the uniform mode has no stiffness


class LoadControl(Equilibrium):
    """The Contact under the mean normal traction `pressure`, GPa, driven along a Loading; its U_z plays no role."""

    dynamics, disturbed = HeldSurface, HeldLinearised

    def __init__(self, contact, loading, pressure):
        super().__init__(contact, loading)
        self.pressure, scene = pressure, contact.scene
        self.size += 1
        self.direction = np.append(self.direction, 0.0)
        self.direction[self.nodes :] = 0.0
        self.scale = max(float(contact.modes.compliance[1, 0]), scene.delta_n**2 / scene.phi_n)  # nm/GPa

    def on(self, contact) -> "LoadControl":
        """The same problem on another patch."""
        return LoadControl(contact, self.loading, self.pressure)

    def top(self, v, s) -> tuple[float, float]:
        """(U_x, U_z) of the top at load s, nm."""
        return self.loading.at(s)[0], float(v[-1])

    def undeformed(self, s) -> np.ndarray:
        """The unknowns (size,), nm, of a layer without tractions at load s, nm."""
        return np.append(super().undeformed(s), self.loading.at(s)[1])

    def residual(self, v, active, s, out) -> float:
        """Fill out (size,) with R, nm; returns its largest magnitude. One force evaluation."""
        worst = super().residual(v, active, s, out)
        out[-1] = self.scale * (self.contact.pressure(self.contact.last_traction[1]) - self.pressure)
        return max(worst, abs(out[-1]))

    def active(self, v, s, before=None, settled=None) -> np.ndarray:
        """As at a given height; raises PulledOff if the load is tensile and no node interacts."""
        active = super().active(v, s, before, settled)
        if self.pressure < 0.0 and not active.any():
            raise PulledOff(
                f"The contact has pulled off at U_x = {round(self.loading.at(s)[0], 6) + 0.0:g} nm: the motion that"
                f" began there under the held load L_bar = {self.pressure / self.contact.scene.E:.4g} led away from the"
                " surface; hold delta instead, or press harder"
            )
        return active

    def preconditioner(self, v, active):
        """As at a given height, bordered by the height that keeps the load."""
        inner = super().preconditioner(v, active)
        if inner is None:
            return None
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

    def pressure_of(self, J, w) -> float:
        """Mean of the normal traction J w over the cell, GPa, of J (4, m) GPa/nm and w, nm."""
        x, z = self.surface(w)
        return self.contact.pressure(J[2] * x + J[3] * z)
