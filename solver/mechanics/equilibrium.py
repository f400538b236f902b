"""The contact as a problem R(v; s) = 0, under the contract of `continuation.problem`.

Unknowns: the displacement of the patch, v = (u_x, u_z), nm. Residual: R = U(s) + C T(u) - u, nm.
Under a held normal load, as of a dead weight, the height U_z of the top is one more unknown, nm. The top has no mass
and bears no other force, so the layer always carries p_0, the mean of T_z over the cell. Residual of the top:
`scale` (p - p_0), with a compliance `scale` that turns a pressure into nm.
"""

from copy import copy

import numpy as np

from ..continuation.state import PulledOff
from ..continuation.vectors import evaluate, largest
from .kernels import Callback, residual, subtract
from .linearised import Linearised
from .surface import Surface


class Equilibrium:
    """The Contact driven along a Loading; attributes as of `continuation.problem.Problem`.

    pressure: the mean normal traction that is held, GPa; U_z of the Loading then plays no role. None: the Loading
    gives the height of the top.
    """

    def __init__(self, contact, loading, pressure=None):
        scene = contact.scene
        self.contact, self.loading, self.pressure, self.held = contact, loading, pressure, pressure is not None
        self.unit, self.tolerance = min(scene.delta_n, scene.delta_t), scene.tolerance
        self.nodes = contact.size  # m
        self.size = 2 * self.nodes + self.held
        along_x, along_z = loading.direction
        self.direction = self._unknowns(along_x, 0.0 if self.held else along_z, 0.0)
        self.scale = max(float(contact.modes.compliance[1, 0]), scene.delta_n**2 / scene.phi_n)  # nm/GPa
        self._motion, self._residual = None, None
        if contact.layer.fft.plans:
            held = {"held": self.held, "scale": self.scale, "pressure": pressure or 0.0}
            self._residual = Callback(residual, contact, contact.layer.fft, 0, contact.layer.blocks, **held)

    def solved_to(self, tolerance) -> "Equilibrium":
        """The same problem with another tolerance, nm."""
        other = copy(self)
        other.tolerance, other._motion = tolerance, None
        return other

    def _unknowns(self, x, z, height):
        """The unknowns (size,) of a patch whose nodes all move by (x, z) under a top at a height, nm."""
        return np.repeat([x, z, height], [self.nodes, self.nodes, int(self.held)]).astype(float)

    @property
    def evaluations(self) -> int:
        """Force evaluations so far, of the contact."""
        return self.contact.evaluations

    def surface(self, v) -> np.ndarray:
        """u (2, m) nm, a view of v."""
        return v[: 2 * self.nodes].reshape(2, self.nodes)

    def top(self, v, s) -> tuple[float, float]:
        """(U_x, U_z) of the top at load s, nm."""
        U_x, U_z = self.loading.at(s)
        return U_x, float(v[-1]) if self.held else U_z

    def undeformed(self, s) -> np.ndarray:
        """The unknowns (size,), nm, of a layer without tractions at load s, nm."""
        U_x, U_z = self.loading.at(s)
        return self._unknowns(U_x, U_z, U_z)

    def residual(self, v, s, out) -> float:
        """Fill out (size,) with R, nm; returns its largest magnitude. One force evaluation."""
        if compiled := self.compiled(s):
            self.contact.evaluated()
            return evaluate(*compiled, np.ascontiguousarray(v), out)  # addresses say nothing of strides
        displaced_x, displaced_z = self.contact.response(self.surface(v))
        subtract(v, displaced_x, displaced_z, *self.top(v, s), out)
        if self.held:
            out[-1] = self.scale * (self.contact.pressure(self.contact.last_traction[1]) - self.pressure)
        return largest(out)

    def compiled(self, s) -> tuple[int, int] | None:
        """As of `continuation.problem.Problem`."""
        return self._residual and self._residual.at(*self.loading.at(s))

    def evaluated(self, times) -> None:
        """Count force evaluations of compiled loops."""
        self.contact.evaluated(times=times)

    def traction(self, v) -> np.ndarray:
        """T (2, m), GPa; a new array."""
        return self.contact.traction(self.surface(v))

    def everywhere(self, v, s) -> np.ndarray:
        """Displacement of all nodes of the cell, (2, nodes of the cell) nm; a new array.

        The tractions of the patch displace the nodes outside; nodes of the patch keep their displacement in v. That
        matters if v is not quite an equilibrium: a small change may lead a transient to another one.
        """
        surface, part, T = self.motion(), self.contact.part, np.zeros((2, self.contact.nodes))
        T[:, part] = self.traction(v)
        out = surface.through(T, surface.operators[1]) + np.array(self.top(v, s))[:, None]
        # where v is no equilibrium, the force on a soft drive says little of where the top is; the patch does
        out += self.contact.modes.drawn[:, None] * (self.surface(v) - out[:, part]).mean(axis=1, keepdims=True)
        out[:, part] = self.surface(v)
        return out

    def hold(self, v, s) -> None:
        """Raise PulledOff if a held load is tensile and no node is as near as where the approach begins."""
        if self.held and self.pressure < 0.0 and self.contact.distance(self.surface(v)) > self.contact.scene.delta_0:
            U_x, L = round(self.loading.at(s)[0], 6) + 0.0, self.pressure * self.contact.scene.width
            where = f"The contact has pulled off at U_x = {U_x:g} nm under the held load L = {L:.4g} N/m"
            raise PulledOff(f"{where}: the motion that began there led away from the surface")

    def sites(self, v, w) -> float:
        """By how many sites of the lattice the node that moves farthest along it lies elsewhere in w than in v."""
        return float(np.abs((w - v)[: self.nodes]).max()) / self.contact.scene.spacing

    def alike(self, v) -> bool:
        """Whether all nodes are alike in v, to 1e-5 units, which the solves of followed states leave."""
        flat = self.contact.scene.surface == "flat"
        return flat and bool(np.ptp(self.surface(v), axis=1).max() <= 1e-5 * self.unit)

    def linearised(self, v) -> Linearised:
        """The Linearised at an equilibrium."""
        return Linearised(self.motion(), v)

    def motion(self) -> Surface:
        """The Surface, whose rests are the equilibria of this problem."""
        if self._motion is None:
            self._motion = Surface(self)
        return self._motion
