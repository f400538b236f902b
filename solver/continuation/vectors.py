"""Compiled functions of vectors: products, projections, and least squares over secant pairs.

All of them stand here because Numba's cache looks at the file of a caller only: after a change of a function in another
file it would go on using the old one (tests/cli/test_cold_start.py).
"""

import numpy as np

from .compiled import call, kernel

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
def split(du, dr, gram, rows, r, eps, work, move, rest) -> None:
    """Subtract sum c_j du_j from move and sum c_j dr_j from rest, with the c that minimise |r - sum c_j dr_j|.

    work (memory + 2, memory): scratch. An allocation in a kernel would take longer to compile than the rest of it.
    """
    c, scale = work[-2], work[-1]
    _coefficients(dr, gram, rows, r, eps, work, c, scale)
    for j in range(rows):
        _subtract(move, c[j] * scale[j], du[j])
        _subtract(rest, c[j] * scale[j], dr[j])


@kernel(fastmath={"contract"})
def _subtract(total, c, row):
    for i in range(total.size):
        total[i] -= c * row[i]


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _coefficients(dr, gram, rows, r, eps, upper, y, d):
    """Least-squares coefficients y d of r in the rows of dr, by Cholesky of the normalised, regularised Gram matrix."""
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
def evaluate(function, context, v, out) -> float:
    """Fill out (size,) with the residual of v (size,) by a `Problem.compiled`; returns its largest magnitude."""
    call(function, context, v.ctypes.data, out.ctypes.data)
    return largest(out)


@kernel
def largest(r) -> float:
    """The largest magnitude in r, inf where a number is not finite: a maximum passes over nan."""
    most, total = 0.0, 0.0
    for i in range(r.size):
        most = max(most, abs(r[i]))
        total += r[i]
    return most if np.isfinite(total) else np.inf


@kernel
def _secant_move(du, dr, gram, rows, eps, work, r, move, rest):
    """Fill move with the change of v that cancels r, as `anderson.Secants.move` without `smooth`."""
    for i in range(r.size):
        move[i], rest[i] = 0.0, r[i]
    split(du, dr, gram, rows, r, eps, work, move, rest)
    for i in range(r.size):
        move[i] += rest[i]


@kernel
def solve(
    function, context, v, r, worst, tolerance, most, bound, pairs, place, eps, work, chord, arc, direction, room
) -> tuple:
    """The Anderson steps of `corrector.Corrector`, in place, by a `Problem.compiled`.

    Returns (largest residual, change of the load, steps). v, r (size,): unknowns and their residual, of magnitude
    `worst`. pairs: du, dr and gram; place (2,): rows and slot of `anderson.Secants`. chord (size,): empty for a fixed
    load. room (5, size), work: scratch.
    """
    (du, dr, gram), (v_before, r_before, move, rest, response) = pairs, (room[0], room[1], room[2], room[3], room[4])
    shift, steps, n = 0.0, 0, v.size
    while not worst <= tolerance and steps < most and np.isfinite(worst):
        rows, slot, change = place[0], place[1], 0.0
        _secant_move(du, dr, gram, rows, eps, work, r, move, rest)
        if chord.size:
            # v must change by move + change * response when the load does by change: chosen to stay on the arc
            _secant_move(du, dr, gram, rows, eps, work, direction, response, rest)
            slope = dot(chord, response)
            change = (arc - dot(chord, v) - dot(chord, move)) / slope if slope != 0.0 else 0.0
            for i in range(n):
                move[i] += change * response[i]
        for i in range(n):
            v_before[i], r_before[i] = v[i], r[i]
        change *= advance(v, move, bound)
        call(function, context, v.ctypes.data, r.ctypes.data)
        for i in range(n):
            r[i] += shift * direction[i]
        place[0], place[1] = max(rows, slot + 1), (slot + 1) % du.shape[0]
        push(du, dr, gram, place[0], slot, v, r, v_before, r_before)
        shift += change
        for i in range(n):
            r[i] += change * direction[i]
        worst, steps = largest(r), steps + 1
    return worst, shift, steps


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
