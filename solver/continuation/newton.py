"""Newton steps with GMRES, for what Anderson steps do not solve: they need more products, but hardly ever fail.

Products with the tangent need no exponentials. Saad & Schultz 1986, doi:10.1137/0907058; Knoll & Keyes 2004,
doi:10.1016/j.jcp.2003.08.010.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit


@dataclass(frozen=True)
class Limits:
    """steps: of Newton. products: of one linear solution; accuracy: of it, of the residual that it starts from.
    longest: of one step of any unknown, in units of the problem's `unit`.
    """

    steps: int = 12
    products: int = 120
    accuracy: float = 1e-3
    longest: float = 0.3


LIMITS = Limits()


def solve(problem, v, active, s, smooth=None, chord=None, arc=None):
    """(v, s, residual): the equilibrium near v at load s, or with <chord, v> = arc at a load near s; None if none is.

    v (size,): a new array; smooth: as `Corrector.smooth`.
    """
    v, r, free = v.copy(), np.empty(problem.size), chord is not None
    worst = problem.residual(v, active, s, r)
    for _ in range(LIMITS.steps):
        if worst <= problem.tolerance:
            return v, s, worst
        if not worst < 1e3 * problem.unit:
            return None
        off = np.array([arc - chord @ v] if free else ())
        move = _linear(problem, v, active, np.append(r, -off), smooth, chord)
        longest = np.abs(move[: v.size]).max()
        move *= min(1.0, LIMITS.longest * problem.unit / max(longest, 1e-300))
        v += move[: v.size]
        s += float(move[-1]) if free else 0.0
        worst = problem.residual(v, active, s, r)
    return (v, s, worst) if worst <= problem.tolerance else None


def direction(problem, v, active, smooth=None):
    """dv/ds of the branch at an equilibrium v, (size,); large near a fold."""
    return _linear(problem, v, active, problem.direction, smooth, None)


def _linear(problem, v, active, right, smooth, chord):
    """-A^-1 right by GMRES, A the tangent dR/dv, bordered by dR/ds and the chord if there is one."""
    product, m, free = problem.tangent(v, active), v.size, chord is not None

    def applied(w):
        out = product(w[:m])
        if free:
            out = np.append(out + w[m] * problem.direction, chord @ w[:m])
        return _smoothed(out, smooth, m)

    right = -_smoothed(right, smooth, m)
    most, norm = min(LIMITS.products, right.size), np.linalg.norm(right)
    basis, upper, turns = np.zeros((most + 1, right.size)), np.zeros((most + 1, most)), np.zeros((most, 2))
    rest = np.zeros(most + 1)
    basis[0], rest[0] = right / norm, norm
    for k in range(most):
        w = applied(basis[k])
        upper[: k + 1, k] = basis[: k + 1] @ w
        w -= upper[: k + 1, k] @ basis[: k + 1]
        length = np.linalg.norm(w)
        _turn(upper, turns, rest, k, length)
        if abs(rest[k + 1]) < LIMITS.accuracy * norm or length < 1e-12:
            break
        basis[k + 1] = w / length
    weights = np.linalg.lstsq(upper[: k + 1, : k + 1], rest[: k + 1], rcond=1e-14)[0]
    return weights @ basis[: k + 1]


@njit(cache=True, nogil=True)
def _turn(upper, turns, rest, k, length):
    """Make column k of the Hessenberg matrix, whose last entry is `length`, upper triangular by plane rotations."""
    for i in range(k):
        above, below = upper[i, k], upper[i + 1, k]
        upper[i, k] = turns[i, 0] * above + turns[i, 1] * below
        upper[i + 1, k] = turns[i, 0] * below - turns[i, 1] * above
    radius = max(np.hypot(upper[k, k], length), 1e-300)  # zero where the tangent is singular
    turns[k] = upper[k, k] / radius, length / radius
    upper[k, k] = radius
    rest[k], rest[k + 1] = turns[k, 0] * rest[k], -turns[k, 1] * rest[k]


def _smoothed(r, smooth, m):
    return r if smooth is None else np.append(smooth(r[:m]), r[m:])
