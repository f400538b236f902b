"""The tangent of an equilibrium that carries a run, and solves with it and its transpose, bordered or not.

Unknowns v (size,) as in `following.skeleton`; R = U(s) + C T(u) - u, nm, as in `mechanics.equilibrium`, and under a
held load scale (p - p_0) last. A = -dR/dv. C is symmetric (reciprocity), J = dT/du is not.
"""

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from ..continuation.inverse import Inverse
from ..following.branch import NotFollowed
from ..mechanics.cohesive_law import add_product
from ..mechanics.contact import Contact
from ..mechanics.dense import MOST, fill

ACCURACY = 1e-9  # of a solve, residual over right side; derivatives are asked for to 1e-5, amplified near a fold


class Tangent:
    """A at a state v (size,), active (m,) of a Contact; adjoint fields of its tractions.

    Attributes: u (2, m) nm; T (2, m) GPa; J (4, m) GPa/nm, rows as of `cohesive_law.tangents`; held; scale, nm/GPa.
    """

    def __init__(self, contact: Contact, v, active, held):
        m, self.contact, self.held, self.v, self.active = contact.size, contact, held, v, active
        self.u = np.ascontiguousarray(v[: 2 * m].reshape(2, m))
        self.T, self.J = contact.traction(self.u, active), contact.tangents(self.u, active)
        self.size, self.m = 2 * m + held, m
        self.count = 1 if contact.uniform else contact.nodes
        self.scale = float(contact.modes.compliance[1, 0])
        self.direction = np.zeros(self.size)
        self.direction[:m] = 1.0
        self._turned = -self.J[[0, 2, 1, 3]]  # -J^T

    def residual(self, load, height, pressure):
        """R (size,), nm, with the top at U_x = load and, unless a load is held, U_z = height; pressure: p_0, GPa."""
        top = np.array([[load], [self.v[-1] if self.held else height]])
        r = (top + self.comply(self.T) - self.u).ravel()
        return np.append(r, self.scale * (self.T[1].sum() / self.count - pressure)) if self.held else r

    def comply(self, T):
        """C T (2, m) nm, of T (2, m) GPa; a new array."""
        return self.contact.comply(T).copy()

    def product(self, x):
        """A x, (size,)."""
        w = x[: 2 * self.m].reshape(2, -1)
        complied, rise = self.contact.product(self.J, w)
        out = w - complied
        if not self.held:
            return out.ravel()
        out[1] -= x[-1]
        return np.append(out.ravel(), -self.scale * rise[1].sum() / self.count)

    def dual(self, x):
        """<x, R> differentiated by the tractions, (2, m), at fixed C, of x (size,)."""
        return self._dual(x).copy()

    def _dual(self, x):
        """The same, a buffer."""
        out = self.contact.comply(x[: 2 * self.m].reshape(2, -1))
        if self.held:
            out[1] += self.scale * x[-1] / self.count
        return out

    def transposed(self, x):
        """A^T x, (size,)."""
        out = x[: 2 * self.m].copy()
        add_product(self._turned, self._dual(x), out.reshape(2, -1))
        return np.append(out, -x[self.m : 2 * self.m].sum()) if self.held else out

    def matrix(self):
        """A, dense (size, size)."""
        m, out = self.m, np.zeros((self.size, self.size))
        modes = self.contact.modes
        kernels = np.append(modes.compliance[:2, :1], [[0.0]], axis=0) if self.contact.uniform else modes.kernels
        inner = np.empty((2 * m, 2 * m))
        fill(kernels, np.arange(m), self.J, inner)
        out[: 2 * m, : 2 * m] = inner
        if self.held:
            out[m : 2 * m, -1] = -1.0
            out[-1, : 2 * m] = -self.scale / self.count * self.J[2:].ravel()
        return out

    def flat(self, field):
        """A field (2, m) as unknowns (size,), without height."""
        return np.append(field.ravel(), [0.0] * self.held)


def along(J, w):
    """J w (2, m), of J (4, m), w (2, m)."""
    return np.array([J[0] * w[0] + J[1] * w[1], J[2] * w[0] + J[3] * w[1]])


def across(J, w):
    """J^T w (2, m)."""
    return np.array([J[0] * w[0] + J[2] * w[1], J[1] * w[0] + J[3] * w[1]])


class Solves:
    """x with M x = b, or M^T x = b; M is a Tangent's A, bordered by a column and a row (size,) if these are given.

    By iterations, whose products are kept; where these do not lead there, by LAPACK, up to MOST nodes. Raises
    NotFollowed beyond. accuracy: residual over right side.
    """

    def __init__(self, tangent, column=None, row=None, accuracy=ACCURACY):
        self.tangent, self.column, self.row, self.accuracy = tangent, column, row, accuracy
        self.size, self._lu = tangent.size + (column is not None), None
        self._by_iterations = {}

    def __call__(self, b, transposed=False, guess=None):
        """x (size,) for b (size,); guess: where iterations begin, as from zero none leads to a b that is all border."""
        product, wanted = self._transposed if transposed else self._product, self.accuracy * np.linalg.norm(b)
        if self._lu is None:
            x = np.zeros_like(b) if guess is None else guess
            r = b if guess is None else b - product(x)
            if (size := np.linalg.norm(r)) > wanted:
                more, r = self._iterated(product, r, transposed, wanted / size)
                x = x + more
            if np.linalg.norm(r) <= 10.0 * wanted:
                return x
            if self.tangent.m > MOST:
                raise NotFollowed(f"a linear solve with {self.tangent.m} nodes does not converge")
            self._lu = lu_factor(self._matrix(), check_finite=False)
        x = lu_solve(self._lu, b, trans=int(transposed), check_finite=False)
        return x + lu_solve(self._lu, b - product(x), trans=int(transposed), check_finite=False)

    def _iterated(self, product, b, transposed, accuracy):
        if transposed not in self._by_iterations:
            self._by_iterations[transposed] = Inverse(self.size).of_tangent(product, None)
        return self._by_iterations[transposed].reduced(b, accuracy)

    def _product(self, x):
        if self.column is None:
            return self.tangent.product(x)
        return np.append(self.tangent.product(x[:-1]) + x[-1] * self.column, self.row @ x[:-1])

    def _transposed(self, x):
        if self.column is None:
            return self.tangent.transposed(x)
        return np.append(self.tangent.transposed(x[:-1]) + x[-1] * self.row, self.column @ x[:-1])

    def _matrix(self):
        A = self.tangent.matrix()
        return A if self.column is None else np.block([[A, self.column[:, None]], [self.row[None], np.zeros((1, 1))]])
