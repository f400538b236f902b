"""Work against precision of one run: its cost, its distance from a reference, and whether its branches are right.

Errors on a branch are measured against `fast` at the smallest tolerance and a tenth of the increment, without repeating
states by lattice periods, at the loads that both runs have: nothing is interpolated.
`landings` finds the right branches, by the paper's GFMD alone.
"""

from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import zip_longest
from math import inf
from time import thread_time
from typing import Any

import numpy as np

from ..continuation.state import NotConverged
from ..run.frame import Frame, SlipEvent
from ..run.loadpath import ALL, load_path
from ..scene import Scene, SceneError

QUANTITIES = ("F", "L", "A")
REFINED = (10, 5, 2, 1)  # divisors of the scene's increments for the reference: the first one in range
TIGHTEST = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8)  # nm: tolerances tried for the reference, where round-off allows
SAME_BRANCH = 0.1  # of min(delta_n, delta_t): equilibria farther apart are two; a node that slips moves farther
NOTHING = np.array([1e-30, 1e-30, 1e-6])  # of F_bar, L_bar, A_bar: the least scale of an error, where all is zero
# of the larger of F and L: the least scale of the error of a force that stays below, as L on the flat does. So its
# relative error is at most 100 times that of the other force
SMALLEST = 0.01


@dataclass
class Curves:
    """What a comparison needs of a run, by U_x as `position` rounds it; seconds of one core."""

    scene: Scene
    rows: dict[float, tuple[float, ...]] = field(default_factory=dict)  # (F_bar, L_bar, A_bar) along the shear
    states: dict[float, Frame] = field(default_factory=dict)  # some Frames of the shear
    slips: list[SlipEvent] = field(default_factory=list)
    seconds: float = 0.0
    evaluations: int = 0
    failure: str | None = None
    stopped: bool = False  # for taking too long

    @property
    def shear_slips(self) -> list[float]:
        """Loads (nm) of the slips in shear, in order."""
        return [event.load for event in self.slips if event.stage == "shear"]


@dataclass(frozen=True)
class SlipError:
    """One slip of the reference and its error in a run; None: unknown (no slip, no increment there, or sensitive)."""

    stage: str
    load: float  # nm, in the reference
    position: float | None  # nm, distance of the run's nearest slip
    force: float | None  # error of F_bar there over the largest F_bar
    same_branch: bool | None  # whether both are in one state right after it, at the same load


@dataclass(frozen=True)
class Point:
    """A run in the diagram: the value of the scene's parameter `sweep`, a method of `methods.SERIES`, and the outcome.

    F, L, A: largest error before the first slip, over the largest value of the quantity.
    """

    sweep: str
    series: str
    value: float
    seconds: float | None = None
    evaluations: int | None = None
    F: float | None = None
    L: float | None = None
    A: float | None = None
    slips: tuple[SlipError, ...] = ()
    failure: str | None = None

    @property
    def branch_error(self) -> float | None:
        """The largest of the errors before the first slip."""
        errors = [getattr(self, name) for name in QUANTITIES]
        return None if None in errors else max(errors)

    @property
    def branches(self) -> tuple[int, int]:
        """(slips after which the branch was that of the reference, slips after which it is known)."""
        judged = [slip.same_branch for slip in self.slips if slip.same_branch is not None]
        return sum(judged), len(judged)

    @property
    def right(self) -> bool:
        """Whether no slip led to another branch."""
        return self.branches[0] == self.branches[1]

    def worst(self, name: str) -> float | None:
        """The largest `position` or `force` error of the slips in shear up to the first wrong branch."""
        shear = [slip for slip in self.slips if slip.stage == "shear"]
        wrong = next((k for k, slip in enumerate(shear) if slip.same_branch is False), len(shear))
        errors = [getattr(slip, name) for slip in shear[: wrong + 1]]
        return max((value for value in errors if value is not None), default=None)


def position(frame: Frame) -> float:
    """U_x, nm, by which states of different runs are matched: without the round-off of increments."""
    return round(frame.U_x, 9)


def refined(scene: Scene) -> Scene:
    """The scene with a tenth of both increments, or the smallest part in range."""
    for name in ("du_x", "du_z"):
        parts = [getattr(scene, name) / divisor for divisor in REFINED]
        scene = scene.changed(**{name: in_range(scene, name, parts)[0]})
    return scene


def in_range(scene: Scene, name: str, values: Iterable[float]) -> list[float]:
    """The values of a parameter with which the scene is valid."""
    valid = []
    for value in values:
        with suppress(SceneError):
            scene.changed(**{name: value})
            valid.append(value)
    return valid


