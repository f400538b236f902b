"""Predicted runs while a visitor drags a slider, their certificates, and how both go to a browser (js/skeleton.js).

A worker continues the run on screen to the new parameters; the browser computes every increment from its Skeleton.
Once the slider rests the worker checks that it is the run of its scene; then the browser has the approach, too.

The deflated bytes are: uint32 length of the head, the head in JSON, the shear, and the approach if it is known. Of
either: of all branches in order, float64 loads (n,) in nm and their states (n, size). A state has u_x and the gap of
each node, and in shear U_z under a held load; of an approach that is its own mirror image, as that of a punch, those of
the left half. Fields are smooth: of the first state come int32 steps of the steps from node to node, and of others the
same of the change since the state before: 2 k for k >= 0, -2 k - 1 for others, as the low bytes of all, then the high
ones, which deflate by a seventh more than int16.
"""

import re
import zlib
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.limits import FLAT, increments_of
from app.service.packing import Frames, headed, of_scene
from solver import Certificate, NotFollowed, Scene, certify, follow
from solver.continuation.trace import Branch
from solver.following.skeleton import Skeleton
from solver.mechanics.cohesive_law import law_constants
from solver.run.frame import forces_and_area, largest_overlap, largest_safe_damping, least_repulsion
from solver.run.load_steps import load_steps_of
from solver.run.summary import widest

UNIT, UNIT_OF_FLATS = 8e-5, 1e-6  # nm: interpolated u_x then errs by less than 1e-3; all nodes of a flat err alike
LEVEL = 4  # of zlib: 6 takes 5 % fewer bytes, and three times as long, a tenth of a prediction
LARGEST = 2**15 - 1  # of a step in two bytes
GAIN = 4.0  # by which interpolation may amplify the error of rounding
MOST = 20_000  # force evaluations of a certificate, about a second: runs that flutter are computed in parts
KNOWN = 8  # certificates that a worker keeps, of 0.2 MB each
COARSEST = 1e-3  # nm: rounded more coarsely, states would give wrong forces; it is enough for moves of 33 nm


@dataclass(frozen=True)
class Followed:
    """A predicted run: its `body` for the browser, and the Skeleton from which the next prediction starts."""

    body: bytes
    skeleton: Skeleton


def followed(skeleton: Skeleton, scene: Scene) -> Followed | str:
    """Predict a scene from the Skeleton of a similar scene; return its Followed, or a str: why it failed."""
    try:
        with np.errstate(invalid="ignore"):  # `packed` finds it
            there = follow(skeleton, scene)
            return Followed(packed(there), there)
    except NotFollowed as why:
        return re.sub(r"\d[\d.e+-]*", "n", str(why))  # metrics count reasons without their numbers


@dataclass(frozen=True)
class Certified:
    """A certified run: its `body` for the browser, its exact Skeleton, and what its status and cautions say of it.

    checked: numbers of states, folds and landings. about: of the Frames of the run, without their bytes. Where the
    certificate does not hold, failure says what was found, and there is nothing else but about.evaluations.
    """

    about: Frames
    body: bytes = b""
    skeleton: Skeleton | None = None
    checked: tuple[int, int, int] = (0, 0, 0)
    failure: str = ""


_known: OrderedDict[Scene, Certificate] = OrderedDict()  # of this worker, by scenes of depth 0


def certified(scene: Scene, skeleton: Skeleton) -> Certified:
    """Check that the Skeleton of a scene is its run.

    Where this worker has certified a scene of another depth, that of its approach is not checked again.
    """
    key = scene.changed(delta_bar=0.0)
    made = certify(skeleton, limit=MOST, known=_known.get(key))
    if not made.holds:
        return Certified(Frames(evaluations=made.evaluations), failure="; ".join(map(repr, made.found)))
    _known[key] = made
    _known.move_to_end(key)
    while len(_known) > KNOWN:
        _known.popitem(last=False)
    try:
        body = packed(made.skeleton, made.approach)
    except NotFollowed as why:
        return Certified(Frames(evaluations=made.evaluations), failure=str(why))
    return Certified(_about(made), body, made.skeleton, (made.states, made.folds, made.landings))


