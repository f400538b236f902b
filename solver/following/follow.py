"""The skeleton of a run, followed to other parameters of its scene."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..continuation.inverse import Solves
from ..continuation.landing import motion_to_rest
from ..continuation.rest import Judge
from ..continuation.state import NotConverged
from ..continuation.trace import Branch, Trace
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..mechanics.surface import closed_stiffness
from ..run.load_steps import sideways, vertical
from ..scene import CHOICES, LIMITS, Scene, SceneError, checked_scene
from ..threads import computation
from .moved import NotFollowed, Solver, moved_branch, moved_folds
from .refinement import refined
from .skeleton import Held, Skeleton, skeleton_in

DISCRETE = *CHOICES, "nodes", "waves", "seed", "measured"  # parameters that are not continuous
# parameters that do not change the jump into contact: they belong to the path, or to how it is computed
NOT_OF_THE_JUMP = ("delta_bar", "u_x_max", "du_x", "du_z", "tolerance", "damping")
HALVES = 2  # most times that a move is halved because states or folds move too far: into quarters
LATER = 1e-6  # nm, round-off: a branch may begin this much after the state in which a slip lands
# delta_n, the least gap of nodes outside the patch. Their springs pull with 5e-6 of phi_n/delta_n, 1e-6 of the forces
OUTSIDE = 15.0
HELD_RESIDUAL = 1e-8  # nm, of the state whose load is held; its derivatives then are accurate to 1e-5
HELD_MOVES = 1.5  # units that this state may move, beside the indentation; farther off, it lies on another branch
SIGN_ACCURACY = 1e-3  # relative, of a linear solve: only the sign of its result is used
TWO_STATES = 0.1  # units: states farther apart are two equilibria; with and without contact they differ by a unit


@computation
def follow(skeleton: Skeleton, scene: Scene) -> Skeleton:
    """Continues a run to other parameters, for a small share of its cost.

    It assumes that slips land on the branches they landed on before, and checks only that they keep the contact.

    Parameters: skeleton: as of `skeleton_of`; scene: differs from its scene in continuous parameters only.
    Returns the Skeleton of the scene.
    Raises NotFollowed where the run of the scene does not continue that of the skeleton.

    Example: `follow(skeleton_of(Scene()), Scene(E=72.0)).slips`
    """
    skeleton, scene = skeleton_in(skeleton), checked_scene(scene)
    for name in DISCRETE:
        if getattr(skeleton.scene, name) != getattr(scene, name):
            raise NotFollowed(f"{name} does not change continuously")
    if scene.path != "shear":
        raise NotFollowed(f"path = {scene.path!r} cannot be followed: use path=shear")
    followed = _in_parts(skeleton, scene, HALVES)
    try:
        return replace(followed, evaluations=followed.evaluations + _checked_landings(followed))
    except NotConverged as failure:
        raise NotFollowed(str(failure)) from None


def _in_parts(skeleton, scene, halves):
    """The Skeleton of the scene, at once or by scenes in between."""
    try:
        return moved_at_once(skeleton, scene)
    except NotFollowed as failure:
        if not (failure.nearer and halves):
            raise
        middle, spent = _between(skeleton.scene, scene, failure), failure.evaluations
    half = _in_parts(skeleton, middle, halves - 1)
    whole = _in_parts(half, scene, halves - 1)
    return replace(whole, evaluations=spent + half.evaluations + whole.evaluations)


def _between(old, new, failure):
    """The Scene half-way; raises `failure` where there is none."""
    changed = {name: (getattr(old, name), getattr(new, name)) for name in LIMITS if name not in DISCRETE}
    middle = {name: _halfway(a, b) for name, (a, b) in changed.items() if a != b}
    try:
        return new.changed(**middle)
    except SceneError:
        raise failure from None


def _halfway(a, b):
    """The mean; between a stiffness and inf, the stiffness with half the compliance."""
    return 0.5 * (a + b) if np.isfinite(a + b) else 2.0 * min(a, b)


def moved_at_once(skeleton: Skeleton, scene: Scene) -> Skeleton:
    """The Skeleton of the scene, not by scenes in between."""
    contact = Contact(scene, skeleton.first, skeleton.nodes)
    try:
        new = _moved(contact, skeleton)
    except NotConverged as failure:  # a pull-off under a held load
        raise NotFollowed(str(failure)) from None
    except NotFollowed as failure:
        failure.evaluations = contact.evaluations
        raise
    states = (state for branch in new.branches for state in branch.states)
    if min(contact.outside(state.v[: 2 * contact.size].reshape(2, -1)) for state in states) < OUTSIDE * scene.delta_n:
        raise NotFollowed("nodes outside the patch may interact")
    return replace(new, evaluations=contact.evaluations)


def _moved(contact, skeleton):
    """The Skeleton of a Contact's scene."""
    scene, jumps = contact.scene, _jumps(contact, skeleton)
    if jumps and scene.delta < jumps[-1].load:
        raise NotFollowed("the approach ends before the jump into contact")
    held, trace, residual = _trace(contact, skeleton, jumps or ())
    new = replace(skeleton, scene=scene, trace=trace, held=held, residual=residual)
    if jumps is None:
        refuse_apart(contact, new)
    return replace(new, lost=jumps is None)


