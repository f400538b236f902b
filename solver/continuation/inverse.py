"""Linear solves with the tangent of an equilibrium, which use products of earlier solves."""

from collections.abc import Callable

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.linalg.lapack import dtrtrs

from .vectors import dot, orthonormalise, project

ACCURACY = 1e-3  # of a solve, residual over right side; at 1e-2 a mode that hardly loads the unknowns was missed
# most products with the tangent in all solves at one equilibrium: on soft layers, a search takes 90 to 230
PRODUCTS = 240
REFINED = 4  # most solves with factors of single precision, each of which corrects the one before
ROOM = 16  # pairs at first, as many as most searches need: memory for all, never touched, took half of a search's time


class Inverse:
    """A^-1 of a tangent A = dR/dv, by generalised conjugate residuals; pairs (z, A z) are kept for the next solve.

    q are the A z, made orthonormal; the z stay the residuals that they were.
    """

    def __init__(self, product: Callable, size: int, most: int = PRODUCTS):
        """product: w -> A w; most: products in all solves."""
        self.product, self.size, self.most, self.rows = product, size, most, 0
        self._z, self._q = np.empty((2, min(ROOM, most), size))
        self._shares = np.zeros((len(self._q), len(self._q)))  # A z_k is the sum of shares[j, k] q_j, j <= k

    def solve(self, b: np.ndarray, accuracy: float = ACCURACY) -> np.ndarray:
        """w (size,) with |A w - b| <= accuracy |b|, or as close to that as `most` products lead."""
        return self.reduced(b, accuracy)[0]

    def reduced(self, b: np.ndarray, accuracy: float = ACCURACY) -> tuple[np.ndarray, np.ndarray]:
        """The same w, and b - A w."""
        r, shares = b.copy(), np.empty(self.most)
        project(self._q, 0, self.rows, r, shares)
        bound = accuracy**2 * dot(b, b)
        while (rest := dot(r, r)) > bound and self.rows < self.most:
            k = self.rows
            if k == len(self._q):
                self._widen()
            np.multiply(r, rest**-0.5, out=self._z[k])
            self._shares[: k + 1, k] = orthonormalise(self._q, k, self.product(self._z[k]))
            if self._shares[k, k] == 0.0:
                break
            self.rows += 1
            project(self._q, k, self.rows, r, shares)
        if not (n := self.rows):
            return np.zeros(self.size), r
        of_z, _ = dtrtrs(self._shares[:n, :n], shares[:n])  # SciPy's solve_triangular takes six times as long for that
        return of_z @ self._z[:n], r

    def _widen(self):
        """Make room for twice as many pairs, at most for `most`."""
        k, room = self.rows, min(2 * self.rows, self.most)
        pairs, shares = np.empty((2, room, self.size)), np.zeros((room, room))
        pairs[:, :k], shares[:k, :k] = (self._z, self._q), self._shares
        (self._z, self._q), self._shares = pairs, shares


class Solves:
    """x with M x = f, or M^T x = f: M is dR/dv of a Linearised, bordered by a column and a row (size,) if given.

    Iterations keep their products for the next solve; where they do not converge, LAPACK factorises M.
    """

    def __init__(self, linearised, column=None, row=None, accuracy=ACCURACY, most=PRODUCTS):
        """accuracy: of x, |M x - f| over |f|; most: iterations for all solves of one kind."""
        self.linearised, self.column, self.row, self._lu = linearised, column, row, None
        self.accuracy, self._most, self._by_iterations = accuracy, most, {}

    @property
    def direct(self) -> bool:
        """Whether iterations did not converge, so that LAPACK solves."""
        return self._lu is not None

    def __call__(self, f, transposed=False, guess=None, accuracy=None) -> np.ndarray:
        """x for f; guess: where iterations start; accuracy: in place of the usual one. Raises LinAlgError."""
        return self.reduced(f, transposed, guess, accuracy)[0]

    def reduced(self, f, transposed=False, guess=None, accuracy=None) -> tuple[np.ndarray, np.ndarray]:
        """The same x, and f - M x."""
        product, wanted = self._transposed if transposed else self._product, (accuracy or self.accuracy)
        wanted *= np.linalg.norm(f)
        if self._lu is None:
            x, r = (np.zeros_like(f), f) if guess is None else (guess, f - product(guess))
            if (size := np.linalg.norm(r)) > wanted:
                more, r = self._inverse(transposed, f.size).reduced(r, wanted / size)
                x = x + more
            if np.linalg.norm(r) <= wanted:
                return x, r
            self._lu = self._factors()
        x, r = np.zeros_like(f), f
        for _ in range(REFINED):
            x = x + self._direct(r, transposed)
            r = f - product(x)
            if np.linalg.norm(r) <= wanted:
                break
        return x, r

    def _inverse(self, transposed, size):
        if transposed not in self._by_iterations:
            product = self._transposed if transposed else self._product
            self._by_iterations[transposed] = Inverse(product, size, most=self._most)
        return self._by_iterations[transposed]

    def _product(self, x):
        if self.column is None:
            return self.linearised.tangent(x)
        return np.append(self.linearised.tangent(x[:-1]) + x[-1] * self.column, self.row @ x[:-1])

    def _transposed(self, x):
        if self.column is None:
            return self.linearised.transposed(x)
        return np.append(self.linearised.transposed(x[:-1]) + x[-1] * self.row, self.column @ x[:-1])

    def _factors(self):
        """The factors of M without the unknowns that do not act: these follow from the others, as M x = -x there."""
        A = self.linearised.matrix()
        if A is None:
            raise np.linalg.LinAlgError("a linear solve does not converge, and is too large for LAPACK")
        inside = self.linearised.acting
        if self.column is not None:
            row = self.row + self.linearised.transposed(_without(self.row, inside))
            corner = self.column @ _without(self.row, inside)
            A = np.block([[A, self.column[inside, None]], [row[None, inside], corner]])
            inside = np.append(inside, self.row.size)
        return lu_factor(A.astype("f4"), check_finite=False), inside

    def _direct(self, f, transposed):
        """x by the factors, without the little that unknowns do which do not act."""
        factors, inside = self._lu
        outside = _without(f, inside)
        if transposed:  # the others' rows pass on what the outer ones bear
            f = f + self._transposed(outside) + outside
        elif self.column is not None:
            f = f + self._product(outside) + outside
        x = np.zeros_like(f)
        x[inside] = lu_solve(factors, f[inside].astype("f4"), trans=int(transposed), check_finite=False)
        passed = _without((self._transposed if transposed else self._product)(x), inside)
        return x + passed - outside


def _without(x, inside):
    """A copy of x, zero at these indices."""
    out = x.copy()
    out[inside] = 0.0
    return out
