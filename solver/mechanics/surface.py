"""The motion of the whole surface, whose rests are the equilibria: the Dynamics of `continuation.problem`."""

from functools import cached_property

import numpy as np

from ..continuation.motion import of_blocks
from . import cohesive_law
from .layer import multiply, transforms

SIGNS = np.array([[1.0], [1.0], [-1.0]])  # K_xz = -i K_c, but C_xz = +i C_c


class Surface:
    """y (2, modes): the Fourier coefficients of u, of unit mass each (paper section 2.1), above one Contact.

    Buffers belong to this object.

    Attributes: stiffness (3, modes) GPa/nm in rows xx, zz, c, as of `layer.Modes`; critical: 2 sqrt(k_min), 1/time, the
    friction that is critical for the slowest mode of the layer.
    """

    def __init__(self, problem):
        self.problem, self.contact = problem, problem.contact
        self.critical = self.contact.modes.critical
        self.stiffness, self.compliance = self.contact.cell.stiffness, self.contact.cell.compliance
        self.count, self.patch = self.contact.count, self.contact.part
        self._field, self._u, self._spectrum, self._forward, self._backward = transforms(self.count)

    def start(self, v, active, s):
        """y of the surface at rest in v, complex (2, modes); outside the patch it follows from the traction inside."""
        problem, u = self.problem, self.problem.surface(v)
        self._field[:] = 0.0
        self.contact.fill(u, active, self._field[:, self.patch])
        self._forward()
        y = self._spectrum.copy()
        multiply(y, self.compliance)
        y[:, 0] += np.array(problem.top(v, s)) * self.count
        # v is not quite an equilibrium: the patch is put where v has it, not where its traction would
        # put it, as a tenth of that difference may decide which rest the motion reaches
        self._field[:, self.patch] = u - self._displacement(y)
        self._forward()
        return y + self._spectrum

    def _displacement(self, y):
        """u (2, m) on the patch, nm; a buffer."""
        self._spectrum[:] = y
        self._backward()
        self._u *= 1.0 / self.count
        return self._u[:, self.patch]

    def unknowns(self, y):
        """v (size,), nm, of y; a new array."""
        return self._displacement(y).reshape(-1).copy()

    def force(self, y, active, s):
        """T + K U in the coordinates y, complex (2, modes), a buffer; counts as a force evaluation."""
        self.contact.evaluated()
        self.contact.fill(self._displacement(y), active, self._field[:, self.patch])
        self._forward()
        U_x, U_z = self.problem.loading.at(s)
        self._spectrum[0, 0] += self.stiffness[0, 0] * U_x * self.count
        self._spectrum[1, 0] += self.stiffness[1, 0] * U_z * self.count
        return self._spectrum

    @cached_property
    def operators(self):
        """K and C as blocks for `through`, (3, modes) each, in rows xx, zz, c of `layer.multiply`."""
        return self.stiffness * (SIGNS / self.count), self.compliance * (1.0 / self.count)

    @cached_property
    def noise(self):
        """The noise of a Linearised, (2 nodes,): K^1/2 g with normal deviates g.

        The answer to g itself is of long waves only, to the accuracy of a solve; that to K g mostly of short ones.
        """
        least = 0.25 * self.critical**2  # k_min; also for the mode that a held load leaves without stiffness
        root = of_blocks(self.stiffness, lambda k: np.sqrt(np.maximum(k, least))) * (SIGNS / self.count)
        return self.through(np.random.default_rng(1).normal(size=(2, self.count)), root).reshape(-1).copy()

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
