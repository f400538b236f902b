"""Problems of one and two unknowns with known answers, under the contract of `solver.continuation.problem`.

One node with two directions hangs on a spring of stiffness k whose other end is driven: R = U(s) + T(u)/k - u, with
U = (s, 0). Of a problem of one unknown the second direction stays at zero.
"""

from types import SimpleNamespace

import numpy as np

from solver.continuation.state import State


class Toy:
    """T and its Jacobian are functions of u (size,); period: of the lattice, if there is one."""

    unit = 1.0

    def __init__(self, T, J, size=1, k=1.0, tolerance=1e-12):
        self.T, self.J, self.size, self.k, self.tolerance = T, J, size, k, tolerance
        self.evaluations = 0
        self.direction = np.eye(size)[0]

    def undeformed(self, s):
        return s * self.direction

    def solved_to(self, tolerance):
        return Toy(self.T, self.J, self.size, self.k, tolerance)

    def residual(self, v, s, out):
        self.evaluations += 1
        out[:] = s * self.direction + self.T(v) / self.k - v
        return float(np.abs(out).max())

    def compiled(self, s):
        return None

    def evaluated(self, times):
        self.evaluations += times

    def hold(self, v, s):
        pass

    def sites(self, v, w):
        return 0.0  # no lattice

    def alike(self, v):
        return False

    def linearised(self, v):
        return Disturbed(self, v)

    def motion(self):
        return Node(self)

    def at_rest(self, s, guess):
        """The State at load s next to a guess, by Newton's method."""
        v = np.array(guess, float).reshape(self.size)
        for _ in range(50):
            v = v - np.linalg.solve(self.J(v) / self.k - np.eye(self.size), s * self.direction + self.T(v) / self.k - v)
        return State.at_rest(s, v)


class Node:
    """The Dynamics of a Toy: one mode, y = u."""

    def __init__(self, problem):
        self.problem = problem
        self.stiffness = np.array([[problem.k], [problem.k], [0.0]])
        self.critical = 2.0 * problem.k**0.5

    def start(self, v, s):
        y = np.zeros((2, 1), complex)
        y[: v.size, 0] = v
        return y

    def unknowns(self, y):
        return y[: self.problem.size, 0].real.copy()

    def force(self, y, s):
        self.problem.evaluations += 1
        force = self.start(self.problem.T(self.unknowns(y)), s)
        force[0, 0] += self.problem.k * s
        return force

    def compiled(self, s):
        return None

    def evaluated(self, times):
        pass

    def interface(self, v):
        return float(np.abs(self.problem.J(v)).sum(axis=1).max())


class Disturbed:
    """The Linearised of a Toy: the unknowns, of unit mass."""

    def __init__(self, problem, v):
        self.problem, self.size, self.v = problem, problem.size, v
        self._matrix = problem.J(v) - problem.k * np.eye(problem.size)

    def product(self, x, layered=None):
        self.problem.evaluations += layered is None
        return self._matrix @ x

    def tangent(self, w):
        self.problem.evaluations += 1
        return self._matrix @ w / self.problem.k

    def transposed(self, w):
        self.problem.evaluations += 1
        return self._matrix.T @ w / self.problem.k

    def mirrored(self, w):
        return w

    def slopes(self, right, left):
        """By central differences of J: over 1e-4 their error is 1e-8 of its third derivative."""
        beside = 1e-4 * np.eye(self.problem.size)
        J = self.problem.J
        return np.array([left @ (J(self.v + e) - J(self.v - e)) @ right for e in beside]) / (2e-4 * self.problem.k)

    @property
    def acting(self):
        return np.arange(len(self.matrix()))

    def matrix(self):
        return self._matrix / self.problem.k

    def inverse(self, solve, f):
        x = solve(-f / self.problem.k)
        return x, self.problem.k * x

    def seen(self, x):
        return x.copy()

    def safe_damping(self):
        return 0.0

    def waves(self):
        return None


def cubic():
    """R = s + v - v^3: stable for |v| > 1/sqrt(3), so that the branch from below ends at s = 2/(3 sqrt(3))."""
    return Toy(lambda v: 2.0 * v - v**3, lambda v: np.diag(2.0 - 3.0 * v**2))


CUBIC = SimpleNamespace(fold=2.0 / 27.0**0.5, at=-(3.0**-0.5), rest=2.0 * 3.0**-0.5)


def lattice(*waves, period=2.4, k=1.0):
    """Prandtl-Tomlinson: T = -sum A_j sin(2 pi j u/a + phase_j); waves: (A, phase), j = 1, 2, ..."""
    q = 2.0 * np.pi / period

    def T(u):
        return -sum(A * np.sin(j * q * u + phase) for j, (A, phase) in enumerate(waves, 1))

    def J(u):
        return np.diag(-sum(A * j * q * np.cos(j * q * u + phase) for j, (A, phase) in enumerate(waves, 1)))

    toy = Toy(T, J, k=k)
    toy.period = period
    return toy


def spiral(growth=0.8, reach=4.0, turn=0.8):
    """A force that turns round the origin, T = p u + turn J u with p = growth r^2 exp(-r^2/reach), r = |u|, k = 1.

    At load s: r ((1 - p)^2 + turn^2)^1/2 = s, and dT/du - 1 has the eigenvalues a +- i b, a = p + p' r^2 - 1,
    b^2 = turn^2 - (p' r^2)^2, with p' = dp/d(r^2).
    """

    def p(r2):
        return growth * r2 * np.exp(-r2 / reach)

    def rise(r2):
        return growth * (1.0 - r2 / reach) * np.exp(-r2 / reach)

    turned = np.array([[0.0, -turn], [turn, 0.0]])

    def T(u):
        return p(u @ u) * u + turned @ u

    def J(u):
        return p(u @ u) * np.eye(2) + turned + 2.0 * rise(u @ u) * np.outer(u, u)

    toy = Toy(T, J, size=2)
    toy.load = lambda r: r * np.hypot(1.0 - p(r * r), turn)
    toy.real = lambda r: p(r * r) + rise(r * r) * r * r - 1.0
    toy.imaginary2 = lambda r: turn**2 - (rise(r * r) * r * r) ** 2
    return toy