def reference(scene: Scene, keep: Collection[float]) -> Curves:
    """The Curves to compare with, with the states at the positions `keep`; raises NotConverged."""
    fine = refined(scene)
    for tolerance in TIGHTEST:
        fine = fine.changed(tolerance=max(tolerance, 2.0 * fine.attainable))
        curves = recorded(fine, load_path(fine, leave_out=ALL - {"translation"}), keep)
        if not curves.failure:
            return curves
    raise NotConverged(curves.failure)


def perform(
    scene: Scene,
    method: str | Callable[..., Any],
    keep: Collection[float] | None = None,
    longest: float = inf,
    repeats: int = 1,
) -> Curves:
    """The Curves of a scene by a method of `load_path`; of `repeats` runs the fastest; arguments as `recorded`."""
    again = (recorded(scene, load_path(scene, method), keep, longest) for _ in range(repeats))
    return min(again, key=lambda curves: curves.seconds)


def recorded(scene, path, keep=None, longest=inf) -> Curves:
    """The Curves of a path, with the states at the positions `keep` (None: all); stopped after `longest` s."""
    curves = Curves(scene)
    try:
        while not curves.stopped:
            start = thread_time()
            frame = next(path, None)
            curves.seconds += thread_time() - start
            if frame is None:
                break
            curves.evaluations += frame.evaluations
            curves.slips += frame.slips
            if frame.stage == "shear":
                curves.rows[position(frame)] = frame.F_bar, frame.L_bar, frame.A_bar
                if keep is None or position(frame) in keep:
                    curves.states[position(frame)] = frame
            if curves.seconds > longest:
                where = f"{frame.stage} increment {frame.index}"
                curves.stopped = True
                curves.failure = f"stopped after {longest:g} s at {where}; use a larger tolerance or step"
    except NotConverged as failure:
        curves.failure = str(failure)
    return curves


def compare(point: Point, curves: Curves, best: Curves, right: Curves) -> Point:
    """The outcome of a Point with these Curves: errors against the Curves `best`, branches against `right`."""
    F, L, A = on_branch(curves, best)
    work, slips = (curves.seconds, curves.evaluations), tuple(slip_errors(curves, best, right))
    return Point(point.sweep, point.series, point.value, *work, F, L, A, slips, curves.failure)


def on_branch(curves: Curves, best: Curves) -> list[float | None]:
    """Errors of F, L, A before the first slip of either, over the reference's largest value."""
    end = min([*best.shear_slips[:1], *curves.shear_slips[:1], curves.scene.u_x_max])
    both = [at for at in curves.rows if at in best.rows and at <= round(end, 9)]
    if not both:
        return [None] * len(QUANTITIES)
    scale = np.maximum(np.abs(list(best.rows.values())).max(axis=0), NOTHING)
    scale[:2] = np.maximum(scale[:2], SMALLEST * scale[:2].max())  # F and L share a unit
    errors = np.abs([np.subtract(curves.rows[at], best.rows[at]) for at in both]).max(axis=0)
    return (errors / scale).tolist()


def slip_errors(curves: Curves, best: Curves, right: Curves) -> list[SlipError]:
    """A SlipError for every slip of the reference."""
    largest, errors = max((abs(row[0]) for row in best.rows.values()), default=0.0) or 1.0, []
    for event, after in zip_longest(best.slips, best.slips[1:]):
        own = [other for other in curves.slips if other.stage == event.stage]
        nearest = min(own, key=lambda other: abs(other.load - event.load), default=None)
        position = None if nearest is None else abs(nearest.load - event.load)
        force = None if nearest is None else abs(nearest.F_bar - event.F_bar) / largest
        end = after.load if after and after.stage == event.stage else inf
        same = None if event.sensitive else same_branch(curves, right, event, end)
        errors.append(SlipError(event.stage, event.load, position, force, same))
    return errors


def same_branch(curves: Curves, right: Curves, event: SlipEvent, end: float) -> bool | None:
    """Whether both are in one state right after a slip of the reference, before the load `end`; None: unknown.

    An increment farther than the first beyond the slip: near the end of a branch a loose tolerance may delay it.
    """
    both = sorted(curves.states.keys() & right.states.keys())
    if event.stage == "approach":  # known at U_x = 0, after the last slip of the approach
        both = both[:1] if end == inf else []
    else:
        both = [at for at in both if event.load < at < end]
        both = [at for at in both if event.load + curves.scene.shear_at(1) < at][:1] or both[-1:]
    return same_state(curves.states[both[0]], right.states[both[0]]) if both else None


def same_state(a: Frame, b: Frame) -> bool:
    """Whether two Frames, at one load, are of one branch, by the nodes they share."""
    low, high = max(a.first, b.first), min(a.first + a.u.shape[1], b.first + b.u.shape[1])
    distance = np.abs(a.u[:, low - a.first : high - a.first] - b.u[:, low - b.first : high - b.first]).max()
    return bool(distance < SAME_BRANCH * min(a.scene.delta_n, a.scene.delta_t))
