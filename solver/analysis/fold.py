"""A fold of a branch, sharpened, and how it and what it carries change with the parameters.

At a fold A has a null vector phi and a left one psi. Its test function is g, with A phi + g b = 0 and <c, phi> = 1.
Source: Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, doi:10.1137/1.9780898719543, ch. 3.
"""

from dataclasses import dataclass

import numpy as np

from ..following.branch import NotFollowed
from .tangent import Solves, Tangent, across, along

STEPS = 8  # of Newton's, at most; from the states of a run two or three do
SHARP = 1e-9  # units, of the step of the state at which it ends: what is left is its square
BESIDE = 1e-3  # units along phi, over which the change of J is told: its error is the square, its round-off 1e-13


@dataclass(frozen=True)
class Singular:
    """A fold: its load (nm), Tangent, null vectors phi and psi (size,), the Solves bordered by them.

    slopes (2, m): J' phi transposed on the tractions' dual of psi; <slopes, phi> is the fold's bend.
    """

    load: float
    tangent: Tangent
    phi: np.ndarray
    psi: np.ndarray
    solves: Solves

    @property
    def slopes(self):
        """How <psi, A phi> falls with the state, (size,)."""
        return _slopes(self.tangent, self.phi, self.psi)


def _slopes(tangent, phi, psi):
    m, contact = tangent.m, tangent.contact
    way = phi[: 2 * m].reshape(2, m)
    h = BESIDE * min(contact.scene.delta_n, contact.scene.delta_t) / max(np.abs(way).max(), 1e-300)
    change = contact.tangents(tangent.u + h * way, tangent.active) - contact.tangents(
        tangent.u - h * way, tangent.active
    )
    return tangent.flat(across(change / (2.0 * h), tangent.dual(psi)))


def sharpened(contact, fold, held, height, pressure):
    """The Singular next to a `following.branch.Fold`; raises NotFollowed if there is none.

    height: U_z (nm) of the top, unless a load is held; pressure: p_0, GPa.
    """
    v, load, unit = fold.v.copy(), fold.load, min(contact.scene.delta_n, contact.scene.delta_t)
    c = fold.along / np.linalg.norm(fold.along)
    tangent = Tangent(contact, v, fold.active, held)
    # J symmetric, psi would be J phi
    b = tangent.flat(along(tangent.J, c[: 2 * tangent.m].reshape(2, -1)))
    b /= np.linalg.norm(b)
    last, by_load = np.append(np.zeros(v.size), 1.0), None
    for _ in range(STEPS):
        solves = Solves(tangent, b, c)
        right, left = solves(last, guess=np.append(c, 0.0)), solves(last, transposed=True, guess=np.append(b, 0.0))
        phi, psi, g = right[:-1], left[:-1], right[-1]
        by_residual = solves(np.append(tangent.residual(load, height, pressure), 0.0))
        by_load = solves(np.append(tangent.direction, 0.0), guess=by_load)
        slopes = _slopes(tangent, phi, psi)
        # dv = by_residual + dU by_load + part phi, such that the border carries nothing and g comes to nought
        rows = [[by_load[-1], g], [slopes @ by_load[:-1], slopes @ phi]]
        dU, part = np.linalg.solve(rows, [-by_residual[-1], -g - slopes @ by_residual[:-1]])
        step = by_residual[:-1] + dU * by_load[:-1] + part * phi
        if not np.abs(step).max() < unit:  # nan fails it too
            break
        if np.abs(step).max() < SHARP * unit:
            return Singular(load, tangent, phi, psi, solves)
        v, load = v + step, load + dU
        tangent = Tangent(contact, v, fold.active, held)
    raise NotFollowed(f"the fold at {fold.load:g} nm is not found by Newton's steps")
