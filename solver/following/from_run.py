"""The skeleton of a run from its trace, some of whose states describe it."""

from dataclasses import replace
from math import inf

import numpy as np

from ..continuation.trace import Trace
from ..mechanics.contact import patch
from ..run.loadpath import Checkpoint, until
from ..scene import Scene, checked_scene, refuse_other
from ..threads import computation
from .follow import moved_at_once
from .moved import NotFollowed
from .refinement import forces_of, thinned
from .skeleton import Held, Skeleton

SAME_END = 1e-4  # nm: ends of branches that are nearer are the same end
BRANCHES = 12  # branches of a skeleton; nearly all sliding runs repeat themselves after three
FEWEST_STATES = 3  # states of a branch; others cannot be interpolated from fewer
FORCE_ERROR = 1e-3  # of the largest force: error at the states of the run that followed runs promise to stay below
MINOR_FORCE = 0.1  # of the larger force: least scale for errors of the smaller one, which may be held near zero
WIDE = 0.25  # of the length of a branch, the widest gap between two of its states
SLIP_ERROR = 1e-4  # nm: error of slips that followed runs promise to stay below


def skeleton_of(scene: Scene, limit: float = inf) -> Skeleton:
    """Computes a run and describes it by its branches, for `follow` and `sensitivities`.

    Parameters: scene; limit: processor time, s.
    Returns the Skeleton of the run.
    Raises NotFollowed where the run has none, NotConverged as the run does, OutOfTime over the limit.

    Example: `skeleton_of(Scene()).slips`
    """
    _refuse_path(scene)  # before it is computed
    spent, checkpoint = 0, Checkpoint()
    for frame, checkpoint in until(scene, lambda frame: frame.repeated, limit):  # noqa: B007  the last one counts
        spent += frame.evaluations
    skeleton = skeleton_from(scene, checkpoint)
    return replace(skeleton, evaluations=skeleton.evaluations + spent)


@computation
def skeleton_from(scene: Scene, checkpoint: Checkpoint) -> Skeleton:
    """Describes a run by its branches: evaluates each state, and solves those that do not hold.

    Parameters: scene; checkpoint: at the end of its run, or where the run begins to repeat itself.
    Returns the Skeleton of the run.
    Raises NotFollowed where the run has no skeleton, or one that does not describe it, SceneError for the checkpoint of
    another scene.

    Example: `skeleton_from(Scene(), advance(Scene(), budget=60.0)[1])`
    """
    _refuse_path(scene)
    if not isinstance(checkpoint, Checkpoint):
        remedy = "give the checkpoint that `advance` returns, or use skeleton_of(scene)"
        raise TypeError(f"checkpoint = {type(checkpoint).__name__}; allowed: a Checkpoint; {remedy}")
    refuse_other(scene, checkpoint.scene, "checkpoint")
    trace = checkpoint.trace if checkpoint.stage == "shear" else None
    if trace is None or trace.branches[0].start != 0.0 or len(trace.branches[0].states) < 2 > len(trace.branches):
        raise NotFollowed("the run has not slid yet, or was not recorded from its start")
    whole = trace.branches[0].states[0].v.size // 2 == scene.nodes
    first = 0 if whole else patch(scene)[0]
    guess, passed = _guess(scene, first, trace)
    skeleton = moved_at_once(guess, scene)
    _compare(skeleton, passed, guess)
    return skeleton


def _refuse_path(scene):
    if checked_scene(scene).path != "shear":
        raise NotFollowed(f"path = {scene.path!r} cannot be followed: use path=shear")


def _guess(scene, first, trace: Trace):
    """(the Skeleton of states of the Trace, not solved for; the Branches that it describes)."""
    begin, branches, home = trace.branches[0], list(trace.branches), trace.home
    m = begin.states[0].v.size // 2
    held = Held(begin.states[0].v[: 2 * m]) if scene.hold == "load" else None
    if begin.slip and begin.slip.kind == "control":
        branches, home = branches[1:], max(home - 1, 0)
    if trace.period:
        branches, home = _longest(branches, home, trace.period, m)
    elif branches[-1].end < scene.u_x_max - scene.du_x * scene.delta_t:
        raise NotFollowed("the run has not come to where it repeats itself")
    if len(branches) > BRANCHES:
        raise NotFollowed(f"{len(branches)} branches until the run repeats itself, at most {BRANCHES} are followed")
    made = tuple(_branch(scene, first, branch) for branch in branches)
    lost = any(slip.kind != "fold" for slip in trace.jumps)
    described = Trace(made, home, trace.period, () if lost else trace.jumps)
    return Skeleton(scene, first, described, lost, held=held), branches


def _longest(branches, home, period, m):
    """(branches, home), without the branch before `home` if that is the end of the last one, a period before."""
    if not home:
        return branches, home
    part, last = branches[home - 1], branches[-1]
    if last.start - period > part.start or abs(last.end - period - part.end) > SAME_END:
        return branches, home
    along = np.zeros(last.states[0].v.size)  # the unknowns that move on with the load
    along[:m] = 1.0
    return [*branches[: home - 1], last.shifted(-period, along), *branches[home:-1]], home - 1


def _branch(scene, first, branch):
    """The Branch of the states that it takes to describe it."""
    if branch.slip and branch.slip.kind != "fold":
        raise NotFollowed(f"a branch ends by {branch.slip.kind} at {branch.end:g} nm: that is computed")
    if len(branch.states) < FEWEST_STATES:
        raise NotFollowed(f"a branch that begins at {branch.start:g} nm has only {len(branch.states)} states")
    return thinned(scene, first, _filled(branch))


def _filled(branch):
    """The Branch with guesses of states in gaps wider than WIDE; a polynomial over them amplifies errors of the others.

    A run keeps few states where the others give them, as on a straight branch.
    """
    while True:
        loads = branch.loads
        gaps = np.diff(loads)
        k = int(gaps.argmax())
        if gaps[k] <= WIDE * (loads[-1] - loads[0]):
            return branch
        branch = branch.added(branch.at(0.5 * (loads[k] + loads[k + 1])))


def _compare(skeleton, passed, guess):
    """Raises NotFollowed where a Skeleton is not its run."""
    ends = [(new.end, old.end) for new, old in zip(skeleton.branches, guess.branches, strict=True) if new.slip]
    if any(abs(new - old) > SLIP_ERROR for new, old in ends):
        raise NotFollowed("the skeleton's slips are not those of its run")
    slips = np.array([np.inf, *(old for _, old in ends)])  # there, states before and after have the same load
    states = [state for branch in passed for state in branch.states if np.abs(state.load - slips).min() > SLIP_ERROR]
    v, loads = np.array([state.v for state in states]), np.array([state.load for state in states])
    exact, largest = forces_of(skeleton.scene, skeleton.first, v, MINOR_FORCE)
    curve = forces_of(skeleton.scene, skeleton.first, skeleton.unknowns(loads))[0]
    if not (np.abs(curve - exact) <= FORCE_ERROR * largest).all():
        raise NotFollowed("the skeleton's forces are not those of its run")
