"""The inverse of the tangent of an equilibrium, dense, in single precision: a preconditioner right to some digits.

Only the tractions of active nodes change; the displacements of the others follow from them. Forming it costs the cube
of their number, each use the square; it pays where layers are soft: there iterations need a hundred products each.
"""

import numpy as np
from numba import njit

MOST = 1200  # active nodes; for more, iterative solves take less time than to form the inverse
LEAF = 96  # rows; blocks up to that size are inverted faster by LAPACK than by halves


class DenseInverse:
    """(1 - C J)^-1 of a Contact displaced by u (2, m), nm. Raises numpy's LinAlgError where that is singular."""

    def __init__(self, contact, u, active):
        self._contact, self._nodes = contact, np.flatnonzero(active)
        self._tangents = contact.tangents(u, active)
        matrix = np.empty((2 * self._nodes.size,) * 2, np.float32)
        fill(contact.cell.kernels, self._nodes, self._tangents, matrix)
        self._inverse = inverted(matrix)
        self._rows = np.concatenate([self._nodes, contact.size + self._nodes])

    def __call__(self, r):
        """The inverse times r (2 m,), nm, a new array; counts as a force evaluation."""
        inside = (self._inverse @ r[self._rows].astype(np.float32)).astype(float)
        w = np.zeros(r.size)
        w[self._rows] = inside
        out = r + self._contact.product(self._tangents, w.reshape(2, -1))[0].reshape(-1)
        out[self._rows] = inside
        return out


def inverted(a):
    """a^-1 (n, n) by halves, so that nearly all work is matrix products; overwrites a. Raises numpy's LinAlgError."""
    n = len(a)
    if n <= LEAF:
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
def fill(kernels, nodes, t, out):
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