def _jumps(contact, skeleton):
    """The folds of the approach; None where they are lost."""
    scene, old, jumps = contact.scene, skeleton.scene, skeleton.trace.jumps
    if skeleton.lost:
        return None
    same = all(getattr(old, name) == getattr(scene, name) for name in LIMITS if name not in NOT_OF_THE_JUMP)
    if same and all(np.isfinite(fold.residual) for fold in jumps):
        return jumps
    solver = Solver(Equilibrium(contact, vertical(1.0)))
    try:
        return tuple(solver.fold(fold, "the jump into contact") for fold in jumps)
    except NotFollowed:
        return None


def _trace(contact, skeleton, jumps):
    """(Held or None, the Trace, the largest residual of its states, nm)."""
    scene, old, home, held = contact.scene, skeleton.branches, skeleton.trace.home, None
    problem = Equilibrium(contact, sideways(1.0, -scene.delta))
    if scene.hold == "load":
        held = followed_held(contact, skeleton.held, scene.delta - skeleton.scene.delta)
        pressure = contact.pressure(problem.traction(held.v)[1])
        problem = Equilibrium(contact, sideways(1.0, 0.0), pressure)
    solver, period = Solver(problem, scene.damping), skeleton.sites * scene.spacing
    folds = moved_folds(solver, old)
    start, branches = old[0].start, list[Branch]()
    if period and folds[-1] and not home:  # the states in which slips land belong to the first branch
        start = min(0.0, folds[-1].load - period)
    for k, (branch, fold) in enumerate(zip(old, folds, strict=True), 1):
        end = fold.load if fold else scene.spacing if branch.periodic else scene.u_x_max
        new = moved_branch(solver, branch, start, end, fold, k)
        branches.append(refined(scene, skeleton.first, solver, new, k))
        start = new.end
    if period and folds[-1] and branches[home].start > start - period + LATER:
        raise NotFollowed("a slip lands before the first state of the branch that should follow it")
    refuse_disorder([fold.load for fold in folds if fold], home, period)
    return held, Trace(tuple(branches), home, period, jumps), solver.residual


def refuse_disorder(loads: Sequence[float], home: int, period: float) -> None:
    """Raises NotFollowed where slips at loads (nm) are not in their order, the next pass over `home` included."""
    passed = [*loads, loads[home] + period] if period and home < len(loads) else loads
    if any(after <= before for before, after in pairwise(passed)):
        raise NotFollowed("slips come in another order, which following does not show", nearer=True)


def followed_held(contact: Contact, old: Held, deeper: float = 0.0) -> Held:
    """The Held of a Contact's scene, from that of a scene nearby whose indentation is smaller by `deeper`, nm.

    Raises NotFollowed where one of them is stable under its load and the other is not.
    """
    problem, what = Equilibrium(contact, sideways(1.0, -contact.scene.delta)), "the state whose load is held"
    solver = Solver(problem, tolerance=HELD_RESIDUAL)
    v = solver.state(old.v, 0.0, what, HELD_MOVES + abs(deeper) / problem.unit)
    kind = "" if _stiffens(problem, v) else "control"
    if old.kind is not None and bool(kind) != bool(old.kind):
        raise NotFollowed(f"{what} is {'un' if kind else ''}stable under it, unlike before")
    return Held(v, old.kind or kind)


def _stiffens(problem, v):
    """Whether the pressure rises with the indentation; else the state is unstable under a held load."""
    linearised, lower = problem.linearised(v), np.repeat([0.0, 1.0], problem.nodes)
    lowered = Solves(linearised)(lower, accuracy=SIGN_ACCURACY)  # by a unit of indentation
    return problem.contact.pressure(linearised.pull(lowered)[1]) > 0.0


def _checked_landings(skeleton):
    """Force evaluations to see that slips keep the contact; raises NotFollowed where one loses it.

    A punch above first touch is held by adhesion alone, which is weakest between two sites. Where surfaces apart are in
    equilibrium, too, the motion from the end of the branch decides.
    """
    scene = skeleton.scene
    if skeleton.held is not None or scene.delta >= 0.0 or not (skeleton.lost or skeleton.trace.jumps):
        return 0
    problem = skeleton.problem()
    solver, how = Solver(problem), (Judge(scene.damping), scene.damping, closed_stiffness(scene))
    for fold in (branch.slip for branch in skeleton.branches if branch.slip):
        landed = skeleton.unknowns(fold.load + LATER)[0]
        if _apart(solver, fold.load, landed):
            slip = motion_to_rest(problem, fold, *how)
            if np.abs(slip.after.v - landed).max() > TWO_STATES * problem.unit:
                raise NotFollowed(f"the slip at {fold.load:g} nm no longer ends in contact")
    return problem.evaluations


def refuse_apart(contact: Contact, skeleton: Skeleton) -> None:
    """Raises NotFollowed where the Skeleton has contact, but the surfaces may stay apart at the end of the approach.

    They may if the corrector leads from the undeformed surface to another equilibrium.
    """
    solver = Solver(Equilibrium(contact, sideways(1.0, -contact.scene.delta)))
    reached = skeleton.unknowns(0.0)[0, : solver.problem.size] if skeleton.held is None else skeleton.held.v
    if _apart(solver, 0.0, reached):
        raise NotFollowed("the surfaces may not have jumped into contact")


def _apart(solver, load, reached):
    """Whether the corrector leads from the undeformed surface to another equilibrium than the one `reached`."""
    try:
        apart = solver.state(solver.problem.undeformed(load), load, "the state without contact", np.inf)
    except NotFollowed:
        return False
    return np.abs(apart - reached).max() > TWO_STATES * solver.problem.unit
