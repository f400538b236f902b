"""An equilibrium linearised: J = dT/du, the layer K, their difference, and the tangent dR/dv of the problem.

A small disturbance x (2, n) nm of all n nodes of the cell, flattened, obeys x'' = (J - K) x - gamma x', with J zero
outside the patch. By Parseval's theorem its Euclidean inner product is that of Fourier modes of unit mass.
"""

import numpy as np
from numba import njit

from .flutter import safe_friction

SKEWER = 0.05  # of critical: change of the safe damping, estimated, from which on it is computed anew
ALIKE = 1e-7  # difference of J between nodes, over its largest, below which they count as alike: well above round-off


class Linearised:
    """The Linearised of `continuation.problem`, at one equilibrium v of an `equilibrium.Equilibrium`.

    Attributes: J on the patch, (4, m) GPa/nm, rows as of `cohesive_law.tangents`; size, of a disturbance.
    """

    def __init__(self, surface, v, active):
        self.surface, self.contact, self.m = surface, surface.contact, surface.contact.size
        self.J = self.contact.tangents(surface.problem.surface(v), active)
        self.size = 2 * surface.count

    def tangent(self, w):
        """dR/dv w, a new array of w's shape (problem size,), nm; counts as a force evaluation."""
        return self.contact.product(self.J, w.reshape(2, -1))[0].reshape(-1) - w

    def product(self, x):
        """(J - K) x, (size,), a new array; counts as a force evaluation."""
        surface, field = self.surface, x.reshape(2, -1)
        self.contact.count()
        uniform = self.contact.uniform
        out = -(surface.stiffness[:2] * field if uniform else surface.through(field, surface.operators[0]))
        _add_product(self.J, field[:, surface.patch], out[:, surface.patch])
        return out.reshape(-1)

    def seen(self, x):
        """The unknowns (problem size,) of a disturbance x (size,), with the sign in which the surface sinks."""
        field = x.reshape(2, -1)
        rises = field[1, self.surface.patch].sum() > 0.0
        return self._unknowns(-field if rises else field)

    def _unknowns(self, field):
        return field[:, self.surface.patch].reshape(-1).copy()

    def inverse(self, solve, f):
        """x (size,) with (K - J) x = f; solve: the function that gives w for dR/dv w, (problem size,) each."""
        surface, field = self.surface, f.reshape(2, -1).copy()
        w = solve(-self._load(field))
        _add_product(self.J, w[: 2 * self.m].reshape(2, -1), field[:, surface.patch])
        return self._raised(w, surface.through(field, surface.operators[1])).reshape(-1).copy()

    def _load(self, field):
        """What a force on the surface, (2, n), adds to R."""
        surface = self.surface
        return surface.through(field, surface.operators[1])[:, surface.patch].reshape(-1).copy()

    def _raised(self, w, field):
        """The surface (2, n) displaced by `field` against the top."""
        return field

    def projected(self, basis):
        """X J X^T, (k, k) GPa/nm, of disturbances X (k, size)."""
        J = self.J
        x, z = basis.reshape(len(basis), 2, -1)[:, :, self.surface.patch].transpose(1, 0, 2)
        return x @ (J[0] * x + J[1] * z).T + z @ (J[2] * x + J[3] * z).T

    def safe_damping(self, known=(0.0, None)):
        """(damping over critical above which no wave can flutter, J_xz - J_zx (m,) that it is for), by `flutter`.

        `known` itself, such a pair, where J_xz - J_zx has hardly changed since.
        """
        skew, before = self.J[1] - self.J[2], known[1]
        if before is not None and before.shape == skew.shape:
            change = 0.5 * np.abs(skew - before).max()  # of Im mu, here for a wave as stiff as the interface
            if change <= SKEWER * self.surface.critical * np.sqrt(np.abs(self.J).max()):
                return known
        contact = self.contact
        friction = safe_friction(self.J, contact.modes.stiffness, contact.nodes, contact.covers_cell)
        return friction / self.surface.critical, skew

    def waves(self):
        """Where all nodes are alike, so that every mode is a wave, (mu (2, waves) GPa/nm, shown); else None.

        shown(i, q): the disturbance, complex (size,), of mu[i, q]; None if these nodes cannot show it.
        """
        J = self.J
        if not self.contact.covers_cell or np.ptp(J, axis=1).max() > ALIKE * np.abs(J).max():
            return None
        (a, b), (c, d) = self._blocks()
        mean, half = 0.5 * (a + d), 0.5 * (a - d)
        root = np.sqrt(half * half + b * c)
        mu = np.array([mean + root, mean - root])
        return mu, lambda i, q: self._wave(q, mu[i, q])

    def _wave(self, q, mu):
        if self.contact.uniform and q:
            return None
        (a, b), (c, d) = (row[:, q] for row in self._blocks())
        amplitude = np.array([mu - d, c] if abs(mu - d) > abs(mu - a) else [b, mu - a])
        if not amplitude.any():  # the block is a number: any direction will do
            amplitude = np.array([1.0, 0.0])
        n = self.surface.count
        return np.outer(amplitude, np.exp(2j * np.pi * q * np.arange(n) / n)).reshape(-1)

    def _blocks(self):
        """The 2 x 2 blocks of J - K of all waves, complex (2, 2, waves), J that of the first node."""
        k, J = self._stiffness_of_waves(), self.J[:, 0]
        return np.array([[J[0] - k[0], J[1] + 1j * k[2]], [J[2] - 1j * k[2], J[3] - k[1]]])

    def _stiffness_of_waves(self):
        return self.contact.modes.stiffness


@njit(cache=True, nogil=True)
def _add_product(J, x, out):
    """out += J x, both (2, m)."""
    for i in range(x.shape[1]):
        a, b = x[0, i], x[1, i]
        out[0, i] += J[0, i] * a + J[1, i] * b
        out[1, i] += J[2, i] * a + J[3, i] * b
