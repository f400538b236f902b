"""The motion of the whole surface, whose rests are the equilibria: the Dynamics of `continuation.problem`."""

from functools import cached_property

import numpy as np

from . import cohesive_law
from .layer import multiply, transforms


class Surface:
    """y (2, modes): the Fourier coefficients of u, of unit mass each (paper section 2.1), above one Contact.

    One node for all has the uniform mode alone. Buffers belong to this object.

    Attributes: stiffness (3, modes) GPa/nm in rows xx, zz, c, as of `layer.Modes`; critical: 2 sqrt(k_min), 1/time, the
    friction that is critical for the slowest mode of the layer.
    """

    def __init__(self, problem):
        self.problem, contact = problem, problem.contact
        self.contact, modes = contact, contact.modes
        k_xx, k_zz, k_c = modes.stiffness
        least = 0.5 * (k_xx + k_zz) - np.hypot(0.5 * (k_xx - k_zz), k_c)
        self.critical = 2.0 * float(np.sqrt(least.min()))
        last = 1 if contact.uniform else None
        self.stiffness, self.compliance = modes.stiffness[:, :last], modes.compliance[:, :last]
        self.count = 1 if contact.uniform else contact.nodes
        self.patch = slice(contact.first, contact.first + contact.size)
        if not contact.uniform:
            self._field, self._u, self._spectrum, self._forward, self._backward = transforms(self.count)

    def start(self, v, active, s):
        """y of the surface at rest in v, complex (2, modes); outside the patch it follows from the traction inside."""
        problem, u = self.problem, self.problem.surface(v)
        if self.contact.uniform:
            return u.astype(complex)
        self._field[:] = 0.0
        self._field[:, self.patch] = problem.traction(v, active)
        self._forward()
        y = self.contact.modes.displacement(self._spectrum)
        y[:, 0] += np.array(problem.top(v, s)) * self.count
        # v is not quite an equilibrium: the patch is put where v has it, not where its traction would
        # put it, as a tenth of that difference may decide which rest the motion reaches
        self._field[:, self.patch] = u - self._displacement(y)
        self._forward()
        return y + self._spectrum

    def _displacement(self, y):
        """u (2, m) on the patch, nm; a buffer."""
        if self.contact.uniform:
            return np.ascontiguousarray(y.real)
        self._spectrum[:] = y
        self._backward()
        self._u *= 1.0 / self.count
        return self._u[:, self.patch]

    def unknowns(self, y):
        """v (size,), nm, of y; a new array."""
        return self._displacement(y).reshape(-1).copy()

    def force(self, y, active, s):
        """T + K U in the coordinates y, complex (2, modes), a buffer; counts as a force evaluation."""
        contact = self.contact
        contact.count()
        u = self._displacement(y)
        if contact.uniform:
            spectrum = contact.traction(u, active).astype(complex)
        else:
            field = self._field[:, self.patch]
            cohesive_law.tractions(u, contact.profile, active, contact.law, contact.work, field, contact.size)
            self._forward()
            spectrum = self._spectrum
        U_x, U_z = self.problem.loading.at(s)
        spectrum[0, 0] += self.stiffness[0, 0] * U_x * self.count
        spectrum[1, 0] += self.stiffness[1, 0] * U_z * self.count
        return spectrum

    @cached_property
    def operators(self):
        """K and C as blocks for `through`, (3, modes) each, in rows xx, zz, c of `layer.multiply`."""
        signs = np.array([[1.0], [1.0], [-1.0]])  # K_xz = -i K_c, but C_xz = +i C_c
        return self.stiffness * (signs / self.count), self.compliance * (1.0 / self.count)

    def through(self, field, blocks):
        """A field (2, nodes) times one of the `operators`; a buffer."""
        self._field[:] = field
        self._forward()
        multiply(self._spectrum, blocks)
        self._backward()
        # `force` fills the patch alone, and relies on zeros elsewhere
        self._field[:] = 0.0
        return self._u

    def interface(self, v, active):
        """The largest stiffness of the interface in v, GPa/nm: a bound on dT/du by row sums."""
        t = np.abs(self.contact.tangents(self.problem.surface(v), active))
        return float(max((t[0] + t[1]).max(), (t[2] + t[3]).max()))


def closed_stiffness(scene):
    """Stiffness of a node in registry and in touch, the larger of both directions, GPa/nm."""
    tangent = cohesive_law.tangent(scene, 0.0, 0.0)
    return float(max(-tangent[0], -tangent[3]))
