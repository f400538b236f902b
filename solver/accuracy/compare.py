"""Work against precision of one run: its cost, and its distance from a reference.

The reference is `fast` at the smallest tolerance and a tenth of the increment, without repeating states by lattice
periods. Runs are compared at the loads that both have: nothing is interpolated.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from math import inf
from time import thread_time
from typing import Any

import numpy as np

from ..continuation.state import NotConverged
from ..run.frame import SlipEvent
from ..run.loadpath import load_path
from ..scene import Scene, SceneError

Method = str | Callable[..., Any]  # as of `load_path`
CURVES = ("F", "L", "A")
NOTHING = np.array([1e-30, 1e-30, 1e-6])  # of F_bar, L_bar, A_bar: the least scale of an error, where all is zero


@dataclass
class Curves:
    """What a comparison needs of a run; seconds of one core."""

    scene: Scene
    rows: dict[float, tuple[float, ...]] = field(default_factory=dict)  # U_x: (F_bar, L_bar, A_bar) along the shear
    slips: list[SlipEvent] = field(default_factory=list)
    seconds: float = 0.0
    evaluations: int = 0
    failure: str | None = None
    stopped: bool = False  # for taking too long

    @property
    def shear_slips(self) -> list[SlipEvent]:
        """The slips in shear, in order."""
        return [event for event in self.slips if event.stage == "shear"]


@dataclass(frozen=True)
class SlipError:
    """A slip in shear of the reference, at `load` (nm), and its error in a run; None: the run has no slip.

    position: nm, distance of the run's nearest slip. force: error of F_bar there over the largest F_bar.
    """

    load: float
    position: float | None
    force: float | None


@dataclass(frozen=True)
class Point:
    """A run in the diagram: the value of the scene's parameter `sweep`, the name of a method, and the outcome.

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
        errors = [getattr(self, name) for name in CURVES]
        return None if None in errors else max(errors)

    def worst(self, name: str) -> float | None:
        """The largest `position` or `force` error of the slips."""
        return max((value for slip in self.slips if (value := getattr(slip, name)) is not None), default=None)


def refined(scene: Scene) -> Scene:
    """The scene with a tenth of both increments, or the smallest part in range."""
    for name in ("du_x", "du_z"):
        parts = [getattr(scene, name) / divisor for divisor in (10, 5, 2, 1)]
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


def reference(scene: Scene) -> Curves:
    """The Curves to compare with; raises NotConverged."""
    fine = refined(scene)
    # nm, where round-off allows
    for tolerance in (1e-12, 1e-11, 1e-10, 1e-9, 1e-8):
        fine = fine.changed(tolerance=max(tolerance, 2.0 * fine.attainable))
        curves = recorded(fine, load_path(fine, replay=False))
        if not curves.failure:
            return curves
    raise NotConverged(str(curves.failure))


def perform(scene: Scene, method: Method, longest: float = inf, repeats: int = 1) -> Curves:
    """The Curves of a scene by a method of `load_path`; of `repeats` runs the fastest; longest: as of `recorded`."""
    again = (recorded(scene, load_path(scene, method), longest) for _ in range(repeats))
    return min(again, key=lambda curves: curves.seconds)


def recorded(scene: Scene, path, longest: float = inf) -> Curves:
    """The Curves of a path, stopped after `longest` s."""
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
            if frame.stage == "shear":  # rounded: loads of different runs differ by the round-off of increments
                curves.rows[round(frame.U_x, 9)] = frame.F_bar, frame.L_bar, frame.A_bar
            if curves.seconds > longest:
                where = f"{frame.stage} increment {frame.index}"
                curves.stopped = True
                curves.failure = f"stopped after {longest:g} s at {where}; use a larger tolerance or step"
    except NotConverged as failure:
        curves.failure = str(failure)
    return curves


def compare(point: Point, curves: Curves, best: Curves) -> Point:
    """The outcome of a Point with these Curves: its work, and its errors against the Curves `best`."""
    F, L, A = on_branch(curves, best)
    work, slips = (curves.seconds, curves.evaluations), tuple(slip_errors(curves, best))
    return Point(point.sweep, point.series, point.value, *work, F, L, A, slips, curves.failure)


def on_branch(curves: Curves, best: Curves) -> list[float | None]:
    """Errors of F, L, A before the first slip of either, over the reference's largest value."""
    first = [event.load for event in (*best.shear_slips[:1], *curves.shear_slips[:1])]
    end = min([*first, curves.scene.u_x_max])
    both = [at for at in curves.rows if at in best.rows and at <= round(end, 9)]
    if not both:
        return [None] * len(CURVES)
    scale = np.maximum(np.abs(list(best.rows.values())).max(axis=0), NOTHING)
    # F and L share a unit. The error of a force below 1 % of the other, as L on the flat, is compared with that 1 %
    scale[:2] = np.maximum(scale[:2], 0.01 * scale[:2].max())
    errors = np.abs([np.subtract(curves.rows[at], best.rows[at]) for at in both]).max(axis=0)
    return (errors / scale).tolist()


def slip_errors(curves: Curves, best: Curves) -> list[SlipError]:
    """A SlipError for every slip in shear of the reference, up to the first one whose landing is `sensitive`."""
    largest, errors = max((abs(row[0]) for row in best.rows.values()), default=0.0) or 1.0, []
    for event in best.shear_slips:
        nearest = min(curves.shear_slips, key=lambda other: abs(other.load - event.load), default=None)
        position = None if nearest is None else abs(nearest.load - event.load)
        force = None if nearest is None else abs(nearest.F_bar - event.F_bar) / largest
        errors.append(SlipError(event.load, position, force))
        if event.sensitive:
            break
    return errors
