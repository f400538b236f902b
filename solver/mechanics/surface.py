"""The transient of the whole surface, whose rests are the equilibria: the Dynamics of `continuation.problem`."""

from functools import cached_property
from math import e, inf

import numpy as np

from ..continuation.motion import of_blocks
from . import cohesive_law
from .kernels import Callback, force
from .layer import Modes, Transform

SIGNS = np.array([[1.0], [1.0], [-1.0]])  # K_xz = -i K_c, but C_xz = +i C_c


class Surface:
    """y (2, modes): the Fourier coefficients of u, each of unit mass (paper section 2.1), for one Equilibrium.

    Owns its buffers. Under a held load the uniform normal mode has no stiffness, and the load acts on it.

    Attributes: stiffness, compliance (3, modes) GPa/nm and nm/GPa, as of `layer.Modes`; count, nodes of the cell, and
    patch, the slice of them that can interact; critical, 1/time, the critical damping of the layer's slowest mode.
    """

    def __init__(self, problem):
        self.problem, self.contact = problem, problem.contact
        self.critical = self.contact.modes.critical
        self.stiffness, self.compliance = self.contact.modes.stiffness, self.contact.modes.compliance
        self.count, self.patch = self.contact.nodes, self.contact.part
        if problem.held:
            self.stiffness = self.stiffness.copy()
            self.stiffness[1, 0] = 0.0
        self._fft = Transform(self.count)
        plans, first = self._fft.plans, self.contact.first
        self._force = plans and Callback(force, self.contact, self._fft, first, self.compliance)

    def start(self, v, s) -> np.ndarray:
        """y, complex (2, modes), of the surface at rest in v under the load s."""
        self._fft.field[:] = self.problem.everywhere(v, s)
        self._fft.forward()
        self._fft.field[:] = 0.0
        return self._fft.spectrum.copy()

    def _displacement(self, y):
        """u (2, m) on the patch, nm; a buffer."""
        self._fft.spectrum[:] = y
        self._fft.backward()
        self._fft.product *= 1.0 / self.count
        return self._fft.product[:, self.patch]

    def unknowns(self, y) -> np.ndarray:
        """v (size,), nm, of y, with the top at the height where the layer carries a held load; a new array."""
        u = self._displacement(y).reshape(-1)
        if not self.problem.held:
            return u.copy()
        return np.append(u, float(y[1, 0].real) / self.count - float(self.compliance[1, 0]) * self.problem.pressure)

    def force(self, y, s) -> np.ndarray:
        """T + K U less a held load, in the coordinates y, complex (2, modes), a buffer; one force evaluation."""
        self.contact.evaluated(self, y, s)
        self.contact.traction(self._displacement(y), self._fft.field[:, self.patch])
        self._fft.forward()
        self._fft.spectrum[:, 0] += self._by_top(s)
        return self._fft.spectrum

    def _by_top(self, s):
        """(x, z), what the top adds to the force on the uniform mode; a held load adds to that along z."""
        U_x, U_z = self.problem.loading.at(s)
        x, z = self.stiffness[0, 0] * U_x * self.count, self.stiffness[1, 0] * U_z * self.count
        return x, z - self.problem.pressure * self.count if self.problem.held else z

    def compiled(self, s) -> tuple | None:
        """As of `continuation.problem.Dynamics`; None while each step of a motion is observed."""
        if not self._force or getattr(self.contact.observe, "every_step", False):
            return None
        return *self._force.at(*self._by_top(s)), self._fft.spectrum

    def evaluated(self, times) -> None:
        """Count force evaluations of compiled loops."""
        self.contact.evaluated(times=times)

    @cached_property
    def operators(self) -> tuple[np.ndarray, np.ndarray]:
        """K and C as blocks for `through`, (3, modes) each, in rows xx, zz, c of `layer.multiply`."""
        return self.stiffness * (SIGNS / self.count), self.compliance * (1.0 / self.count)

    @cached_property
    def noise(self) -> np.ndarray:
        """The noise of a Linearised, (2 nodes,): K^1/2 g with normal deviates g.

        The response to g itself consists of long waves only, that to K g mostly of short ones.
        """
        least = 0.25 * self.critical**2  # k_min; also for the mode that a held load leaves without stiffness
        root = of_blocks(self.stiffness, lambda k: np.sqrt(np.maximum(k, least))) * (SIGNS / self.count)
        return self.through(np.random.default_rng(1).normal(size=(2, self.count)), root).reshape(-1).copy()

    def through(self, field, blocks) -> np.ndarray:
        """A field (2, nodes) times one of the `operators`; a buffer."""
        self._fft.field[:] = field
        self._fft.apply(blocks)
        self._fft.field[:] = 0.0  # `force` fills the patch alone
        return self._fft.product

    def interface(self, v) -> float:
        """The largest stiffness of the interface in v, GPa/nm: a bound on dT/du by row sums."""
        return self.contact.stiffest(self.problem.surface(v))


def least_modulus(scene) -> float:
    """Young's modulus, GPa, from which the surfaces can rest apart at delta_0, where an approach begins; inf: at none.

    To first order the attraction T draws the surface down by C T. Nearer it grows as exp(u/delta_n), and u = c exp(u)
    has a solution up to c = 1/e: so C T must not exceed delta_n/e. Of C, all but the drive's share falls as 1/E.
    """
    T = cohesive_law.traction(scene, np.zeros(scene.nodes), scene.profile + scene.delta_0)[1]
    drawn = -np.fft.irfft(Modes.of(scene).compliance[1] * np.fft.rfft(T), scene.nodes)
    most = float(drawn.max())
    by_drive = -scene.drive_compliance[1] * float(T.mean())
    room = scene.delta_n / e - by_drive
    return scene.E * (most - by_drive) / room if room > 0.0 else inf


def too_soft(scene) -> str:
    """What to do where the surfaces cannot rest apart at delta_0, where an approach begins; "" where they can."""
    least = least_modulus(scene)
    if least <= scene.E:
        return ""
    return f"use E={1.01 * least:.3g} or more" if least < inf else "use a larger drive_n, or a smaller phi_n"


def closed_stiffness(scene) -> float:
    """Stiffness of a node in registry and in touch, the larger of both directions, GPa/nm."""
    tangent = cohesive_law.tangent(scene, 0.0, 0.0)
    return float(max(-tangent[0], -tangent[3]))
