"""Work against precision of one run: what it costs, how far it is from a reference, and whether its branches are right.

Errors on a branch are measured against `fast` at the smallest tolerance and a tenth of the step, without moving known
states on. Its increments contain those of every run compared with it, so that nothing is interpolated. Branches are
judged by `judge`, the paper's GFMD alone; so is the reference.
"""

from dataclasses import dataclass, field
from math import floor, isfinite
from time import thread_time

import numpy as np

from ..continuation.state import NotConverged
from ..run.loadpath import load_path
from ..run.shortcuts import ALL
from ..scene import SceneError
from .methods import frames

QUANTITIES = ("F", "L", "A")
REFINED = (10, 5, 2, 1)  # the reference's steps in one of the scene's, where the limits allow
TIGHTEST = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8)  # nm: tolerances tried for the reference, where round-off allows
SAME_BRANCH = 0.1  # of min(delta_n, delta_t): equilibria that differ by more are two; a node that slips moves farther
NOTHING = np.array([1e-30, 1e-30, 1e-6])  # of F_bar, L_bar, A_bar: their largest values count as no less
SMALLEST = 0.01  # of the larger of F and L: a force that stays below (L on the flat) is measured against that
ON_GRID = 1e-6  # of an increment, by which a displacement may miss it


@dataclass(frozen=True)
class Run:
    """One run to measure: `value` is that of the scene's parameter `sweep`."""

    sweep: str
    series: str
    value: float
    scene: object
    repeats: int = 1  # the least time of so many counts


@dataclass
class Curves:
    """What a run leaves to compare: a row per shear increment, its slips, the states asked for; seconds of one core."""

    scene: object
    rows: list = field(default_factory=list)  # [F_bar, L_bar, A_bar], row k at U_x = scene.shear_at(k)
    slips: list = field(default_factory=list)  # [(stage, SlipEvent)]
    states: dict = field(default_factory=dict)  # `place` in shear: (first node, u)
    seconds: float = 0.0
    evaluations: int = 0
    safe_damping: float = 0.0  # the largest of the frames
    failure: str | None = None
    stopped: bool = False  # for taking too long

    def take(self, frame, keep):
        """Add one Frame, its field too if `keep`."""
        self.evaluations += frame.evaluations
        self.safe_damping = max(self.safe_damping, frame.safe_damping)
        self.slips += [(frame.stage, event) for event in frame.slips]
        if frame.stage == "shear":
            self.rows.append((frame.F_bar, frame.L_bar, frame.A_bar))
            if keep:
                self.states[place(frame)] = (frame.first, frame.u)

    def shear_slips(self):
        """Loads (nm) of the slips in shear, in order."""
        return [event.load for stage, event in self.slips if stage == "shear"]


@dataclass(frozen=True)
class SlipError:
    """One slip of the reference and what a run made of it; None: not to be told (no slip, or no increment there)."""

    stage: str
    load: float  # nm, in the reference
    position: float | None  # nm, how far off the run's nearest slip is
    force: float | None  # error of F_bar there over the largest F_bar
    same_branch: bool | None  # whether both were in one state right after it, at the same load


@dataclass(frozen=True)
class Point:
    """A run in the diagram. F, L, A: largest error before the first slip, over the largest value of the quantity."""

    sweep: str
    series: str
    value: float
    seconds: float | None
    evaluations: int | None
    F: float | None = None
    L: float | None = None
    A: float | None = None
    slips: tuple = ()
    failure: str | None = None

    @property
    def branch_error(self):
        """The largest of the errors before the first slip."""
        known = [getattr(self, name) for name in QUANTITIES]
        return None if None in known else max(known)

    @property
    def branches(self):
        """(slips after which the branch was that of the reference, slips after which it could be told)."""
        told = [slip.same_branch for slip in self.slips if slip.same_branch is not None]
        return sum(told), len(told)

    def worst(self, name, stage="shear"):
        """The largest `position` or `force` error of the slips up to the first wrong branch."""
        found = []
        for slip in self.slips:
            if slip.stage == stage and getattr(slip, name) is not None:
                found.append(getattr(slip, name))
            if slip.same_branch is False:
                break
        return max(found, default=None)


def refined(scene):
    """The scene with a tenth of both steps, or the smallest part that the limits allow."""
    for name in ("du_x", "du_z"):
        for part in REFINED:
            try:
                scene = scene.changed(**{name: getattr(scene, name) / part})
                break
            except SceneError:
                continue
    return scene


def ratio(coarse, fine):
    """How many increments of `fine` make one of `coarse` in shear; None unless a whole number."""
    steps = coarse.du_x * coarse.delta_t / (fine.du_x * fine.delta_t)
    return round(steps) if steps > 0.5 and abs(steps - round(steps)) < ON_GRID else None


def place(frame):
    """U_x (nm) by which states of different runs are matched, without the round-off of increments."""
    return round(frame.U_x, 9)


def reference(scene, every, reach):
    """Generator of progress (0..1); returns Curves with the states to compare.

    These are kept in every `every`-th increment at U_x = 0 and up to `reach` nm beyond each slip.
    """
    for tolerance in TIGHTEST:
        try:
            curves = Curves(refined(scene).changed(tolerance=tolerance))
            yield from _reference(curves, every, reach)
            return curves
        except (NotConverged, SceneError) as failure:
            last = failure
    raise last


