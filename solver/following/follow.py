"""A slider is a continuation parameter: the skeleton of a run followed to other parameters of its scene."""

from dataclasses import replace

import numpy as np

from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..mechanics.load_control import LoadControl
from ..run.loading import sideways, vertical
from ..scene import LIMITS, Scene, SceneError
from .branch import Crowded, NotFollowed
from .moving import followed_branch, followed_fold
from .skeleton import Skeleton
from .solving import Solving
from .telling import resolved
from .wider import widened
from .without import without_contact

SAME = ("surface", "path", "hold", "nodes", "waves", "seed", "measured")  # not continuous
PATH = ("delta_bar", "u_x_max", "du_x", "du_z", "tolerance", "damping")  # of no effect on the jump into contact
HALVES = 2  # how often a move is halved, where the states wanted were too far
LEAST = 0.1  # delta_bar above a jump-in whose fold is lost, from which on it does not matter
NO_LATER = 1e-6  # nm by which a branch may begin after the state in which a slip lands, by rounding
WIDER = 3  # how often the patch grows in one move


def follow(skeleton: Skeleton, scene: Scene) -> Skeleton:
    """The Skeleton of a scene that differs from that of `skeleton` in continuous parameters.

    Raises NotFollowed where its run is another one than that of the skeleton, as far as that can be told from here.
    """
    _refuse(skeleton.scene, scene)
    spent = [0]
    found = _in_parts(skeleton, scene, HALVES, spent)
    return replace(found, evaluations=spent[0])


def _refuse(old, scene):
    for name in SAME:
        if getattr(old, name) != getattr(scene, name):
            raise NotFollowed(f"{name} does not change continuously")
    if scene.path != "shear":
        raise NotFollowed(f"path {scene.path!r} is computed")


def _in_parts(skeleton, scene, halves, spent):
    """Followed in one go or, where that fails, by way of parameters in between; spent[0] takes the evaluations."""
    try:
        return _patched(skeleton, scene, spent)
    except NotFollowed as failure:
        if not (failure.nearer and halves):
            raise
        middle = _between(skeleton.scene, scene, failure)
    return _in_parts(_in_parts(skeleton, middle, halves - 1, spent), scene, halves - 1, spent)


def _between(old, new, failure):
    """The Scene half-way; raises `failure` where there is none."""
    changed = {name: (getattr(old, name), getattr(new, name)) for name in LIMITS if name not in SAME}
    middle = {name: 0.5 * (a + b) for name, (a, b) in changed.items() if a != b}
    try:
        return new.changed(**middle)
    except SceneError:
        raise failure from None


def _patched(skeleton, scene, spent):
    """Followed on a patch wide enough."""
    for _ in range(WIDER):
        try:
            return _followed(skeleton, scene, spent)
        except Crowded as failure:
            last, skeleton = failure, widened(skeleton)
    raise last


def _followed(skeleton, scene, spent):
    contact = Contact(scene, skeleton.first, skeleton.nodes)
    try:
        jumps, lost = _jumps(contact, skeleton)
        if scene.delta_bar < lost + LEAST:
            raise NotFollowed("where the surfaces jump into contact is not known")
        if jumps and scene.delta < jumps[-1].load:
            return without_contact(contact, skeleton, jumps)
        if skeleton.contact is None:
            branches = _branches(contact, skeleton)
            return replace(skeleton, scene=scene, branches=branches, jumps=jumps, lost=lost)
    finally:
        spent[0] += contact.evaluations
    return _in_parts(skeleton.contact, scene, HALVES, spent)


def _jumps(contact, skeleton):
    """The Folds of the approach; none where they are no longer found, far below the scene's indentation."""
    scene, old = contact.scene, skeleton.scene
    if all(getattr(old, name) == getattr(scene, name) for name in LIMITS if name not in PATH):
        return skeleton.jumps, skeleton.lost
    try:
        return tuple(_jump(contact, fold) for fold in skeleton.jumps), skeleton.lost
    except NotFollowed:
        return (), skeleton.jumps[-1].load / old.delta_0


def _jump(contact, fold):
    solving = Solving(Equilibrium(contact, vertical(1.0)))
    return followed_fold(solving, fold, np.zeros(fold.v.size), "the jump into contact")


def _branches(contact, skeleton):
    scene, old, m = contact.scene, skeleton.branches, contact.size
    problem = Equilibrium(contact, sideways(1.0, -scene.delta))
    if scene.hold == "load":
        rest = (old[0].weights(np.zeros(1)) @ old[0].v)[0, : 2 * m]
        v, active = Solving(problem).at(rest, old[0].active[0], 0.0, "the state at U_x = 0")
        pressure = contact.pressure(problem.traction(v, active)[1])
        problem = LoadControl(contact, sideways(1.0, 0.0), pressure)
    solving, branches, change, start = Solving(problem, scene.damping), [], np.zeros(old[0].v[0].size), old[0].start
    period = skeleton.sites * scene.spacing
    for k, branch in enumerate(old, 1):
        end = None if branch.fold else (scene.spacing if branch.periodic else scene.u_x_max)
        reach, what = period if len(old) == 1 else None, f"branch {k}"
        found = followed_branch(solving, branch, start, end, change, reach, what)
        found = resolved(scene, skeleton.first, solving, found, what)
        branches.append(found)
        change, start = found.v[0] - branch.v[0], found.end
    if branches[skeleton.home].start > branches[-1].end - period + NO_LATER:
        raise NotFollowed("the surface rests after a slip where it has not been before")
    return tuple(branches)
