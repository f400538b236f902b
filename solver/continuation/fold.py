"""A fold of a branch, the maximum of its load, by a Newton iteration for (v, s) with both null vectors.

Along a branch dv = phi da and ds = g da, with the arc a = <c, v>: A phi + g R_s = 0, <c, phi> = 1, A = dR/dv. At a fold
g = 0, so that phi is a null vector of A. The left one is psi, with A^T psi + g c = 0, <R_s, psi> = 1: it gives
dg = -<psi, dA phi>. The bordered matrix [[A, R_s], [c^T, 0]] is regular at a fold. Newton's steps solve R = 0 and
g = 0; they use one such matrix while the state hardly moves.
Source: Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, doi:10.1137/1.9780898719543, ch. 3.
"""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from .inverse import PRODUCTS, Solves
from .problem import Problem
from .state import SHARP, TINY, End


@dataclass(frozen=True)
class FoldOptions:
    """How a fold is searched for; a "unit" is the problem's `unit`. The state is also solved to `problem.tolerance`."""

    load: float = SHARP  # units, last Newton step of the load
    state: float = 3e-5  # units, last step of the state: its square is the error of the load
    # of the linear solves: a step leaves that part of the error. 1e-3 takes as many evaluations, in fewer steps
    accuracy: float = 1e-2
    sharper: float = inf  # in place of a larger accuracy, once a step has not become shorter
    alike: float = 0.05  # units from where the matrix was formed, within which it serves: steps then gain a digit
    reach: float = 1.5  # units from the guess: beyond, it is another fold
    least: bool = False  # a minimum of the load in place of a maximum
    products: int = PRODUCTS  # most products of iterative solves with one matrix, before it is factorised


class Bordered:
    """The tangent at v, bordered by R_s and by c = phi, with both null vectors.

    Attributes: linearised; solves, with the bordered matrix; phi, psi (size,) and g, as above, with phi of
    length 1 and g as of R_s of length 1; slopes (size,), the derivative of <psi, A phi> by the state.
    """

    def __init__(self, problem: Problem, v, phi, psi=None, options: FoldOptions = FoldOptions()):
        """phi, psi: guesses, any length; psi None: the one of a symmetric interaction."""
        self.v, self.linearised = v.copy(), problem.linearised(v)
        c = phi / np.linalg.norm(phi)
        psi = self.linearised.mirrored(c) if psi is None else psi
        self.load = problem.direction / np.linalg.norm(problem.direction)
        psi = psi / (psi @ self.load)
        self.solves = Solves(self.linearised, self.load, c, options.accuracy, options.products)
        unit, lefts = np.append(np.zeros(v.size), 1.0), options.accuracy * np.linalg.norm(psi)
        right, rest = self.solves.reduced(unit, guess=np.append(c, 0.0))
        self.psi = self.solves(unit, True, np.append(psi, 0.0), lefts)[:-1]
        self.phi, self.g = right[:-1], right[-1] + self.psi @ rest[:-1]  # its error is the product of both vectors'
        self.slopes = self.linearised.slopes(self.phi, self.psi)

    def turned(self, linearised, phi) -> tuple[np.ndarray, float]:
        """(phi, g) of another Linearised nearby, by one step from the last phi."""
        change = linearised.tangent(phi)
        g = -(self.psi @ change)
        x = self.solves(np.append(change + g * self.load, 0.0))  # x[-1] vanishes where psi is exact
        return phi - x[:-1], g - x[-1]


def fold_near(problem: Problem, guess: End, options: FoldOptions = FoldOptions()) -> End | None:
    """The fold of a problem next to a guess, or None if there is none within reach.

    The guess's phi may have any length. It and psi may be None: without phi its state must be close to the fold.
    """
    try:
        with np.errstate(divide="ignore", invalid="ignore"):  # where a null vector vanishes; nan is never accepted
            return _search(problem, guess, options)
    except np.linalg.LinAlgError:
        return None


def _search(problem, guess, options):
    v, load, unit = guess.v.copy(), guess.load, problem.unit
    phi, psi, r = guess.phi, guess.psi, np.empty(problem.size)
    if phi is None:
        phi = problem.direction  # near a fold, solves with the bordered matrix turn it
    matrix, slow, last = None, False, (np.inf, np.inf)
    for _ in range(15):  # folds that exist took 10 steps at most in the slider box
        worst = problem.residual(v, load, r)
        sharp = last[0] <= options.load * unit and last[1] <= options.state * unit
        if matrix is not None and sharp and worst <= problem.tolerance:
            psi = matrix.psi / np.linalg.norm(problem.direction)
            found = End(load, v, phi / np.abs(phi).max(), psi=psi, residual=float(worst))
            return found if (matrix.slopes @ phi <= 0.0) == options.least else None
        if slow or matrix is None or np.abs(v - matrix.v).max() > options.alike * unit:
            if slow and options.sharper < options.accuracy:
                options = replace(options, accuracy=options.sharper, products=PRODUCTS)
            if matrix is not None and matrix.solves.direct:  # iterations would fail again
                options = replace(options, products=0)
            matrix = Bordered(problem, v, phi, psi, options)
            phi, psi, g = matrix.phi, matrix.psi, matrix.g
        else:
            phi, g = matrix.turned(problem.linearised(v), phi)
        dv, ds = _step(problem, matrix, phi, g, r)
        slow, last = np.abs(dv).max() > 0.3 * last[1], (abs(ds), np.abs(dv).max())  # the matrix serves no longer
        # from longer steps punches reached the folds of other branches
        part = min(1.0, 0.3 * unit / max(last[1], TINY))
        v, load = v + part * dv, load + part * ds
        if not np.abs(v - guess.v).max() <= options.reach * unit:  # nan fails it too
            return None
    return None


def _step(problem, matrix, phi, g, r):
    """(dv, ds) of Newton's step from the residual r and the test function g."""
    x = matrix.solves(np.append(-r, 0.0))
    dv, ds = x[:-1], x[-1]
    part = (g - matrix.slopes @ dv) / (matrix.slopes @ phi)
    return dv + part * phi, (ds + part * g) / np.linalg.norm(problem.direction)