def _reference(curves, every, reach):
    scene, start = curves.scene, thread_time()
    total, last = scene.approach_increments + scene.shear_increments + 2, 0.0
    for done, frame in enumerate(load_path(scene, leave_out=ALL - {"translation"})):
        last = max([last, *(event.load for event in frame.slips)]) if frame.stage == "shear" else 0.0
        near = frame.stage == "shear" and frame.U_x <= last + reach
        curves.take(frame, near and frame.index % every == 0)
        yield done / total
    curves.seconds = thread_time() - start


def perform(run, known, longest):
    """Generator of progress (0..1); returns the Curves of a run, stopped after `longest` s, for `compare`.

    known: the Curves whose states it is going to be compared with.
    """
    best = None
    for repeat in range(run.repeats):
        curves = yield from _performed(run, known, longest, repeat)
        if best is None or curves.seconds < best.seconds:
            best = curves
        if curves.failure:
            return curves
    return best


def _performed(run, known, longest, repeat):
    scene, curves = run.scene, Curves(run.scene)
    total = (scene.approach_increments + scene.shear_increments + 2) * run.repeats
    path, done = frames(scene, run.series), repeat * (total // run.repeats)
    try:
        while True:
            start = thread_time()
            frame = next(path, None)
            curves.seconds += thread_time() - start
            if frame is None:
                break
            curves.take(frame, frame.stage == "shear" and place(frame) in known.states)
            if curves.seconds > longest:
                where = f"{frame.stage} increment {frame.index}"
                curves.stopped = True
                curves.failure = f"stopped after {longest:g} s at {where}; use a larger tolerance or step"
                break
            done += 1
            yield done / total
    except NotConverged as failure:
        curves.failure = str(failure)
    return curves


def compare(run, curves, known, judged):
    """The Point of a run with these Curves; its errors against the Curves `known`, its branches against `judged`."""
    return Point(
        run.sweep,
        run.series,
        run.value,
        curves.seconds,
        curves.evaluations,
        *on_branch(curves, known),
        tuple(slip_errors(curves, known, judged)),
        curves.failure,
    )


def on_branch(curves, known):
    """Errors of F, L, A before the first slip of either, over the reference's largest value."""
    end = min([*known.shear_slips()[:1], *curves.shear_slips()[:1], np.inf])
    rows, steps = len(curves.rows), ratio(curves.scene, known.scene)
    step = curves.scene.du_x * curves.scene.delta_t
    if isfinite(end):
        rows = min(rows, floor(end / step + ON_GRID) + 1)
    if rows == 0:
        return [None] * len(QUANTITIES)
    exact = np.array(known.rows)
    scale = np.maximum(np.abs(exact).max(axis=0), NOTHING)
    scale[:2] = np.maximum(scale[:2], SMALLEST * scale[:2].max())  # F and L share a unit
    errors = np.abs(np.array(curves.rows[:rows]) - exact[: rows * steps : steps][:rows]).max(axis=0)
    return [float(error) for error in errors / scale]


def slip_errors(curves, known, judged):
    """A SlipError for every slip of the reference."""
    largest = max((abs(row[0]) for row in known.rows), default=0.0) or 1.0
    for (stage, event), end in zip(known.slips, ends(known), strict=True):
        own = [other for where, other in curves.slips if where == stage]
        nearest = min(own, key=lambda other: abs(other.load - event.load), default=None)
        yield SlipError(
            stage,
            event.load,
            nearest and abs(nearest.load - event.load),
            nearest and abs(nearest.F_bar - event.F_bar) / largest,
            same_branch(curves, judged, stage, event.load, end),
        )


def ends(known):
    """For every slip of the reference the load, nm, of the next one in its stage; inf: there is none."""
    following = zip(known.slips, [*known.slips[1:], (None, None)], strict=False)
    return [event.load if stage == own else np.inf for (own, _), (stage, event) in following]


def same_branch(curves, judged, stage, load, end):
    """Whether both are in one state right after a slip of the reference, before `end`; None: not to be told.

    An increment farther than the first beyond the slip, for near the end of a branch a loose tolerance may delay it.
    """
    both = sorted(curves.states.keys() & judged.states.keys())
    if stage == "approach":  # told at U_x = 0, after the last slip of the approach
        both = both[:1] if end == np.inf else []
    else:
        step = curves.scene.du_x * curves.scene.delta_t
        both = [at for at in both if load < at < end]
        both = [at for at in both if load + step < at][:1] or both[-1:]
    unit = min(curves.scene.delta_n, curves.scene.delta_t)
    return _distance(curves.states[both[0]], judged.states[both[0]]) < SAME_BRANCH * unit if both else None


def _distance(one, other):
    """Largest difference, nm, of two states (first node, u) on the nodes they share."""
    (first, u), (start, v) = one, other
    low, high = max(first, start), min(first + u.shape[1], start + v.shape[1])
    return float(np.abs(u[:, low - first : high - first] - v[:, low - start : high - start]).max())
