"""Derivatives of slips and curves by every continuous parameter, and by the strength of every node.

Implicit differentiation of the states of a Skeleton. Let G be F_bar, L_bar or A_bar. At fixed v, a parameter p changes
tractions by T_p, and the residual by R_p = C T_p + r_p. One solve with the transposed tangent, R_v^T x = -G_v, serves
all parameters:

    dG/dp = G_p + <y, T_p> + <x, r_p>,    y = G_T + C^T x.

At a fold with null vectors phi and psi, dU/dp = -(<C^T psi, T_p> + <psi, r_p>)/<psi, R_U>. The state also moves along
phi, so that the fold remains one: G changes by <G_v, phi> times -<psi, R_vp phi>/<psi, R_vv phi phi>. In the code
C_psi is C^T psi, J_phi is dT/dv phi, and psi_R is <psi, R_U>.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..continuation.fold import Bordered, FoldOptions, fold_near
from ..continuation.inverse import Solves
from ..continuation.trace import Branch
from ..following.moved import NotFollowed
from ..following.skeleton import Skeleton, skeleton_in
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..mechanics.linearised import Linearised
from ..run.frame import SlipEvent, forces_and_area, slips_in
from ..run.load_steps import sideways
from ..scene import LIMITS, Scene, refuse_other
from ..schema import unknown_name
from ..threads import computation
from .partial import Change, continuous, explicit, gradients, over_own, spectra

Floats = NDArray[np.float64]
RESIDUAL = 1e-10  # nm, of residuals of folds and of the state whose load is held; at 1e-8 A_s has noise of 1e-10
SOLVED = 1e-9  # of a linear solve; derivatives are asked for to 1e-5, and amplified near a fold
FOLDS = FoldOptions(state=1e-10, accuracy=1e-3)  # units; from 1e-9 a derivative by height had noise of 2e-5


@dataclass(frozen=True, eq=False, repr=False)
class SlipSensitivity:
    """A slip and its derivatives.

    values (4,): U_s (nm), F_s, L_s (N/m) and A_s (nm), just before the slip. by: {parameter: (4,)}, their derivatives
    per unit of the parameter. nodes (4, nodes): the same by the strength of each node's spring, per eps, where phi_n
    and phi_t of that node are multiplied by 1 + eps.
    """

    event: SlipEvent
    values: Floats
    by: dict[str, Floats]
    nodes: Floats
    scene: Scene

    def __repr__(self) -> str:
        U, F, L, A = self.values
        slip = f"U_s = {U:.6g} nm, F_s = {F:.4g} N/m, L_s = {L:.4g} N/m, A_s = {A:.4g} nm"
        return f"SlipSensitivity({slip}; by {', '.join(self.by)} and by nodes {self.nodes.shape})"

    def per_cent(self, scene: Scene) -> dict[str, Floats]:
        """{parameter: (4,)}: change of U_s, F_s, L_s, A_s in per cent per per cent; nan where one is zero.

        Raises SceneError for another scene than that of the run.
        """
        refuse_other(scene, self.scene, "run")
        now = self.values
        with np.errstate(divide="ignore", invalid="ignore"):
            return {name: np.where(now != 0.0, d * getattr(scene, name) / now, np.nan) for name, d in self.by.items()}


@dataclass(frozen=True)
class BranchSensitivity:
    """States of a branch and their derivatives, at fixed relative positions between the ends of the branch.

    values: (4, n) rows U_x (nm), F_bar, L_bar, A_bar of n states; by: {parameter: (4, n)}, per unit of the parameter.
    slope: (3, n), derivatives of F_bar, L_bar, A_bar by U_x, per nm; infinite at a fold, the last state.
    """

    branch: Branch
    values: Floats
    by: dict[str, Floats]
    slope: Floats

    def at_fixed_load(self, name: str) -> Floats:
        """Derivatives of F_bar, L_bar, A_bar (3, n) by a parameter at fixed U_x, per unit; nan at a fold."""
        with np.errstate(invalid="ignore"):
            return self.by[name][1:] - np.where(np.isfinite(self.slope), self.slope * self.by[name][0], np.nan)


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of the slips of a run up to u_x_max, in order, and of the branches of its Skeleton.

    A jump where a held load takes over ("control") is not among the slips.
    """

    skeleton: Skeleton
    slips: tuple[SlipSensitivity, ...]
    branches: tuple[BranchSensitivity, ...]


@computation
def sensitivities(skeleton: Skeleton, names: Iterable[str] | None = None, branches: bool = True) -> Sensitivities:
    """Derivatives of the slips and curves of a run by its parameters.

    Parameters: skeleton: as of `skeleton_of`; names: parameters, all `continuous` ones by default; branches: False for
    slips alone, which is far cheaper.
    Returns Sensitivities: of every slip up to u_x_max, and of every branch.
    Raises NotFollowed where Newton's steps do not solve a state or a fold, SceneError for a name that is none of those.

    Example: `sensitivities(skeleton_of(Scene())).slips[0].by["phi_n"]`
    """
    skeleton = skeleton_in(skeleton)
    allowed = continuous(skeleton.scene)
    names = None if names is None else tuple(names)
    for name in names or ():
        if name not in allowed:
            raise unknown_name(name, allowed)
    try:
        return _sensitivities(skeleton, Differentiator(skeleton, names), branches)
    except np.linalg.LinAlgError as failure:
        raise NotFollowed(str(failure)) from None


