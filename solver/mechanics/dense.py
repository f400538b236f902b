"""The inverse of the tangent of an equilibrium, dense, in single precision: a preconditioner right to some digits.

Only the tractions of active nodes change; the displacements of the others follow from them. Forming it costs the cube
of their number, each use the square; it pays where layers are soft: there iterations need a hundred products each.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit


@dataclass(frozen=True)
class Limits:
    """Sizes at which methods change, by measured times."""

    most: int = 1200  # active nodes; for more, iterative solves take less time than to form the inverse
    leaf: int = 96  # rows; blocks up to that size are inverted faster by LAPACK than by halves


LIMITS = Limits()


class DenseInverse:
    """(-dR/dv)^-1 of an `equilibrium.Equilibrium` at one v."""

    def __init__(self, problem, v, active):
        self._problem, self._held = problem, problem.pressure is not None
        contact, self._nodes = problem.contact, np.flatnonzero(active)
        self._tangents = contact.tangents(problem.surface(v), active)
        k = self._nodes.size
        matrix = np.zeros((2 * k + self._held,) * 2, np.float32)
        _fill(contact.modes.kernels, self._nodes, self._tangents, matrix)
        if self._held:
            matrix[k:-1, -1] = -1.0
            matrix[-1, :-1] = -problem.top_compliance / contact.nodes * self._tangents[2:, self._nodes].reshape(-1)
        self._inverse = inverted(matrix)
        self._rows = np.concatenate([self._nodes, contact.size + self._nodes])
        if self._held:
            self._rows = np.append(self._rows, problem.size - 1)

    def __call__(self, r):
        """The inverse times r (size,), a new array; counts as a force evaluation."""
        m, contact = 2 * self._problem.nodes, self._problem.contact
        inside = (self._inverse @ r[self._rows].astype(np.float32)).astype(float)
        w = np.zeros(r.size)
        w[self._rows] = inside
        out = r.copy()
        out[:m] += contact.product(self._tangents, w[:m].reshape(2, -1))[0].reshape(-1)
        if self._held:
            out[m // 2 : m] += w[-1]
        out[self._rows] = inside
        return out


def inverted(a):
    """a^-1 by halves, so that nearly all work is matrix products; overwrites a. Raises numpy's LinAlgError."""
    n = len(a)
    if n <= LIMITS.leaf:
        return np.linalg.inv(a)
    k = n // 2
    first = inverted(a[:k, :k])
    right, below = first @ a[:k, k:], a[k:, :k] @ first
    a[k:, k:] -= a[k:, :k] @ right
    last = inverted(a[k:, k:])
    right = right @ last
    a[:k, :k] = first + right @ below
    a[:k, k:] = -right
    a[k:, :k] = -(last @ below)
    a[k:, k:] = last
    return a


@njit(cache=True, nogil=True)
def _fill(kernels, nodes, t, out):
    """out = I - C J of the active nodes, t (4, size): J = dT/du, kernels as of `layer.Modes`."""
    k, n = nodes.size, kernels.shape[1]
    for i in range(k):
        for j in range(k):
            d = (nodes[i] - nodes[j]) % n
            xx, zz, xz, a = kernels[0, d], kernels[1, d], kernels[2, d], nodes[j]
            out[i, j] = -(xx * t[0, a] + xz * t[2, a])
            out[i, k + j] = -(xx * t[1, a] + xz * t[3, a])
            out[k + i, j] = xz * t[0, a] - zz * t[2, a]
            out[k + i, k + j] = xz * t[1, a] - zz * t[3, a]
        out[i, i] += 1.0
        out[k + i, k + i] += 1.0
