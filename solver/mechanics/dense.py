"""The inverse of the tangent of an equilibrium, dense, in single precision: a preconditioner right to some digits.

Only the tractions of active nodes change; the displacements of the others follow from them. Forming the inverse costs
the cube of their number, each use the square. That pays where layers are soft: there each increment takes 300 uses.
"""

import numpy as np
from numba import njit
from scipy.linalg.lapack import sgetrf, sgetri

MOST = 1200  # active nodes; for more, iterative solves take less time than to form the inverse
BLOCK = 64  # columns that LAPACK inverts at a time; with 3, scipy's default, it takes twice as long


class DenseInverse:
    """(1 - C J)^-1 of a Contact displaced by u (2, m), nm. Raises numpy's LinAlgError where that is singular.

    The inverse, not its factors: products with it take half the time of solves by factors, and there are hundreds.
    """

    def __init__(self, contact, u, active):
        self._contact, self._nodes = contact, np.flatnonzero(active)
        self._tangents = contact.tangents(u, active)
        self._rows = np.concatenate([self._nodes, contact.size + self._nodes])
        matrix = np.empty((self._rows.size, self._rows.size), np.float32)
        fill(contact.cell.kernels, self._nodes, self._tangents, matrix)
        factors, pivots, singular = sgetrf(matrix.T, overwrite_a=True)  # LAPACK reads columns: no copy
        if singular:
            raise np.linalg.LinAlgError("a pivot is zero")
        self._inverse = sgetri(factors, pivots, lwork=BLOCK * self._rows.size, overwrite_lu=True)[0].T

    def __call__(self, r):
        """The inverse times r (2 m,), nm, a new array; counts as a force evaluation."""
        inside = (self._inverse @ r[self._rows].astype(np.float32)).astype(float)
        w = np.zeros(r.size)
        w[self._rows] = inside
        out = r + self._contact.product(self._tangents, w.reshape(2, -1)).reshape(-1)
        out[self._rows] = inside
        return out


@njit(cache=True, nogil=True)
def fill(kernels, nodes, tangents, out) -> None:
    """out (2 k, 2 k) = I - C J of k nodes; tangents: J, (4, m) GPa/nm; kernels: C, nm/GPa, as of `layer.Modes`."""
    k, n = nodes.size, kernels.shape[1]
    for i in range(k):
        for j in range(k):
            d, a = (nodes[i] - nodes[j]) % n, nodes[j]
            xx, zz, xz = kernels[0, d], kernels[1, d], kernels[2, d]
            out[i, j] = -(xx * tangents[0, a] + xz * tangents[2, a])
            out[i, k + j] = -(xx * tangents[1, a] + xz * tangents[3, a])
            out[k + i, j] = xz * tangents[0, a] - zz * tangents[2, a]
            out[k + i, k + j] = xz * tangents[1, a] - zz * tangents[3, a]
        out[i, i] += 1.0
        out[k + i, k + i] += 1.0
