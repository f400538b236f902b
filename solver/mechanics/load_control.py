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
        self.size, self.place = problem.size + 1, problem.place
        self.direction = np.append(problem.direction, 0.0)
        self.direction[self.nodes : -1] = 0.0
        scene = self.contact.scene
        self.scale = max(float(self.contact.modes.compliance[1, 0]), scene.delta_n**2 / scene.phi_n)  # nm/GPa
        self._surface = None

    @property
    def evaluations(self):
        return self.contact.evaluations

    def surface(self, v):
        """u (2, m) nm, a view of v."""
        return self.inner.surface(v[:-1])

    def top(self, v, s):
        """(U_x, U_z) of the top, nm."""
        return self.loading.at(s)[0], float(v[-1])

    def undeformed(self, s):
        """The unknowns of a layer that nothing acts on."""
        return np.append(self.inner.undeformed(s), self.loading.at(s)[1])

    def residual(self, v, active, s, out):
        """Fill out (size,) with R, nm; returns its largest magnitude."""
        worst = self.inner.residual_under(v[:-1], active, self.top(v, s), out[:-1])
        out[-1] = self.scale * (self.contact.pressure(self.contact.last_traction) - self.pressure)
        return max(worst, abs(out[-1]))

    def traction(self, v, active):
        """T (2, m), GPa; a new array."""
        return self.inner.traction(v[:-1], active)

    def active_of(self, v, s):
        """Nodes within the interaction window; raises PulledOff if there are none and the load is tensile."""
        active = self.inner.active_of(v[:-1], s)
        if self.pressure < 0.0 and not active.any():
            raise PulledOff(
                f"The contact has pulled off at U_x = {round(self.loading.at(s)[0], 6) + 0.0:g} nm: the motion that"
                f" began there under the held load L_bar = {self.pressure / self.contact.scene.E:.4g} led away from the"
                " surface; hold delta instead, or press harder"
            )
        return active

    def admitted(self, v, active, settled=None):
        """As `Contact.admitted`."""
        return self.inner.admitted(v[:-1], active, settled)

    def smoother(self, v, active):
        """That of the problem; the height is left as it is."""
        smooth = self.inner.smoother(v[:-1], active)
        return smooth and (lambda r: np.append(smooth(r[:-1]), r[-1]))

    def inverse(self, v, active):
        """The inverse of the problem, bordered by the height that keeps the load."""
        inverse = self.inner.inverse(v[:-1], active)
        if inverse is None:
            return None
        m = self.nodes
        J = self.contact.tangents(self.surface(v), active)

        def pressure(w):
            return self.contact.pressure([None, J[2] * w[:m] + J[3] * w[m:]])

        raised = inverse(np.repeat([0.0, 1.0], m))  # by a unit of height
        gained = pressure(raised)
        if gained == 0.0:
            return None

        def bordered(r):
            w = inverse(r[:-1])
            height = -(r[-1] / self.scale + pressure(w)) / gained
            return np.append(w + height * raised, height)

        return bordered

    def hides(self, v, active):
        """As of the problem: nodes that are alike under a held load have but one more free mode, which is shown."""
        return self.inner.hides(v[:-1], active)

    def oriented(self, mode):
        """As of the problem."""
        return np.copysign(1.0, self.inner.oriented(mode[:-1]) @ mode[:-1]) * mode

    def translated(self, v, distance):
        """The same state moved on along x by a distance (nm), a whole number of sites; a new array."""
        return np.append(self.inner.translated(v[:-1], distance), v[-1])

    def crowded(self, v, active, s):
        """Whether a node outside the patch may interact."""
        return self.inner.crowded_under(v[:-1], active, v[-1])

    def grown(self, v, active, s):
        """(the problem on a wider patch, v, active there), as of the problem."""
        wide, u, active = self.inner.grown_under(v[:-1], active, self.top(v, s))
        return LoadControl(wide, self.pressure), np.append(u, v[-1]), active

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
        """v of y; the top is where the layer carries the load."""
        height = float(y[1, 0].real) / self.count - float(self.compliance[1, 0]) * self.problem.pressure
        return np.append(self.displacement(y), height)

    def force(self, y, active):
        """T less the load, as of Surface."""
        spectrum = super().force(y, active)
        spectrum[1, 0] -= self.problem.pressure * self.count
        return spectrum


class HeldLinearised(Linearised):
    """A Linearised with the top's height as the last unknown."""

    def tangent(self, w):
        """As of Linearised; w (problem size,)."""
        out = super().tangent(w[:-1])
        out[self.m :] += w[-1]
        u = w[:-1].reshape(2, -1)
        return np.append(out, self.surface.problem.scale * self.contact.pressure([0.0, self.J[2] * u[0] + self.J[3] * u[1]]))

    def seen(self, x):
        """The unknowns of a disturbance; the top is as high as the surface on average."""
        return np.append(super().seen(x), x.reshape(2, -1)[1].mean())

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
