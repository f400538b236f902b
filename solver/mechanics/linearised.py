"""An equilibrium linearised: J = dT/du, the layer K, their difference, and the tangent dR/dv of the problem.

A small disturbance x (2, n) nm of all n nodes of the cell, flattened, obeys x'' = (J - K) x - gamma x', with J zero
outside the patch. By Parseval's theorem its Euclidean inner product is that of Fourier modes of unit mass.
The compliance C is symmetric, J is not: (C J - 1)^T = J^T C - 1.
Under a held load the height of the top is the last unknown.
"""

import numpy as np

from ..continuation.compiled import kernel
from ..continuation.state import TINY
from .cohesive_law import add_product, alike
from .flutter import safe_friction

FORMED = 1200  # nodes up to which a tangent is formed; for more, iterative solves take less time
ACTING = 1e-8  # of the stiffest node; a solve leaves out softer ones, which are far apart, and corrects that once


class Linearised:
    """The Linearised of `continuation.problem`, at one equilibrium v of an `equilibrium.Equilibrium`.

    Attributes: u (2, m) nm; J on the patch, (4, m) GPa/nm, rows as of `cohesive_law.tangents`; size, of a disturbance.
    """

    def __init__(self, surface, v):
        self.surface, self.contact, self.m = surface, surface.contact, surface.contact.size
        self.u = surface.problem.surface(v)
        self.J = self.contact.tangents(self.u)
        self.problem, self.size = surface.problem, 2 * surface.count
        self.scale = self.problem.scale / surface.count  # of the sum of T_z, to the residual of the top

    @property
    def noise(self) -> np.ndarray:
        """As of Surface."""
        return self.surface.noise

    def tangent(self, w) -> np.ndarray:
        """dR/dv w, a new array of w's shape (problem size,), nm; counts as a force evaluation."""
        out = self.complied(self.pull(w))
        out[: 2 * self.m] -= w[: 2 * self.m]
        if self.problem.held:
            out[self.m : -1] += w[-1]
        return out

    def complied(self, T) -> np.ndarray:
        """What tractions T (2, m), GPa, add to R, (problem size,) nm; a new array; counts as a force evaluation."""
        out = np.empty(self.problem.size)
        out[: 2 * self.m] = self.contact.comply(T).reshape(-1)
        if self.problem.held:
            out[-1] = self.problem.scale * self.contact.pressure(T[1])
        return out

    def transposed(self, w) -> np.ndarray:
        """(dR/dv)^T w, a new array (problem size,); counts as a force evaluation."""
        out = self.by_unknowns(self.by_traction(w))
        out[: 2 * self.m] -= w[: 2 * self.m]
        if self.problem.held:
            out[-1] = w[self.m : -1].sum()
        return out

    def by_traction(self, w) -> np.ndarray:
        """<w, R> differentiated by the tractions, (2, m) nm/GPa; a new array; counts as a force evaluation."""
        out = self.contact.comply(w[: 2 * self.m].reshape(2, -1)).copy()
        if self.problem.held:
            out[1] += self.scale * w[-1]
        return out

    def by_unknowns(self, gradient, J=None) -> np.ndarray:
        """A gradient (2, m) by the tractions as one by the unknowns (problem size,): J^T gradient; J: another one."""
        out = np.zeros(self.surface.problem.size)
        J = self.J if J is None else J
        add_product(J[[0, 2, 1, 3]], gradient, out[: 2 * self.m].reshape(2, -1))
        return out

    def pull(self, w, J=None) -> np.ndarray:
        """J w, (2, m), of unknowns w (problem size,); J: another one; a new array."""
        out = np.zeros((2, self.m))
        add_product(self.J if J is None else J, w[: 2 * self.m].reshape(2, -1), out)
        return out

    def mirrored(self, w) -> np.ndarray:
        """The left null vector (problem size,) of dR/dv with the right one w, if J were symmetric: J w.

        Under a held load C J w + w[-1] is w, and the mirror image of w carries the height as a pressure.
        """
        return np.append(self.pull(w).reshape(-1), w[-1] / self.scale if self.problem.held else ())

    def slopes(self, right, left) -> np.ndarray:
        """<left, dR/dv right> differentiated by the unknowns, (problem size,): the change of J along `right`."""
        return self.by_unknowns(self.by_traction(left), self.bends(right)[0])

    def bends(self, w, tangents=None) -> tuple[np.ndarray, np.ndarray]:
        """The first and second derivative of J along the unknowns w (problem size,), (4, m) each.

        tangents: the function from u to J, in place of the contact's.
        """
        way, J = w[: 2 * self.m].reshape(2, -1), tangents or self.contact.tangents
        h = 1e-3 * self.surface.problem.unit / max(np.abs(way).max(), TINY)  # its error is the square, round-off 1e-13
        after, before = J(self.u + h * way), J(self.u - h * way)
        return (after - before) / (2.0 * h), (after - 2.0 * J(self.u) + before) / h**2

    @property
    def acting(self) -> np.ndarray:
        """As of `continuation.problem`: unknowns of nodes with a stiffness above ACTING, and the height."""
        nodes = self._acting_nodes()
        return np.concatenate((nodes, nodes + self.m, np.arange(2 * self.m, self.problem.size)))

    def _acting_nodes(self):
        stiffness = np.abs(self.J).max(axis=0)
        return np.flatnonzero(stiffness > ACTING * stiffness.max())

    def matrix(self) -> np.ndarray | None:
        """As of `continuation.problem`; None of more than FORMED nodes."""
        nodes = self._acting_nodes()
        if nodes.size > FORMED:
            return None
        kernels, J = self.contact.modes.kernels, self.J[:, nodes]
        tangent = np.empty((2 * nodes.size, 2 * nodes.size))
        form(nodes, *kernels, J, tangent)
        if not self.problem.held:
            return tangent
        column, rise = np.repeat([0.0, 1.0], nodes.size), self.scale * J[2:].ravel()
        return np.block([[tangent, column[:, None]], [rise, 0.0]])

    def product(self, x, layered=None) -> np.ndarray:
        """(J - K) x, (size,), a new array; counts as a force evaluation, unless K x is given: `layered`."""
        surface, field = self.surface, x.reshape(2, -1)
        if layered is None:
            self.contact.evaluated()
            layered = surface.through(field, surface.operators[0])
        out = -layered.reshape(2, -1)
        add_product(self.J, field[:, surface.patch], out[:, surface.patch])
        return out.reshape(-1)

    def seen(self, x) -> np.ndarray:
        """The unknowns (problem size,) of a disturbance x (size,), with the sign in which the surface sinks.

        Where it neither sinks nor rises, because it tilts a symmetric contact, it moves along x, the direction of
        pulling.
        """
        field = x.reshape(2, -1)
        along, up = field[:, self.surface.patch].sum(axis=1)
        turned = up > 0.0 if abs(up) > 1e-2 * abs(along) else along < 0.0  # else it only tilts
        return self._unknowns(-field if turned else field)

    def _unknowns(self, field):
        """The unknowns of a displacement of the surface (2, n), under which the layer bears the same load."""
        return np.append(field[:, self.surface.patch], field[1].mean() if self.problem.held else ())

    def inverse(self, solve, f) -> tuple[np.ndarray, np.ndarray]:
        """(x, K x), (size,) each, with (K - J) x = f; solve: the function that gives w for dR/dv w, (problem size,).

        K x is that of x to round-off, however accurate `solve` is.
        """
        surface, force = self.surface, f.reshape(2, -1).copy()
        w = solve(-self._load(force))
        add_product(self.J, w[: 2 * self.m].reshape(2, -1), force[:, surface.patch])
        x = surface.through(force, surface.operators[1]).copy()
        if self.problem.held:
            x[1] += w[-1]
            force[1] -= force[1].mean()  # the uniform mode has no stiffness
        return x.reshape(-1), force.reshape(-1)

    def _load(self, field):
        """What a force on the surface, (2, n), adds to R."""
        displaced = self.surface.through(field, self.surface.operators[1])[:, self.surface.patch]
        return np.append(displaced, self.scale * field[1].sum() if self.problem.held else ())

    def safe_damping(self) -> float:
        """The damping over critical above which no wave can flutter, as of `flutter`."""
        return safe_friction(self.J, self.contact.modes.stiffness, self.contact.nodes) / self.surface.critical

    def waves(self) -> tuple | None:
        """Where all nodes are alike, so that every mode is a wave, (mu (2, waves) GPa/nm, shown); else None.

        shown(i, q): the disturbance, complex (size,), of mu[i, q].
        """
        if self.m < self.contact.nodes or not alike(self.J):
            return None
        (a, b), (c, d) = self._blocks()
        mean, half = 0.5 * (a + d), 0.5 * (a - d)
        root = np.sqrt(half * half + b * c)
        mu = np.array([mean + root, mean - root])
        return mu, lambda i, q: self._wave(q, mu[i, q])

    def _wave(self, q, mu):
        (a, b), (c, d) = (row[:, q] for row in self._blocks())
        amplitude = np.array([mu - d, c] if abs(mu - d) > abs(mu - a) else [b, mu - a])
        if not amplitude.any():  # the block is a number: any direction will do
            amplitude = np.array([1.0, 0.0])
        n = self.surface.count
        return np.outer(amplitude, np.exp(2j * np.pi * q * np.arange(n) / n)).reshape(-1)

    def _blocks(self):
        """The 2 x 2 blocks of J - K of all waves, complex (2, 2, waves), J that of the first node."""
        k, J = self.contact.modes.stiffness.copy(), self.J[:, 0]
        k[1, 0] = self.surface.stiffness[1, 0]  # none under a held load
        return np.array([[J[0] - k[0], J[1] + 1j * k[2]], [J[2] - 1j * k[2], J[3] - k[1]]])


@kernel
def form(nodes, C_xx, C_zz, C_xz, J, out) -> None:
    """Fill out (2 m, 2 m) with C J - 1 of m nodes; NumPy takes some thirty times as long to gather C."""
    m, n = nodes.size, C_xx.size
    for i in range(m):
        for j in range(m):
            apart = (nodes[i] - nodes[j]) % n
            xx, zz, xz = C_xx[apart], C_zz[apart], C_xz[apart]
            out[i, j], out[i, m + j] = xx * J[0, j] + xz * J[2, j], xx * J[1, j] + xz * J[3, j]
            out[m + i, j], out[m + i, m + j] = zz * J[2, j] - xz * J[0, j], zz * J[3, j] - xz * J[1, j]
        out[i, i] -= 1.0
        out[m + i, m + i] -= 1.0
