"""What matters: derivatives of slips and curves by every continuous parameter, and by the strength of every node.

By implicit differentiation of the states that carry a run. For what is read from a state (F_bar, L_bar, A_bar) one
solve with the transposed tangent gives its derivatives by all parameters at once: dF/dp = F_p + <lambda, R_p> with
A^T lambda = F_v, A = -R_v. At a fold dU/dp = -<psi, R_p>/<psi, R_U>, and the state moves on along the null vector such
that the fold stays one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from ..continuation.interpolation import lagrange
from ..following.branch import STENCIL, Branch
from ..following.skeleton import Skeleton
from ..mechanics.contact import Contact
from ..run.frame import SlipEvent
from ..scene import LIMITS, Scene
from .fold import sharpened
from .outputs import explicit, gradients, over_own, values
from .partial import Change, Pulled, States, continuous
from .tangent import ACCURACY, Solves, Tangent, across, along

Floats = NDArray[np.float64]
CORRECTED = 1e-4  # of residuals, by the step that sharpens a state: what is left of 1e-5 nm moves derivatives by 1e-9
ALONG = 1e-7  # accuracy of solves at states of a branch, which are told to 1e-5


@dataclass(frozen=True)
class SlipSensitivity:
    """A slip, and what moves it.

    by: {parameter: (4,)}, derivatives of U_s (nm), F_s, L_s and A_s (F_bar, L_bar, A_bar just before it) per unit of
    the parameter. nodes: (4, nodes), the same by the strength of each node's spring, phi_n and phi_t of that node
    times 1 + eps, per eps.
    """

    event: SlipEvent
    by: dict[str, Floats]
    nodes: Floats

    @property
    def values(self) -> Floats:
        """U_s (nm), F_s, L_s, A_s (4,), over wE and w."""
        event = self.event
        return np.array([event.load, event.F_bar, event.L_bar, event.A_bar])

    def per_cent(self, scene: Scene) -> dict[str, Floats]:
        """{parameter: (4,)}: change of U_s, F_s, L_s, A_s (nm, N/m) in per cent per per cent; nan for what is zero."""
        now, own = self.values, {name: over_own(scene, name, self.values, d) for name, d in self.by.items()}
        with np.errstate(divide="ignore", invalid="ignore"):
            return {name: np.where(now != 0.0, d * getattr(scene, name) / now, np.nan) for name, d in own.items()}


@dataclass(frozen=True)
class BranchSensitivity:
    """States of a branch, and how each moves when it keeps its place between the ends of the branch.

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
    """Of a run that slides: of its slips up to u_x_max, in order, and of the branches of its Skeleton."""

    skeleton: Skeleton
    slips: tuple[SlipSensitivity, ...]
    branches: tuple[BranchSensitivity, ...]


def sensitivities(skeleton: Skeleton, names: Sequence[str] | None = None, branches: bool = True) -> Sensitivities:
    """The Sensitivities of a run by the parameters `names`, all `continuous` ones by default.

    Without `branches` those of slips alone, which cost a linear solve each. Raises NotFollowed where a state cannot be
    told sharply enough.
    """
    known = _Known(skeleton, names)
    folds, along, start = [], [], None
    for branch in skeleton.branches:
        fold = None if branch.fold is None else known.slip(branch)
        if branches:
            along.append(known.branch(branch, start, fold))
        start = fold and {name: d[0] for name, d in fold.by.items()}
        folds.append(fold)
    return Sensitivities(skeleton, _slips(skeleton, folds), tuple(along))


def passed(skeleton: Skeleton) -> Iterator[tuple[int, int]]:
    """Yield (index of a branch, periods that it has moved on by), as the run passes them; endless where it repeats."""
    yield from ((index, 0) for index in range(len(skeleton.branches)))
    for turns in count(1) if skeleton.sites else ():
        yield from ((index, turns) for index in range(skeleton.home, len(skeleton.branches)))


def _slips(skeleton, folds):
    """The SlipSensitivities up to u_x_max: what repeats itself changes with the period, sites width/nodes."""
    scene, found = skeleton.scene, []
    for index, turns in passed(skeleton):
        fold, sites = folds[index], turns * skeleton.sites
        if fold is None or fold.event.load + sites * scene.spacing > scene.u_x_max:
            break
        by, event = dict(fold.by), replace(fold.event, load=fold.event.load + sites * scene.spacing)
        if "width" in by:
            by["width"] = by["width"] + [sites / scene.nodes, 0.0, 0.0, 0.0]
        found.append(SlipSensitivity(event, by, fold.nodes))
    return tuple(found)


