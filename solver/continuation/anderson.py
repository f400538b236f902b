"""Anderson (type II) acceleration of a fixed point.

A secant pair is a change du of the unknowns and the change dr of the residual. The load only adds to the residual, so
that pairs stay valid from one increment to the next.
Source: Anderson 1965, doi:10.1145/321296.321305; Walker & Ni 2011, doi:10.1137/10078356X.
"""

import numpy as np

from .compiled import kernel

# Added to the normalised Gram matrix, so that pairs which depend on each other to within it do not count twice.
# 1e-12 to 1e-8 reach the same states, with up to 16 % more and 1 % fewer evaluations (tests/bench/constants.py).
REGULARISATION = 1e-10


class Secants:
    """The last `memory` pairs (du, dr) of vectors (size,), nm, with the Gram matrix of dr."""

    def __init__(self, memory, size):
        self.du = np.zeros((memory, size))
        self.dr = np.zeros((memory, size))
        self.gram = np.zeros((memory, memory))
        self.rows, self.slot = 0, 0  # pairs kept so far, and where the next one goes

    def push(self, u, r, u_before, r_before) -> None:
        """Keep the pair (u - u_before, r - r_before), (size,) each, in place of the oldest."""
        self.rows = max(self.rows, self.slot + 1)
        _push(self.du, self.dr, self.gram, self.rows, self.slot, u, r, u_before, r_before)
        self.slot = (self.slot + 1) % len(self.du)

    def move(self, r, smooth=None) -> np.ndarray:
        """The change of u that cancels the residual r (size,) to first order, by the pairs' tangent; a new array.

        smooth (array -> array): applied to the part of r outside the span of the pairs; by default it is added as is.
        """
        move, rest, work = np.zeros(r.size), r.copy(), np.empty((self.rows + 2, self.rows))
        _split(self.du, self.dr, self.gram, r, REGULARISATION, work, move, rest)
        move += rest if smooth is None else smooth(rest)
        return move

    def forget(self) -> None:
        """Drop all pairs."""
        self.rows = self.slot = 0

    def copy(self) -> "Secants":
        """An independent copy."""
        other = Secants.__new__(Secants)
        other.du, other.dr, other.gram = self.du.copy(), self.dr.copy(), self.gram.copy()
        other.rows, other.slot = self.rows, self.slot
        return other

    def __reduce__(self):
        """Pickled, it is empty: pairs are as large as 40 states, and a run finds others within some evaluations."""
        return Secants, self.du.shape


@kernel(fastmath={"reassoc", "contract", "nsz"})
def dot(a, b) -> float:
    """a . b of two (size,), summed in vector lanes."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@kernel
def _push(du, dr, gram, rows, slot, u, r, u_before, r_before):
    for i in range(u.size):
        du[slot, i] = u[i] - u_before[i]
        dr[slot, i] = r[i] - r_before[i]
    for j in range(rows):
        gram[slot, j] = gram[j, slot] = dot(dr[slot], dr[j])


@kernel
def _split(du, dr, gram, r, eps, work, move, rest):
    """Subtract sum c_j du_j from move and sum c_j dr_j from rest, with the c that minimise |r - sum c_j dr_j|.

    work (rows + 2, rows): scratch. An allocation in a kernel would take longer to compile than the rest of it.
    """
    rows = work.shape[1]
    c, scale = work[rows], work[rows + 1]
    _coefficients(dr, gram, r, eps, work, c, scale)
    for j in range(rows):
        _subtract(move, c[j] * scale[j], du[j])
        _subtract(rest, c[j] * scale[j], dr[j])


@kernel(fastmath={"contract"})
def _subtract(total, c, row):
    for i in range(total.size):
        total[i] -= c * row[i]


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _coefficients(dr, gram, r, eps, upper, y, d):
    """Least-squares coefficients y d of r in the rows of dr, by Cholesky of the normalised, regularised Gram matrix."""
    rows = y.size
    for i in range(rows):
        d[i] = 1.0 / np.sqrt(gram[i, i]) if gram[i, i] > 0.0 else 0.0
        y[i] = dot(dr[i], r) * d[i]
    for i in range(rows):
        for j in range(i, rows):
            upper[i, j] = gram[i, j] * d[i] * d[j]
        upper[i, i] = 1.0 + eps
    for k in range(rows):
        pivot = 1.0 / np.sqrt(max(upper[k, k], eps))
        for j in range(k, rows):
            upper[k, j] *= pivot
        y[k] *= pivot
        for i in range(k + 1, rows):
            factor = upper[k, i]
            for j in range(i, rows):
                upper[i, j] -= factor * upper[k, j]
            y[i] -= factor * y[k]
    for i in range(rows - 1, -1, -1):
        y[i] /= upper[i, i]
        for k in range(i):
            y[k] -= upper[k, i] * y[i]


@kernel
def advance(u, move, bound) -> float:
    """Add move to u (size,) in place, scaled so that no number changes by more than bound; returns the scale."""
    largest = 0.0
    for i in range(u.size):
        largest = max(largest, abs(move[i]))
    scale = 1.0 if largest <= bound else bound / largest
    for i in range(u.size):
        u[i] += scale * move[i]
    return scale
