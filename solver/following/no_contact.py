"""Sliding without contact, at indentations before the jump into contact: the surfaces attract each other."""

import numpy as np

from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.loading import sideways
from .branch import Branch, NotFollowed
from .refinement import refined
from .skeleton import Skeleton
from .solver import Solver

SAME = 0.1  # units between states of one branch: with and without contact they differ by a unit or more
INTERVALS = 12  # of a lattice period, at first: the force is nearly a sine, and `refined` adds states where needed


def without_contact(contact: Contact, skeleton: Skeleton, jumps: tuple) -> Skeleton:
    """The Skeleton of a Contact's scene where the approach ends before the last of `jumps`, the jump into contact.

    Surfaces in contact might still adhere at that indentation, but the run comes from above and stays without contact.
    """
    scene = contact.scene
    if len(jumps) > 1:
        raise NotFollowed("the approach ends between two jumps into contact")
    if scene.hold == "load":
        raise NotFollowed("hold = 'load': there is no contact that carries a load")
    problem = Equilibrium(contact, sideways(1.0, -scene.delta))
    solver, states = Solver(problem), []
    loads = np.linspace(0.0, scene.spacing, INTERVALS + 1)
    v, active, before = problem.undeformed(0.0), np.zeros(contact.size, bool), 0.0
    for load in loads:
        guess = v + (load - before) * problem.direction
        v, active = solver.state(guess, active, load, "the state without contact", np.inf)
        states.append((v, active))
        before = load
    fold, m = jumps[0], contact.size
    if (states[0][0][m:] + scene.delta).min() < (fold.v[m : 2 * m] + fold.load).min():
        raise NotFollowed("the state without contact is not found")
    v, active = (np.array(rows) for rows in zip(*states, strict=True))
    branch = Branch(0.0, scene.spacing, loads / scene.spacing, v, active, periodic=True)
    branch = refined(scene, skeleton.first, solver, branch, 1)
    return Skeleton(scene, skeleton.first, (branch,), sites=1, jumps=jumps, contact=skeleton.contact or skeleton)


def refuse_apart(contact: Contact, skeleton: Skeleton) -> None:
    """Raises NotFollowed where the Skeleton has contact, but the surfaces may stay apart at the end of the approach.

    They may if the corrector leads from the undeformed surface to another equilibrium.
    """
    problem = Equilibrium(contact, sideways(1.0, -contact.scene.delta))
    size, v = problem.size, problem.undeformed(0.0)
    reached = skeleton.unknowns(0.0)[0, :size] if skeleton.held is None else skeleton.held.v
    try:
        apart, _ = Solver(problem).state(v, np.zeros(contact.size, bool), 0.0, "the state without contact", np.inf)
    except NotFollowed:
        return
    if np.abs(apart - reached).max() > SAME * problem.unit:
        raise NotFollowed("the surfaces may not have jumped into contact")