def _ahead(every, n, fold):
    """[x (3, size)] of the next of n even states, extrapolated from `every` (duals, x) before it, or []."""
    known = [x for _, x in every[-STENCIL:]]
    if not known:
        return []
    i = len(every)
    # towards a fold x grows as one over what is left of t
    left = [n - 1 - j if fold else 1 for j in range(i - len(known), i + 1)]
    weights = lagrange(range(i - len(known), i), i)
    return [sum(weight * part / left[-1] * x for weight, part, x in zip(weights, left, known, strict=False))]


class _Known:
    """What the states of a Skeleton share: the Contact, the Changes, and under a held load that of p_0."""

    def __init__(self, skeleton, names=None):
        self.scene, self.first, branch = skeleton.scene, skeleton.first, skeleton.branches[0]
        scene = self.scene
        self.held, self.height = scene.hold == "load", -scene.delta
        self.contact = Contact(scene, skeleton.first, skeleton.nodes)
        loose = scene.changed(tolerance=LIMITS["tolerance"].high)
        self.changes = [Change.of(loose, name) for name in (continuous(scene) if names is None else names)]
        self.pressure, self.pressure_by = 0.0, np.zeros(len(self.changes))
        self.pressure_nodes = np.zeros(skeleton.nodes)  # by the strength of each node of the patch
        if self.held:
            v = branch.states(np.zeros(1), skeleton.nodes)[0, :-1]
            rest, solves = self.settled(v, branch.active[0], 0.0, False)
            self.pressure = float(rest.T[1].sum()) / rest.count
            carried = np.zeros((1, 2, rest.m))
            carried[0, 1] = 1.0 / rest.count
            (dual,), (x,) = self.duals(rest, solves, carried)
            parts = self.parts([rest], False)
            self.pressure_by = np.array([np.sum(dual * dT) + x @ rest_R for (dT,), (rest_R,) in parts])
            self.pressure_nodes = (dual * rest.T).sum(axis=0)

    def settled(self, v, active, load, held, accuracy=ACCURACY):
        """(Tangent, Solves) at the state next to v, by a step of Newton's."""
        tangent = Tangent(self.contact, v, active, held)
        residual = tangent.residual(load, self.height, self.pressure)
        if np.abs(residual).max() > self.scene.tolerance:
            step = Solves(tangent, accuracy=CORRECTED)(residual)
            tangent = Tangent(self.contact, v + step, active, held)
        return tangent, Solves(tangent, accuracy=accuracy)

    def duals(self, tangent, solves, gradients, guess=(None, None, None)):
        """(duals (k, 2, m), x (k, size)): dG = <dual, dT> + <x, rest of R_p>, of G with gradients (k, 2, m) by T.

        guess: of x (k, size).
        """
        sides = [tangent.flat(across(tangent.J, one)) for one in gradients]
        x = np.array([solves(b, True, begun) for b, begun in zip(sides, guess, strict=False)])
        return np.array([one + tangent.dual(part) for one, part in zip(gradients, x, strict=True)]), x

    def parts(self, tangents, held):
        """[(dT (k, 2, m), what R changes by beside C dT (k, size))] of every Change, at k Tangents."""
        out, at = [], States(tangents, self.first)
        pulled = Pulled(at.T, self.first, self.contact)
        for change, dp in zip(self.changes, self.pressure_by, strict=True):
            rest = np.zeros_like(at.T) + change.complied(pulled)
            if not held:
                rest[:, 1] -= change.by(lambda scene: scene.delta)
            rest = rest.reshape(len(tangents), -1)
            if held:
                rest = np.append(rest, np.full((len(tangents), 1), -tangents[0].scale * dp), axis=1)
            out.append((change.traction(at), rest))
        return out

    def branch(self, branch, start, fold):
        """The BranchSensitivity; start: {parameter: derivative} of its first load, or None where that is fixed."""
        n = branch.intervals + 1
        found, slope = np.full((4, n), np.nan), np.full((3, n), np.inf)
        by = {change.name: np.full((4, n), np.nan) for change in self.changes}
        found[0] = branch.loads
        share = (found[0] - branch.start) / (branch.end - branch.start)
        tangents, every = [], []
        for i in range(n - (fold is not None)):
            tangent, solves = self.settled(branch.v[i], branch.active[i], found[0, i], self.held, ALONG)
            found[1:, i] = values(self.scene, tangent.T)
            every.append(self.duals(tangent, solves, gradients(self.scene, tangent.T), *_ahead(every, n, fold)))
            slope[:, i] = every[-1][1] @ tangent.direction
            tangents.append(tangent)
        inner, (duals, x) = slice(len(tangents)), map(np.array, zip(*every, strict=True))
        for change, (dT, rest) in zip(self.changes, self.parts(tangents, self.held), strict=True):
            ends = start[change.name] if start else 0.0, fold.by[change.name][0] if fold else 0.0
            load = (1.0 - share[inner]) * ends[0] + share[inner] * ends[1]
            moved = np.einsum("kiam,kam->ik", duals, dT) + np.einsum("kis,ks->ik", x, rest)
            moved += explicit(self.scene, found[1:, inner], change) + slope[:, inner] * load
            by[change.name][:, inner] = [load, *moved]
        if fold:
            found[:, -1] = fold.values
            for name, values_by in by.items():
                values_by[:, -1] = fold.by[name]
        return BranchSensitivity(branch, found, by, slope)

    def slip(self, branch):
        """The SlipSensitivity of the fold at the end of a Branch."""
        scene = self.scene
        at = sharpened(self.contact, branch.fold, self.held, self.height, self.pressure)
        tangent, phi, psi, m = at.tangent, at.phi, at.psi, at.tangent.m
        found, slopes, pull = values(scene, tangent.T), at.slopes, gradients(scene, tangent.T)
        rises = np.array([tangent.flat(across(tangent.J, one)) for one in pull])
        back = (rises @ phi) / (slopes @ phi)  # how far the second-order condition draws the state along phi
        x = np.array([at.solves(np.append(one, 0.0), transposed=True)[:-1] for one in rises - back[:, None] * slopes])
        duals = pull + np.array([tangent.dual(one) for one in x])
        bent, left = along(tangent.J, phi[: 2 * m].reshape(2, m)), tangent.dual(psi)
        speed = psi @ tangent.direction
        by, state, bending = {}, States([tangent], self.first), Pulled(bent[None], self.first, self.contact)
        for change, ((dT,), (rest,)) in zip(self.changes, self.parts([tangent], self.held), strict=True):
            load = -(np.sum(left * dT) + psi @ rest) / speed
            (dJ,) = change.stiffness(state)
            turned = np.sum(left * along(dJ, phi[: 2 * m].reshape(2, m)))
            turned += np.sum(psi[: 2 * m].reshape(1, 2, m) * change.complied(bending))
            moved = (duals * dT).sum(axis=(1, 2)) + x @ rest + (x @ tangent.direction) * load - back * turned
            by[change.name] = np.array([load, *(moved + explicit(scene, found, change))])
        nodes = self._nodes(at, left, bent, speed, duals, x, back)
        return SlipSensitivity(SlipEvent(float(at.load), *map(float, found), "shear", "fold", True), by, nodes)

    def _nodes(self, at, left, bent, speed, duals, x, back):
        """(4, nodes): as of SlipSensitivity."""
        tangent = at.tangent
        held = tangent.scale * self.pressure_nodes
        load = -((left * tangent.T).sum(axis=0) - (at.psi[-1] * held if self.held else 0.0)) / speed
        turned = (left * bent).sum(axis=0)
        moved = (duals * tangent.T).sum(axis=1) - np.multiply.outer(x[:, -1], held)
        moved += np.multiply.outer(x @ tangent.direction, load) - np.multiply.outer(back, turned)
        rows = np.vstack([load, moved])
        if self.contact.uniform:  # each of all nodes has its share in what they do together
            return np.repeat(rows / self.scene.nodes, self.scene.nodes, axis=1)
        out = np.zeros((4, self.scene.nodes))
        out[:, self.first : self.first + tangent.m] = rows
        return out
