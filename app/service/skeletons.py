"""Predicted runs while a visitor drags a slider, and how they go to a browser (static/js/skeleton.js).

A worker continues the run on screen to the new parameters; the browser computes every increment from its Skeleton.

The deflated bytes are: uint32 length of the head, the head in JSON, and, of all branches in order, float64 loads (n,)
in nm and their states (n, size). A state has u_x and the gap of each node, and U_z under a held load. Of the first
state come int32 steps from node to node, of the others int16 steps of the change since the state before.
"""

import re
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.limits import FLAT
from app.service.packing import headed, of_scene
from solver import NotFollowed, Scene, follow
from solver.continuation.trace import Branch
from solver.following.skeleton import Skeleton
from solver.mechanics.cohesive_law import law_constants
from solver.run.frame import least_repulsion

UNIT, UNIT_OF_FLATS = 8e-5, 1e-6  # nm: interpolated u_x then errs by less than 1e-3; all nodes of a flat err alike
LEVEL = 4  # of zlib: 6 takes 1 to 3 % fewer bytes, and three times as long, which was a tenth of a prediction
LARGEST = 2**15 - 1  # of an int16
GAIN = 4.0  # by which interpolation may amplify the error of rounding
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


def packed(skeleton: Skeleton) -> bytes:
    """Return a Skeleton as bytes. Raises NotFollowed if a state is not finite, or too far from the one before."""
    scene, m = skeleton.scene, skeleton.nodes
    branches = [_refined(branch) for branch in skeleton.branches]
    v = np.concatenate([branch.v for branch in branches])
    if not np.isfinite(v).all():
        raise NotFollowed("a predicted state is not finite")
    v[:, m : 2 * m] += scene.profile[skeleton.first : skeleton.first + m]
    first, sent = _part(scene, skeleton.first, m)
    v = np.delete(v, np.r_[sent:m, m + sent : 2 * m], axis=1)
    unit, row, rows = _steps(v, *((UNIT_OF_FLATS, np.rint) if scene.surface == "flat" else (UNIT, _in_sum)))
    head = of_scene(scene) | {
        "nodes": sent,
        "first": first,
        "unit": unit,
        "law": law_constants(scene).tolist(),  # see there
        "least": least_repulsion(scene),
        "each": m / sent,  # nodes that one of them stands for
        "closed": m == scene.nodes,  # the last node is next to the first
        "held": skeleton.held is not None,
        "period": skeleton.period,
        "branches": [_branch(branch) for branch in branches],
        "slips": [(slip.load, slip.F_bar, slip.L_bar, slip.A_bar) for slip in skeleton.slips],
    }
    loads = np.concatenate([branch.loads for branch in branches])
    return zlib.compress(headed(head, loads.tobytes() + row.tobytes() + rows.tobytes()), LEVEL)


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
    """Return (unit, int32 steps of the first of the states v (n, size), int16 steps of the others)."""
    while True:
        steps = np.diff(np.diff(rounded(v / unit), axis=0, prepend=0.0), axis=1, prepend=0.0)
        if (largest := np.abs(steps[1:]).max(initial=0.0)) <= LARGEST:
            return unit, steps[0].astype("<i4"), steps[1:].astype("<i2")
        unit *= np.ceil(largest / LARGEST)
        if unit > COARSEST:
            raise NotFollowed("a predicted state is too far from the one before")


def _branch(branch) -> dict[str, Any]:
    """Return what the head has of a Branch."""
    return {"states": len(branch.states), "slips": branch.slip is not None, "periodic": branch.periodic}
