"""Left of the jump-in: the surfaces slide past each other, drawn together but apart."""

import numpy as np

from ..mechanics.equilibrium import Equilibrium
from ..run.loading import sideways
from .branch import Branch, NotFollowed
from .skeleton import Skeleton
from .solving import Solving
from .telling import resolved

INTERVALS = 12  # between states of a lattice period


def without_contact(contact, skeleton, jumps):
    """The Skeleton of a Contact's scene, whose approach ends before the jump-in, the last of `jumps`.

    The run comes from above: though surfaces in contact might still adhere at that indentation, it never gets there.
    """
    scene = contact.scene
    if len(jumps) > 1:
        raise NotFollowed("it is left of a jump into contact, but not of the first")
    if scene.hold == "load":
        raise NotFollowed("there is no contact whose load could be held")
    problem = Equilibrium(contact, sideways(1.0, -scene.delta))
    solving, states = Solving(problem), []
    loads = np.linspace(0.0, scene.spacing, INTERVALS + 1)
    v, active, before = problem.undeformed(0.0), np.zeros(contact.size, bool), 0.0
    for load in loads:
        v, active = solving.at(v + (load - before) * problem.direction, active, load, "the state without contact")
        states.append((v, active))
        before = load
    fold, m = jumps[0], contact.size
    if (states[0][0][m:] + scene.delta).min() < (fold.v[m : 2 * m] + fold.load).min():
        raise NotFollowed("the state without contact is not found")
    v, active = (np.array([state[part] for state in states]) for part in (0, 1))
    branch = Branch(0.0, scene.spacing, v, active, periodic=True)
    branch = resolved(scene, skeleton.first, solving, branch, "the run without contact")
    return Skeleton(scene, skeleton.first, (branch,), sites=1, jumps=jumps, contact=skeleton.contact or skeleton)
