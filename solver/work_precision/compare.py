"""Work against precision of one run: what it costs, and how far it is from a reference at the same displacements.

The reference is `fast` at the smallest tolerance and a tenth of the step, without moving known states on. Its
increments contain those of every run compared with it, so that nothing is interpolated.
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
    states: dict = field(default_factory=dict)  # shear increment: (first node, u)
    seconds: float = 0.0
    evaluations: int = 0
    failure: str | None = None
    stopped: bool = False  # for taking too long

    def take(self, frame, keep):
        """Add one Frame, its field too if `keep`."""
        self.evaluations += frame.evaluations
        self.slips += [(frame.stage, event) for event in frame.slips]
        if frame.stage == "shear":
            self.rows.append((frame.F_bar, frame.L_bar, frame.A_bar))
            if keep:
                self.states[frame.index] = (frame.first, frame.u)

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
    more_slips: int = 0  # of the run than of the reference, in shear
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


def after(load, step):
    """The increment right after a slip at that load (nm): one farther than the first beyond it, in steps in nm.

    One farther, because near the end of a branch a loose tolerance may delay a slip into the next increment.
    """
    return floor(load / step + ON_GRID) + 2


def reference(scene, ratios):
    """Generator of progress (0..1); returns Curves with the states after each slip for runs of those step ratios."""
    for tolerance in TIGHTEST:
        try:
            curves = Curves(refined(scene).changed(tolerance=tolerance))
            yield from _reference(curves, sorted(set(ratios)))
            return curves
        except (NotConverged, SceneError) as failure:
            last = failure
    raise last


def _reference(curves, ratios):
    scene = curves.scene
    step, total = scene.du_x * scene.delta_t, scene.approach_increments + scene.shear_increments + 2
    wanted, start = {0}, thread_time()
    lengths = [(n, step * n) for n in ratios]
    for done, frame in enumerate(load_path(scene, leave_out=ALL - {"translation"})):
        if frame.stage == "shear":
            for event in frame.slips:
                wanted |= {n * (after(event.load, length) - back) for n, length in lengths for back in (0, 1)}
        curves.take(frame, frame.stage == "shear" and frame.index in wanted)
        yield done / total
    curves.seconds = thread_time() - start


def perform(run, known, longest):
    """Generator of progress (0..1); returns the Curves of a run, stopped after `longest` s, for `compare`."""
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
    steps = ratio(scene, known.scene)
    total = (scene.approach_increments + scene.shear_increments + 2) * run.repeats
    path, done = frames(scene, run.series), repeat * (total // run.repeats)
    try:
        while True:
            start = thread_time()
            frame = next(path, None)
            curves.seconds += thread_time() - start
            if frame is None:
                break
            curves.take(frame, frame.stage == "shear" and frame.index * steps in known.states)
            if curves.seconds > longest:
                place = f"{frame.stage} increment {frame.index}"
                curves.stopped = True
                curves.failure = f"stopped after {longest:g} s at {place}; use a larger tolerance or step"
                break
            done += 1
            yield done / total
    except NotConverged as failure:
        curves.failure = str(failure)
    return curves


def compare(run, curves, known):
    """The Point of a run with these Curves against the reference `known`."""
    steps = ratio(run.scene, known.scene)
    return Point(
        run.sweep,
        run.series,
        run.value,
        curves.seconds,
        curves.evaluations,
        *_on_branch(curves, known, steps),
        tuple(_slip_errors(curves, known, steps)),
        max(0, len(curves.shear_slips()) - len(known.shear_slips())),
        curves.failure,
    )


def _on_branch(curves, known, steps):
    """Errors of F, L, A before the first slip of either, over the reference's largest value."""
    end = min([*known.shear_slips()[:1], *curves.shear_slips()[:1], np.inf])
    rows = len(curves.rows)
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


def _slip_errors(curves, known, steps):
    """A SlipError for every slip of the reference."""
    largest = max((abs(row[0]) for row in known.rows), default=0.0) or 1.0
    for k, (stage, event) in enumerate(known.slips):
        own = [other for where, other in curves.slips if where == stage]
        nearest = min(own, key=lambda other: abs(other.load - event.load), default=None)
        following = known.slips[k + 1] if k + 1 < len(known.slips) else None
        yield SlipError(
            stage,
            event.load,
            nearest and abs(nearest.load - event.load),
            nearest and abs(nearest.F_bar - event.F_bar) / largest,
            _same_branch(curves, known, steps, stage, event, following),
        )


def _same_branch(curves, known, steps, stage, event, following):
    """Whether run and reference are in one state right after a slip, before the following (stage, event) or None."""
    step = curves.scene.du_x * curves.scene.delta_t
    end = following[1].load if following and following[0] == stage else np.inf
    if stage == "approach":  # told at U_x = 0, after the last slip of the approach
        candidates = [0] if not isfinite(end) else []
    else:
        candidates = [k for k in (after(event.load, step), after(event.load, step) - 1) if k * step < end]
    for k in candidates:
        if k in curves.states and k * steps in known.states:
            unit = min(curves.scene.delta_n, curves.scene.delta_t)
            return _distance(curves.states[k], known.states[k * steps]) < SAME_BRANCH * unit
    return None


def _distance(one, other):
    """Largest difference, nm, of two states (first node, u) on the nodes they share."""
    (first, u), (start, v) = one, other
    low, high = max(first, start), min(first + u.shape[1], start + v.shape[1])
    return float(np.abs(u[:, low - first : high - first] - v[:, low - start : high - start]).max())
