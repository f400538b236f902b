"""A skeleton on a wider patch: tractions of the old nodes displace the added ones."""

from dataclasses import replace

import numpy as np

from ..continuation.fold import Fold
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.loading import sideways, vertical
from .branch import Branch
from .skeleton import Held, Skeleton


def widened(skeleton: Skeleton) -> Skeleton:
    """The same Skeleton with more nodes."""
    scene, held = skeleton.scene, skeleton.held
    contact = Contact(scene, skeleton.first, skeleton.nodes)
    given, approach = Equilibrium(contact, sideways(1.0, -scene.delta)), Equilibrium(contact, vertical(1.0))
    shear = given if held is None else Equilibrium(contact, sideways(1.0, 0.0), skeleton.pressure)
    if held is not None:
        held = Held(*given.wider().adopted(given, held.v, held.active, 0.0), held.kind)
    return replace(
        skeleton,
        first=contact.wider().first,
        branches=tuple(_branch(shear, branch) for branch in skeleton.branches),
        jumps=tuple(_fold(approach, jump) for jump in skeleton.jumps),
        contact=skeleton.contact and widened(skeleton.contact),
        held=held,
    )


def _branch(problem, branch: Branch) -> Branch:
    wide = problem.wider()
    states = [wide.adopted(problem, *each) for each in zip(branch.v, branch.active, branch.loads, strict=True)]
    v, active = (np.array(rows) for rows in zip(*states, strict=True))
    return replace(branch, v=v, active=active, fold=branch.fold and _fold(problem, branch.fold))


def _fold(problem, fold: Fold) -> Fold:
    """The Fold with more nodes, which do not move along phi: it is only a guess of the next phi."""
    m, wide = problem.nodes, problem.wider()
    before = problem.contact.first - wide.contact.first
    phi = np.pad(fold.phi[: 2 * m].reshape(2, m), [(0, 0), (before, wide.nodes - m - before)]).ravel()
    v, active = wide.adopted(problem, fold.v, fold.active, fold.load)
    return replace(fold, v=v, active=active, phi=np.append(phi, fold.phi[2 * m :]), psi=None)
