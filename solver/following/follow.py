"""The skeleton of a run, followed to other parameters of its scene."""

from dataclasses import replace

import numpy as np

from ..continuation.state import NotConverged
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.loading import sideways, vertical
from ..scene import LIMITS, Scene, SceneError
from ..threads import one_thread
from .branch import Crowded, NotFollowed
from .held import followed_held
from .moved import NEAR, moved_branch, moved_folds
from .no_contact import refuse_apart, without_contact
from .patch import widened
from .refinement import refined
from .skeleton import Skeleton
from .solver import Solver

SAME = ("surface", "path", "hold", "nodes", "waves", "seed", "measured")  # parameters that are not continuous
PATH = ("delta_bar", "u_x_max", "du_x", "du_z", "tolerance", "damping")  # of no effect on the jump into contact
HALVES = 2  # how often a move is halved where states or folds moved too far, to quarters
NO_LATER = 1e-6  # nm by which a branch may begin after the state in which a slip lands, by rounding
WIDER = 3  # how often the patch grows in one move: each time by a quarter or more


@one_thread()
def follow(skeleton: Skeleton, scene: Scene) -> Skeleton:
    """The Skeleton of a scene that differs from that of `skeleton` in continuous parameters.

    Raises NotFollowed where its run does not continue that of the skeleton. It does not check where slips land.
    """
    for name in SAME:
        if getattr(skeleton.scene, name) != getattr(scene, name):
            raise NotFollowed(f"{name} does not change continuously")
    if scene.path != "shear":
        raise NotFollowed(f"path = {scene.path!r} cannot be followed: use path=shear")
    spent = [0]
    return replace(_in_parts(skeleton, scene, HALVES, spent), evaluations=spent[0])


def _in_parts(skeleton, scene, halves, spent):
    """The Skeleton of the scene, directly or through scenes in between; adds its evaluations to spent[0]."""
    try:
        return moved(skeleton, scene, spent)
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


def moved(skeleton: Skeleton, scene: Scene, spent: list[int]) -> Skeleton:
    """The Skeleton of the scene, directly, on a patch that is wide enough; adds its evaluations to spent[0]."""
    for _ in range(WIDER):
        try:
            return _moved(skeleton, scene, spent)
        except Crowded as failure:
            last, skeleton = failure, widened(skeleton)
        except NotConverged as failure:  # a pull-off under a held load
            raise NotFollowed(str(failure)) from None
    raise last


def _moved(skeleton, scene, spent):
    contact = Contact(scene, skeleton.first, skeleton.nodes)
    try:
        jumps = _jumps(contact, skeleton)
        if jumps and scene.delta < jumps[-1].load:
            return without_contact(contact, skeleton, jumps)
        if skeleton.contact is None:
            held, branches, residual = _branches(contact, skeleton)
            new = replace(skeleton, scene=scene, branches=branches, jumps=jumps or (), held=held, residual=residual)
            if jumps is None:
                refuse_apart(contact, new)
            return replace(new, lost=jumps is None)
    finally:
        spent[0] += contact.evaluations
    return moved(skeleton.contact, scene, spent)


def _jumps(contact, skeleton):
    """The Folds of the approach; None where they are lost."""
    scene, old, jumps = contact.scene, skeleton.scene, skeleton.jumps
    if skeleton.lost:
        return None
    same = all(getattr(old, name) == getattr(scene, name) for name in LIMITS if name not in PATH)
    if same and all(np.isfinite(fold.residual) for fold in jumps):
        return jumps
    solver = Solver(Equilibrium(contact, vertical(1.0)))
    try:
        return tuple(solver.fold(fold, "the jump into contact") for fold in jumps)
    except NotFollowed:
        return None


def _branches(contact, skeleton):
    """(Held or None, the Branches, the largest residual of their states, nm)."""
    scene, old, held = contact.scene, skeleton.branches, None
    problem = Equilibrium(contact, sideways(1.0, -scene.delta))
    if scene.hold == "load":
        held = followed_held(contact, skeleton.held, scene.delta - skeleton.scene.delta)
        pressure = contact.pressure(problem.traction(held.v, held.active)[1])
        problem = Equilibrium(contact, sideways(1.0, 0.0), pressure)
    solver, period = Solver(problem, scene.damping), skeleton.sites * scene.spacing
    folds = moved_folds(solver, old)
    start, branches, near = old[0].start, [], NEAR if np.isfinite(skeleton.residual) else 0  # 0: of the same run
    if period and folds[-1] and not skeleton.home:  # the states in which slips land belong to the first branch
        start = min(0.0, folds[-1].load - period)
    for k, (branch, fold) in enumerate(zip(old, folds, strict=True), 1):
        end = fold.load if fold else scene.spacing if branch.periodic else scene.u_x_max
        new = moved_branch(solver, branch, start, end, fold, k, near)
        branches.append(refined(scene, skeleton.first, solver, new, k))
        start = new.end
    if period and folds[-1] and branches[skeleton.home].start > start - period + NO_LATER:
        raise NotFollowed("a slip lands before the first state of the branch that should follow it")
    return held, tuple(branches), solver.residual