def _about(made):
    """Return the Frames without bytes of a Certificate: of its states, and of the increments before its slips."""
    exact, step = made.skeleton, made.skeleton.scene.du_x * made.skeleton.scene.delta_t
    ends = [*exact.slips, *(branch.slip for branch in made.approach if branch.slip)]
    before = [branch.end // step * step for branch in exact.branches if branch.slip]
    loads = [state.load for branch in exact.branches for state in branch.states[: -1 if branch.slip else None]]
    frames = exact.frames([*loads, *(load for load in before if load > 0.0)], residuals=False)
    return Frames(
        frames=increments_of(exact.scene),
        evaluations=made.evaluations,
        residual=exact.residual,
        widest=widest(frames),
        overlap=largest_overlap(frames),
        safe_damping=largest_safe_damping(frames),
        sensitive=any(end.sensitive for end in ends),
    )


def packed(skeleton: Skeleton, approach: Sequence[Branch] = ()) -> bytes:
    """Return a Skeleton as bytes, with the approach if it is known.

    Raises NotFollowed if a state is not finite, or too far from the one before.
    """
    scene, m = skeleton.scene, skeleton.nodes
    first, sent = _part(scene, skeleton.first, m)
    shear, body = _traced(skeleton, skeleton.branches)
    head = of_scene(scene) | {
        "nodes": sent,
        "first": first,
        "law": law_constants(scene).tolist(),  # see there
        "least": least_repulsion(scene),
        "each": m / sent,  # nodes that one of them stands for
        "closed": m == scene.nodes,  # the last node is next to the first
        "held": skeleton.held is not None,
        "period": skeleton.period,
        "shear": shear | {"slips": [(slip.load, slip.F_bar, slip.L_bar, slip.A_bar) for slip in skeleton.slips]},
    }
    if approach:
        lowered, more = _traced(skeleton, approach, lowered=True)
        ends = [(b.end, *forces_and_area(scene, skeleton.tractions(b.v[-1:])[0])) for b in approach if b.slip]
        head["lowered"] = lowered | {"slips": ends, "increments": load_steps_of(scene)[0].increments}
        body += more
    return zlib.compress(headed(head, body), LEVEL)


def _traced(skeleton, branches, lowered=False):
    """Return the part of the head that describes these branches, and their bytes; lowered: they are the approach."""
    scene, m = skeleton.scene, skeleton.nodes
    unit = UNIT_OF_FLATS if scene.surface == "flat" else UNIT
    branches = [_refined(branch) for branch in branches]
    v = np.concatenate([branch.v for branch in branches])
    if not np.isfinite(v).all():
        raise NotFollowed("a predicted state is not finite")
    v[:, m : 2 * m] += scene.profile[skeleton.first : skeleton.first + m]
    _, sent = _part(scene, skeleton.first, m)
    images = np.hstack([-v[:, m - 1 :: -1], v[:, 2 * m - 1 : m - 1 : -1]])
    kept = (sent + 1) // 2 if lowered and np.abs(v[:, : 2 * m] - images).max() < unit else sent
    v = np.delete(v, np.r_[kept:m, m + kept : 2 * m], axis=1)
    unit, row, rows = _steps(v, unit, np.rint if lowered or scene.surface == "flat" else _in_sum)
    loads = np.concatenate([branch.loads for branch in branches])
    kinds = [{"states": len(b.states), "slips": b.slip is not None, "periodic": b.periodic} for b in branches]
    return {"unit": unit, "kept": kept, "branches": kinds}, loads.tobytes() + row.tobytes() + rows.tobytes()


def _refined(branch):
    """Return a Branch with states between its own until interpolation amplifies rounding by GAIN at most."""
    while True:
        t = branch.position(branch.loads)
        t[-1] = 1.0
        middles = branch.load_at((t[1:] + t[:-1]) / 2)
        gains = np.abs(branch.weights(middles)).sum(axis=1)
        if not gains.max(initial=0.0) > GAIN:
            return branch
        k = int(gains.argmax()) + 1
        loads = np.insert(branch.loads, k, middles[k - 1])
        v = np.insert(branch.v, k, branch.unknowns(middles[k - 1 : k]), axis=0)
        branch = Branch.of(loads, v, slip=branch.slip, periodic=branch.periodic)


def _part(scene: Scene, first: int, nodes: int) -> tuple[int, int]:
    """Return (first node, number of nodes) that are sent: of a flat those in the middle, as all are alike."""
    if scene.surface != "flat":
        return first, nodes
    return max(0, (scene.nodes - FLAT) // 2), min(FLAT, nodes)


def _in_sum(v):
    """Round v (n, size) so that sums over nodes are right to one: forces then err by 1e-5 instead of 3e-4."""
    return np.diff(np.rint(np.cumsum(v, axis=1)), axis=1, prepend=0.0)


def _steps(v, unit, rounded):
    """Return (unit, int32 steps of the steps of the first of the states v (n, size), those of the others in bytes)."""
    while True:
        changes = np.diff(rounded(v / unit), axis=0, prepend=0.0)
        steps = np.diff(changes, n=2, axis=1, prepend=np.zeros((len(v), 2)))
        if (largest := np.abs(steps[1:]).max(initial=0.0)) <= LARGEST:
            others = np.where(steps[1:] < 0.0, -2.0 * steps[1:] - 1.0, 2.0 * steps[1:]).astype("<u2")
            return unit, steps[0].astype("<i4"), others.view(np.uint8).reshape(-1, 2).T
        unit *= np.ceil(largest / LARGEST)
        if unit > COARSEST:
            raise NotFollowed("a predicted state is too far from the one before")
