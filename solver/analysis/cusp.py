"""Cusps of the sliding branch: states in which two of its folds merge as a parameter p changes.

With the null vectors phi and psi of `continuation.fold`, g = 0 at a fold, and along the branch dg = -h da with
h = <psi, A_v[phi, phi]>. At a cusp h = 0, too. Newton's steps solve R = 0, g = 0 and h = 0 for the unknowns v, the load
U_x and log p. One bordered matrix gives all they need: with w_0 and w_p, its solutions for -R and -R_p, a step is
dv = w_0 + alpha phi + dp w_p, and two numbers, alpha and dp, are left to be found.

Beyond a cusp the branch has no fold nearby, unless g has a maximum there: then the boundary is a pair of cusps beside
it. A walk over the period finds the folds that are left.
Source: Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, doi:10.1137/1.9780898719543, ch. 8.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..continuation.fold import Bordered, FoldOptions
from ..following.moved import Solver
from ..following.skeleton import Held
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.load_steps import sideways
from ..scene import Scene, SceneError
from .partial import spectra
from .sensitivities import Differentiator

Floats = NDArray[np.float64]
SOLVED = FoldOptions(accuracy=1e-4)  # of the linear solves: a Newton step leaves that part of the error
# The error of p is the square of that of the state, as p has an extremum along the folds.
LAST = 1e-4, 1e-7  # units, and of log p: the last Newton step
STEP = 0.3  # units of the state, and of log p: the longest step
FAR = 50.0  # units: a Newton step that leads nowhere
# Along folds, of a node's move in units and of log p together: the first step, the longest and the shortest one
FIRST, LONGEST, SHORTEST = 0.2, 0.5, 0.01
OFF, FAR_OFF = 0.05, 0.25  # the same, and of the residual: a point is corrected, or its step repeated at half
CORRECTIONS = 4  # of one point
STEPS, POINTS = 25, 100  # Newton steps; points on a curve of folds
HELD_MOVES = 1.5  # units that the state whose load is held may move in a step


class Lost(Exception):
    """A search that does not reach a cusp; the message says why."""


@dataclass(frozen=True, eq=False)
class State:
    """A state (v, load) of a patch, with guesses of its null vectors. held: as of a Skeleton."""

    scene: Scene
    first: int
    v: Floats
    load: float
    phi: Floats
    psi: Floats | None = None
    held: Held | None = None

    @property
    def nodes(self) -> int:
        """Number of nodes of the patch."""
        return self.v.size // 2

    def moved(self, name: str, dv: Floats | float, load: float, change: float) -> "State":
        """The State moved by dv and load (nm), for a parameter multiplied by exp(change); raises Lost."""
        try:
            scene = self.scene.changed(**{name: float(getattr(self.scene, name) * np.exp(change))})
        except SceneError as failure:
            raise Lost(f"the search leaves what a scene allows: {failure}") from None
        return replace(self, scene=scene, v=self.v + dv, load=self.load + load)


class System:
    """The equations at a State and their derivatives, by the unknowns and by log p.

    Attributes: state, with the null vectors found; problem, linearised, T (GPa); residual, nm; g and h.
    """

    def __init__(self, state: State, name: str) -> None:
        held, evaluations = _held(state) if state.held else (None, 0)
        of = self._of = Differentiator(replace(state, held=held), [name])
        self.name, self.problem, self.evaluations = name, of.problem, lambda: of.contact.evaluations + evaluations
        self._r = np.empty(self.problem.size)
        self.residual = self.problem.residual(state.v, state.load, self._r)
        at = self._at = Bordered(self.problem, state.v, state.phi, state.psi, SOLVED)
        self.linearised, self.T = cast(Any, at.linearised), self.problem.traction(state.v)
        self._value = getattr(state.scene, name)
        self.phi, self.g, self.h = at.phi, at.g, float(at.slopes @ at.phi)
        self.state = replace(state, phi=at.phi, psi=at.psi, held=held)

    @cached_property
    def _bases(self):
        """(w_0, w_p), (size + 1,) each: what cancels R, and what keeps it zero as log p grows; C_psi and J_p."""
        (((T_p,), (r_p,)),) = self._of.by_parameters([self])
        w_p = self._solved(-self._value * (self.linearised.complied(T_p) + r_p))
        (J_p,) = self._of.changes[0].stiffness(self.linearised.u[None])
        return self._solved(-self._r), w_p, self.linearised.by_traction(self._at.psi), J_p

    def _solved(self, f, transposed=False):
        return self._at.solves(np.append(f, 0.0), transposed)

    def _by_p(self, left, T, C_left, T_p):
        """<left, C T> by log p, where T (2, m) changes by T_p; C_left: left by the tractions."""
        contact, m = self.problem.contact, self.problem.nodes
        layer = self._of.changes[0].complied(spectra(T[None], contact.part, contact.nodes))
        return self._value * float(np.sum(C_left * T_p) + np.sum(left[: 2 * m].reshape(1, 2, m) * layer))

    def _turned(self, left, C_left, w):
        """<left, A w> by log p."""
        return self._by_p(left, self.linearised.pull(w), C_left, self.linearised.pull(w, self._bases[3]))

    @cached_property
    def fold(self) -> tuple[float, float, float]:
        """The equation g = 0, linear in alpha and the change of log p: factors of both, and its right side."""
        return self._row(-self._at.slopes, -self._turned(self._at.psi, self._bases[2], self.phi), self.g)

    @cached_property
    def cusp(self) -> tuple[float, float, float]:
        """The equation h = 0, likewise."""
        by, psi, phi, C_psi = self.linearised, self._at.psi, self.phi, self._bases[2]
        bend, more = by.bends(phi)
        bend_p, _ = by.bends(phi, lambda u: self._of.changes[0].stiffness(u[None])[0])
        bent = by.pull(phi, bend)
        y, z = self._solved(by.complied(bent))[:-1], self._solved(self._at.slopes, True)[:-1]
        C_z = by.by_traction(z)
        h_v = by.by_unknowns(C_psi, more - by.bends(y)[0]) - 2.0 * by.by_unknowns(C_z, bend)
        h_p = self._by_p(psi, bent, C_psi, by.pull(phi, bend_p))
        return self._row(h_v, h_p - self._turned(psi, C_psi, y) - 2.0 * self._turned(z, C_z, phi), self.h)

    @property
    def scaled(self) -> tuple[Floats, float]:
        """(the factors in `fold` of a node's move in units and of log p, the alpha that moves a node by a unit)."""
        unit = self.problem.unit / np.abs(self.phi).max()
        return np.array([self.fold[0] * unit, self.fold[1]]), unit

    @property
    def correction(self) -> Floats:
        """The least step to g = 0, (2,): of a node's move in units and of log p."""
        row, _ = self.scaled
        return row * self.fold[2] / (row @ row)

    def _row(self, by_v, by_p, value):
        w_0, w_p = self._bases[:2]
        return float(by_v @ self.phi), float(by_v @ w_p[:-1] + by_p), float(-value - by_v @ w_0[:-1])

    def moved(self, alpha: float, change: float) -> tuple[State, float]:
        """(the State after a step, shortened to STEP, the largest change of an unknown by the whole step, units)."""
        w_0, w_p = self._bases[:2]
        w = w_0 + change * w_p
        dv, load = w[:-1] + alpha * self.phi, w[-1] + alpha * self.g
        size = np.abs(dv).max() / self.problem.unit
        part = STEP / max(size, abs(change), STEP)
        load /= np.linalg.norm(self.problem.direction)
        return self.state.moved(self.name, part * dv, part * load, part * change), float(size)


def _held(state):
    """(the Held of a State's scene, from that of a scene nearby; force evaluations); raises NotFollowed."""
    problem = Equilibrium(Contact(state.scene, state.first, state.nodes), sideways(1.0, -state.scene.delta))
    v = Solver(problem).state(state.held.v, 0.0, "the state whose load is held", HELD_MOVES)
    return Held(v), problem.evaluations


def newton(state: State, name: str, spend: Callable[[System], None]) -> State:
    """The State at the cusp near a State; raises Lost. spend: called with every System."""
    size = np.inf
    for _ in range(STEPS):
        at = System(state, name)
        matrix = np.array([at.fold, at.cusp])
        alpha, change = np.linalg.solve(matrix[:, :2], matrix[:, 2])
        state, size = at.moved(alpha, change)
        spend(at)
        if size < LAST[0] and abs(change) < LAST[1]:
            return state
        if not size < FAR:
            break
    raise Lost(f"Newton's steps do not reach a cusp: the last one moves a node by {size:.2g} units")


def along_folds(state: State, name: str, way: float, spend: Callable[[System], None]) -> State:
    """The State next to the cusp at which the curve of folds ends that begins near a State, as log p changes by `way`.

    Raises Lost.
    """
    at, step = _on_fold(state, name, spend, fixed=True), FIRST
    sign = np.sign(at.h) if at else 0.0
    for _ in range(POINTS):
        if at is None:
            break
        if at.h * sign <= 0.0:
            return at.state
        row, unit = at.scaled
        along = way * sign * np.array([row[1], -row[0]]) / np.linalg.norm(row)
        while step > SHORTEST:
            change = at.correction + step * along
            new = _on_fold(at.moved(change[0] * unit, change[1])[0], name, spend)
            if new is not None:
                break
            step *= 0.5
        at, step = new, min(step * 1.5, LONGEST)
    raise Lost("the curve of folds does not lead to a cusp")


def _on_fold(state, name, spend, fixed=False):
    """The System at a State, corrected until it is near a fold; None where it is too far off. fixed: p is."""
    for _ in range(CORRECTIONS):
        at = System(state, name)
        spend(at)
        off = at.residual / at.problem.unit
        if off > FAR_OFF:
            return None
        if off < OFF and np.abs(at.correction).max() < OFF:
            return at
        by_alpha, _, right = at.fold
        _, unit = at.scaled
        change = (right / by_alpha, 0.0) if fixed else at.correction * (unit, 1.0)
        state, _ = at.moved(*change)
    return None