def _sensitivities(skeleton, of, branches):
    folds, along, start = [], [], None
    for branch in skeleton.branches:
        fold = None if branch.slip is None else of.slip(branch)
        if branches:
            along.append(of.branch(branch, start, fold))
        start = fold and {name: d[0] for name, d in fold.by.items()}
        folds.append(fold)
    return Sensitivities(skeleton, _slips(skeleton, folds), tuple(along))


def _slips(skeleton, folds):
    """The SlipSensitivities up to u_x_max; loads of repeated slips change with the period, sites width/nodes."""
    scene, slips = skeleton.scene, []
    force = scene.width * scene.E
    unit = np.array([1.0, force, force, scene.width])  # of U_s, F_bar, L_bar, A_bar, for nm and N/m
    for _, (index, turns) in zip(slips_in(skeleton), skeleton.trace.passes(), strict=False):
        fold, sites = folds[index], turns * skeleton.sites
        load = fold.event.load + sites * scene.spacing
        bars = np.array([load, *fold.values[1:]])
        by = {name: over_own(scene, name, bars, d) * unit for name, d in fold.by.items()}
        if "width" in by:
            by["width"][0] += sites / scene.nodes
        numbers = bars * unit, by, fold.nodes * unit[:, None]
        slips.append(SlipSensitivity(replace(fold.event, load=load), *numbers, scene))
    return tuple(slips)


class _State(NamedTuple):
    """A state solved to the tolerance: its tangent, solves with it, and its tractions (2, m), GPa."""

    linearised: Linearised
    solves: Solves
    T: Floats


