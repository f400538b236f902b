"""Iterative solves with the tangent of an equilibrium, each using those before it; spaces for Rayleigh-Ritz."""

import numpy as np
from numba import njit

from .anderson import dot

ACCURACY = 1e-2  # of a solve: residual over right side
MOST = 240  # products with the tangent in all solves at one equilibrium
FIRST = 16  # products in `leading`, from a random vector: then the leading modes of the tangent stand out


class Inverse:
    """A^-1 of a tangent A = dR/dv, by generalised conjugate residuals; pairs (z, A z) are kept for the next solve."""

    def __init__(self, size):
        self.product = self._smooth = self._secants = None
        self.size, self.rows = size, 0
        self._z, self._q = np.empty((2, MOST, size))

    def of_tangent(self, product, smooth, secants):
        """Start anew with another tangent, w -> A w; smooth, secants: preconditioners as in `Secants.move`, or None."""
        self.product, self._smooth, self._secants, self.rows = product, smooth, secants, 0
        return self

    def of(self, maps, force):
        """The whole-surface disturbance x with (K - J) x = force, by a solve for its unknowns."""
        return maps.spread(self.solve(-maps.load(force)), force)

    def solve(self, b, accuracy=ACCURACY):
        """w with A w = b, to that accuracy."""
        w, r = np.zeros(self.size), b.copy()
        _share(self._z, self._q, 0, self.rows, w, r)
        bound = accuracy**2 * dot(b, b)
        while dot(r, r) > bound and self.rows < MOST:
            z = r.copy() if self._smooth is None else self._smooth(r)
            if self._secants is not None:
                z = -self._secants.move(r, self._smooth)
            if not self.keep(z, self.product(z)):
                break
            _share(self._z, self._q, self.rows - 1, self.rows, w, r)
        return w

    def keep(self, z, q):
        """Add a pair (z, q = A z), both overwritten; False if it is not independent of those kept."""
        known = self.rows
        new = orthonormalise(self._q, known, q, self._z, z)
        self.rows += new
        return new


def leading(inverse):
    """Some modes of the tangent with the largest eigenvalues, (k, size), by Arnoldi steps, which `inverse` keeps."""
    w = np.random.default_rng(0).normal(size=inverse.size)
    basis, images = [], []
    for _ in range(min(FIRST, inverse.size)):
        for _ in range(2):  # twice, against round-off
            for b in basis:
                w = w - (b @ w) * b
        length = np.linalg.norm(w)
        if length < 1e-12:  # the basis spans all that there is
            break
        basis.append(w / length)
        images.append(inverse.product(basis[-1]))
        inverse.keep(basis[-1].copy(), images[-1].copy())
        w = images[-1]
    basis, images = np.array(basis), np.array(images)
    values, vectors = np.linalg.eig(basis @ images.T)
    order = np.argsort(-values.real)[:3]
    return np.concatenate([vectors[:, order].real, vectors[:, order].imag], axis=1).T @ basis


class Space:
    """Orthonormal disturbances V, their images M V under M = J - K, and V^T M V."""

    def __init__(self, size, room):
        self.rows, self._maps = 0, None
        self._v, self._w = np.empty((2, room, size))
        self._matrix, self._nothing = np.empty((room, room)), np.empty((room, 0))

    def emptied(self, maps):
        """Empty, for another equilibrium; the same memory."""
        self.rows, self._maps = 0, maps
        return self

    @property
    def vectors(self):
        return self._v[: self.rows]

    @property
    def matrix(self):
        """V^T M V."""
        return self._matrix[: self.rows, : self.rows]

    def add(self, x):
        """Add the part of x that is independent of V."""
        k = self.rows
        if not orthonormalise(self._v, k, x.copy(), self._nothing, self._nothing[0]):
            return
        self._w[k] = self._maps.product(self._v[k])
        self.rows += 1
        self._matrix[: k + 1, k] = self.vectors @ self._w[k]
        self._matrix[k, :k] = self._w[:k] @ self._v[k]

    def residuals(self, vectors, values):
        """M x - mu x of the Ritz vectors x with coefficients `vectors` (rows, k), values mu (k,); (k, N)."""
        real = vectors.T.real @ self._w[: self.rows] - (vectors * values).T.real @ self.vectors
        if not values.imag.any():
            return real
        return real + 1j * (vectors.T.imag @ self._w[: self.rows] - (vectors * values).T.imag @ self.vectors)


@njit(cache=True, nogil=True)
def orthonormalise(rows, known, q, others, z):
    """Append q to `rows`, made orthonormal to the first `known`, and z, transformed alike, to `others`; False if q
    depends on them, or there is no room.
    """
    before = np.sqrt(dot(q, q))
    for _ in range(2):
        for k in range(known):
            share = dot(rows[k], q)
            for i in range(q.size):
                q[i] -= share * rows[k, i]
            for i in range(z.size):
                z[i] -= share * others[k, i]
    rest = np.sqrt(dot(q, q))
    if not rest > 1e-10 * before or known == rows.shape[0]:
        return False
    for i in range(q.size):
        rows[known, i] = q[i] / rest
    for i in range(z.size):
        others[known, i] = z[i] / rest
    return True


@njit(cache=True, nogil=True)
def _share(z, q, first, last, w, r):
    """Project r on the rows of q from first to last: add the solution to w, subtract it from r."""
    for k in range(first, last):
        share = dot(q[k], r)
        for i in range(w.size):
            w[i] += share * z[k, i]
            r[i] -= share * q[k, i]
