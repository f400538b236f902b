"""A slider is a continuation parameter: the skeleton of a run followed to other parameters of its scene."""

from dataclasses import fields

import numpy as np

from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.loading import sideways, vertical
from ..scene import LIMITS, SURFACES
from .branch import NotFollowed
from .moving import followed_branch, followed_fold
from .skeleton import Skeleton
from .solving import Solving

DISCRETE = ("surface", "path", "hold", "nodes", "waves", "seed", "measured")


def follow(skeleton, scene):
    """The Skeleton of a scene that differs from that of `skeleton` in continuous parameters.

    Raises NotFollowed where its run is another one than that of the skeleton, as far as that can be told from here.
    """
    old = skeleton.scene
    for name in DISCRETE:
        if getattr(old, name) != getattr(scene, name):
            raise NotFollowed(f"{name} is not a continuous parameter")
    if scene.path != "shear":
        raise NotFollowed(f"path {scene.path!r} is computed")
    contact = Contact(scene, skeleton.first, skeleton.nodes, normal_only=scene.phi_ratio == 0.0)
    jumps = tuple(_jumps(contact, skeleton))
    branches = _branches(contact, skeleton)
    tractions = tuple(_tractions(contact, branch) for branch in branches)
    return Skeleton(
        scene, skeleton.first, branches, tractions, skeleton.home, skeleton.sites, jumps, contact.evaluations
    )


def _jumps(contact, skeleton):
    for fold in skeleton.jumps:
        solving = Solving(Equilibrium(contact, vertical(1.0)))
        yield followed_fold(solving, fold, np.zeros(fold.v.size), "the jump into contact")


def _branches(contact, skeleton):
    scene, old, held = contact.scene, skeleton.branches, None
    loading = sideways(1.0, -scene.delta)
    m = contact.size
    if scene.hold == "load":
        problem = Equilibrium(contact, loading)
        v, active = Solving(problem).at(old[0].v[0][: 2 * m], old[0].active[0], 0.0, "the state at U_x = 0")
        held = contact.pressure(problem.traction(v, active))
    solving = Solving(Equilibrium(contact, loading, held))
    change = np.zeros(old[0].v[0].size)
    branches, start = [], 0.0
    for k, branch in enumerate(old):
        end = None if branch.fold else (scene.spacing if skeleton.sites else scene.u_x_max)
        found = followed_branch(solving, branch, start, end, change, f"branch {k + 1}")
        branches.append(found)
        change, start = found.v[0] - branch.v[0], found.end
    return tuple(branches)


def _tractions(contact, branch):
    m = contact.size
    pairs = zip(branch.v, branch.active, strict=True)
    return np.array([contact.traction(v[: 2 * m].reshape(2, m), active) for v, active in pairs])
