"""Compiled functions of vectors: products, projections, and least squares over secant pairs.

All of them stand here because Numba's cache looks at the file of a caller only: after a change of a function in another
file it would go on using the old one (tests/cli/test_cold_start.py).
"""

import numpy as np

from .compiled import kernel

LITTLE = 0.1  # of a vector, left by a projection: its round-off is ten times as large, which is negligible


@kernel(fastmath={"reassoc", "contract", "nsz"})
def dot(a, b) -> float:
    """a . b of two (size,), summed in vector lanes."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@kernel
def push(du, dr, gram, rows, slot, u, r, u_before, r_before) -> None:
    for i in range(u.size):
        du[slot, i] = u[i] - u_before[i]
        dr[slot, i] = r[i] - r_before[i]
    for j in range(rows):
        gram[slot, j] = gram[j, slot] = dot(dr[slot], dr[j])


@kernel
def split(du, dr, gram, r, eps, work, move, rest) -> None:
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


@kernel
def orthonormalise(rows, count, q) -> np.ndarray:
    """Append q (size,) to `rows`, made orthonormal to the first `count`; return its shares (count + 1,) in these rows.

    The last share is 0 if q depends on the others, or there is no room. Overwrites q.
    """
    shares, before = np.zeros(count + 1), np.sqrt(dot(q, q))
    rest = before
    for _ in range(2):
        last = rest
        for k in range(count):
            share = dot(rows[k], q)
            shares[k] += share
            for i in range(q.size):
                q[i] -= share * rows[k, i]
        rest = np.sqrt(dot(q, q))
        if rest > LITTLE * last:
            break
    if rest > 1e-10 * before and count < rows.shape[0]:
        shares[count] = rest
        for i in range(q.size):
            rows[count, i] = q[i] / rest
    return shares


@kernel
def project(q, first, last, r, shares) -> None:
    """Subtract from r its projection on the rows of q from first to last, and fill their shares."""
    for k in range(first, last):
        shares[k] = dot(q[k], r)
        for i in range(r.size):
            r[i] -= shares[k] * q[k, i]