class Differentiator:
    """Differentiates states of one Skeleton by parameters; under a held load p_0 depends on them, too."""

    def __init__(self, skeleton: Any, names: Sequence[str] | None = None) -> None:
        self.scene, self.first = skeleton.scene, skeleton.first
        scene, held = self.scene, skeleton.held
        self.contact = Contact(scene, skeleton.first, skeleton.nodes)
        self.problem = Equilibrium(self.contact, sideways(1.0, -scene.delta)).solved_to(RESIDUAL)
        loose = scene.changed(tolerance=LIMITS["tolerance"].high)  # without effect on Changes, but not on valid scenes
        self.changes = [
            Change.of(loose, name, self.contact.part) for name in (continuous(scene) if names is None else names)
        ]
        self.pressure_by = np.zeros(len(self.changes))
        self.pressure_nodes = np.zeros(skeleton.nodes)  # by the strength of each node of the patch
        if held is not None:
            self._carry(self.settled(held.v, 0.0, tolerance=RESIDUAL))

    def _carry(self, state):
        """From now on hold the load of a state at given indentation."""
        carried = np.zeros((1, *state.T.shape))  # G_T of the mean pressure
        carried[0, 1] = 1.0 / self.scene.nodes
        (y,), (x,) = self.adjoints(state, carried)
        self.pressure_by = np.array([np.sum(y * T_p) + x @ r_p for (T_p,), (r_p,) in self.by_parameters([state])])
        self.pressure_nodes = (y * state.T).sum(axis=0)
        held = Equilibrium(self.contact, sideways(1.0, 0.0), self.contact.pressure(state.T[1]))
        self.problem = held.solved_to(RESIDUAL)

    @property
    def held(self) -> bool:
        """Whether a load is held."""
        return self.problem.held

    def settled(self, v, load, accuracy=SOLVED, tolerance=None) -> _State:
        """The _State next to v by Newton's steps; raises NotFollowed where they do not reach the tolerance, nm."""
        problem, r, tolerance = self.problem, np.empty(self.problem.size), tolerance or self.scene.tolerance
        for _ in range(4):  # from 1e-5 nm it takes one or two
            linearised = problem.linearised(v)
            if problem.residual(v, load, r) <= tolerance:
                return _State(linearised, Solves(linearised, accuracy=accuracy), problem.traction(v))
            v = v - Solves(linearised, accuracy=1e-4)(r)  # the rest moves derivatives by 1e-9
        raise NotFollowed(f"the state at U_x = {load:g} nm is not solved by 4 Newton steps")

    def adjoints(self, state, G_T) -> tuple[Floats, Floats]:
        """(y (k, 2, m), x (k, size)) of k quantities G, from their derivatives G_T (k, 2, m) by the tractions."""
        x = np.array([state.solves(-state.linearised.by_unknowns(each), True) for each in G_T])
        return G_T + np.array([state.linearised.by_traction(each) for each in x]), x

    def by_parameters(self, states) -> list[tuple[Floats, Floats]]:
        """[(T_p (k, 2, m), r_p (k, size))] by every parameter, at k _States."""
        u, T = np.array([state.linearised.u for state in states]), np.array([state.T for state in states])
        out, pulled = [], spectra(T, self.contact.part, self.scene.nodes)
        for change, dp in zip(self.changes, self.pressure_by, strict=True):
            r_p = np.zeros_like(T) + change.complied(pulled)
            if not self.held:
                r_p[:, 1] -= change.by(lambda scene: scene.delta)
            r_p = r_p.reshape(len(states), -1)
            if self.held:
                r_p = np.append(r_p, np.full((len(states), 1), -self.problem.scale * dp), axis=1)
            out.append((change.traction(u), r_p))
        return out

    def branch(self, branch, start, fold) -> BranchSensitivity:
        """The BranchSensitivity; start: {parameter: derivative} of its first load, or None where that is fixed."""
        n = len(branch.states)
        outputs, slope = np.full((4, n), np.nan), np.full((3, n), np.inf)
        outputs[0] = branch.loads
        states: list[_State] = []
        solutions: list[tuple[Floats, Floats]] = []
        for i in range(n - (fold is not None)):
            passed = branch.states[i]
            state = self.settled(passed.v, passed.load, 1e-7)  # along a branch nothing is amplified
            outputs[1:, i] = forces_and_area(self.scene, state.T)
            solutions.append(self.adjoints(state, gradients(self.scene, state.T)))
            slope[:, i] = solutions[-1][1] @ self.problem.direction
            states.append(state)
        inner, (y, x) = slice(len(states)), map(np.array, zip(*solutions, strict=True))
        share, by = (outputs[0, inner] - branch.start) / (branch.end - branch.start), {}
        for change, (T_p, r_p) in zip(self.changes, self.by_parameters(states), strict=True):
            ends = start[change.name] if start else 0.0, fold.by[change.name][0] if fold else 0.0
            dU = (1.0 - share) * ends[0] + share * ends[1]
            G_p = explicit(self.scene, outputs[1:, inner], change)
            dG = G_p + np.einsum("kiam,kam->ik", y, T_p) + np.einsum("kis,ks->ik", x, r_p)
            by[change.name] = np.array([dU, *(dG + slope[:, inner] * dU)])
        if fold:
            outputs[:, -1] = fold.values
            by = {name: np.column_stack([rows, fold.by[name]]) for name, rows in by.items()}
        return BranchSensitivity(branch, outputs, by, slope)

    def slip(self, branch) -> SlipSensitivity:
        """The SlipSensitivity of the fold at the end of a Branch, of F_bar, L_bar and A_bar in place of F, L and A."""
        scene, problem = self.scene, self.problem
        fold = fold_near(problem, branch.slip, FOLDS)
        if fold is None:
            raise NotFollowed(f"the fold at {branch.end:g} nm is not solved by Newton's steps")
        at = Bordered(problem, fold.v, fold.phi, fold.psi, replace(FOLDS, accuracy=SOLVED))
        linearised: Any = at.linearised
        state = _State(linearised, at.solves, problem.traction(fold.v))
        outputs, G_T = np.array(forces_and_area(scene, state.T)), gradients(scene, state.T)
        G_v = np.array([linearised.by_unknowns(each) for each in G_T])
        along = (G_v @ at.phi) / (at.slopes @ at.phi)  # dG by the movement along phi that keeps the fold a fold
        sides = np.append(along[:, None] * at.slopes - G_v, np.zeros((3, 1)), axis=1)
        x = np.array([at.solves(side, True)[:-1] for side in sides])
        y = G_T + np.array([linearised.by_traction(each) for each in x])
        J_phi, C_psi = linearised.pull(at.phi), linearised.by_traction(at.psi)
        psi_R = at.psi @ problem.direction
        bending = spectra(J_phi[None], self.contact.part, scene.nodes)
        by = {}
        for change, ((T_p,), (r_p,)) in zip(self.changes, self.by_parameters([state]), strict=True):
            dU = -(np.sum(C_psi * T_p) + at.psi @ r_p) / psi_R
            (J_p,) = change.stiffness(linearised.u[None])
            psi_vp_phi = np.sum(C_psi * linearised.pull(at.phi, J_p))
            psi_vp_phi += np.sum(at.psi[: J_phi.size].reshape(1, *J_phi.shape) * change.complied(bending))
            dG = explicit(scene, outputs, change) + (y * T_p).sum(axis=(1, 2)) + x @ r_p - along * psi_vp_phi
            by[change.name] = np.array([dU, *dG])
        held = (problem.scale if self.held else 0.0) * self.pressure_nodes
        dU = -((C_psi * state.T).sum(axis=0) - at.psi[-1] * held) / psi_R
        dG = (y * state.T).sum(axis=1) - np.outer(x[:, -1], held) - np.outer(along, (C_psi * J_phi).sum(axis=0))
        F_bar, L_bar, A_bar = outputs.tolist()
        event = SlipEvent(float(fold.load), F_bar, L_bar, A_bar, "shear")
        nodes = np.zeros((4, scene.nodes))
        nodes[:, self.contact.part] = np.vstack([dU, dG])
        return SlipSensitivity(event, np.array([event.load, *outputs]), by, nodes, self.scene)
