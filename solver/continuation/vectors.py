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


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _dots(row, a, b):
    """(row . a, row . b): a row is read from memory once."""
    with_a, with_b = 0.0, 0.0
    for i in range(row.size):
        with_a += row[i] * a[i]
        with_b += row[i] * b[i]
    return with_a, with_b


@kernel
def _put(sums, dr, slot, u, r, u_before, r_before):
    for i in range(u.size):
        change = r[i] - r_before[i]
        sums[slot, i] = u[i] - u_before[i] + change
        dr[slot, i] = change


@kernel
def push(sums, dr, gram, rows, slot, u, r, u_before, r_before) -> None:
    """Put a pair into its slot, of rows so many: its sum du + dr, dr, and dr in gram; see `anderson.Secants`."""
    _put(sums, dr, slot, u, r, u_before, r_before)
    for j in range(rows):
        gram[slot, j] = gram[j, slot] = dot(dr[slot], dr[j])


@kernel(fastmath={"contract"})
def split(sums, dr, gram, rows, r, eps, work, move, rest) -> None:
    """Subtract sum c_j du_j from move and sum c_j dr_j from rest, with the c that minimise |r - sum c_j dr_j|.

    work (memory + 3, memory): scratch. An allocation in a kernel would take longer to compile than the rest of it.
    """
    c, along = work[-2], work[-3]
    for j in range(rows):
        along[j] = dot(dr[j], r)
    _coefficients(along, gram, rows, eps, work)
    for j in range(rows):
        for i in range(r.size):
            move[i] -= c[j] * (sums[j, i] - dr[j, i])
            rest[i] -= c[j] * dr[j, i]


@kernel(fastmath={"contract"})
def _subtract(total, c, row):
    for i in range(total.size):
        total[i] -= c * row[i]


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _coefficients(along, gram, rows, eps, work):
    """Fill c = work[-2] with the least-squares coefficients of r in the rows of dr; along: dr . r.

    By Cholesky of the normalised, regularised Gram matrix.
    """
    upper, y, d = work, work[-2], work[-1]
    for i in range(rows):
        d[i] = 1.0 / np.sqrt(gram[i, i]) if gram[i, i] > 0.0 else 0.0
        y[i] = along[i] * d[i]
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
    for i in range(rows):
        y[i] *= d[i]


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
def _secant_move(sums, gram, rows, eps, work, r, along, move):
    """Fill move with the change of v that cancels r, as `anderson.Secants.move` without `smooth`; along: dr . r."""
    _coefficients(along, gram, rows, eps, work)
    for i in range(r.size):
        move[i] = r[i]
    for j in range(rows):
        _subtract(move, work[-2, j], sums[j])


@kernel
def solve(
    function, context, v, r, worst, tolerance, most, bound, pairs, place, eps, work, chord, arc, direction, room
) -> tuple:
    """The Anderson steps of `corrector.Corrector`, in place, by a `Problem.compiled`.

    Returns (largest residual, change of the load, steps). v, r (size,): unknowns and their residual, of magnitude
    `worst`. pairs: sums, dr and gram; place (2,): rows and slot of `anderson.Secants`. chord (size,): empty for a fixed
    load. room (4, size), work: scratch.
    """
    sums, dr, gram = pairs
    v_before, r_before, move, response, along = room[0], room[1], room[2], room[3], work[-3]
    shift, steps, n = 0.0, 0, v.size
    for j in range(place[0]):
        along[j] = dot(dr[j], r)
    while not worst <= tolerance and steps < most and np.isfinite(worst):
        rows, slot, change = place[0], place[1], 0.0
        _secant_move(sums, gram, rows, eps, work, r, along, move)
        if chord.size:
            # v must change by move + change * response when the load does by change: chosen to stay on the arc
            for j in range(rows):
                along[j] = dot(dr[j], direction)
            _secant_move(sums, gram, rows, eps, work, direction, along, response)
            slope = dot(chord, response)
            change = (arc - dot(chord, v) - dot(chord, move)) / slope if slope != 0.0 else 0.0
            _subtract(move, -change, response)
        for i in range(n):
            v_before[i], r_before[i] = v[i], r[i]
        change *= advance(v, move, bound)
        call(function, context, v.ctypes.data, r.ctypes.data)
        _subtract(r, -shift, direction)
        rows = place[0] = max(rows, slot + 1)
        place[1] = (slot + 1) % sums.shape[0]
        _put(sums, dr, slot, v, r, v_before, r_before)
        _subtract(r, -change, direction)
        for j in range(rows):
            gram[slot, j], along[j] = _dots(dr[j], dr[slot], r)
            gram[j, slot] = gram[slot, j]
        shift += change
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
