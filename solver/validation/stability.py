"""`python -m solver stability`: how the solver fares on stiff and extreme scenes, each rechecked in long double."""

import os
import warnings
from contextlib import suppress
from math import exp, isfinite
from time import perf_counter

import numpy as np

from ..continuation.state import NotConverged, PulledOff
from ..isolated import Lost, outcomes
from ..run.load_steps import load_steps_of
from ..run.loadpath import load_path
from ..scene import SceneError
from .atlas import CENTRE
from .extended import DROPPED, recheck
from .spectrum import growth

GOOD = ("converged", "refused", "gave up")  # what a scene may come to
BAD = ("wrong", "non-finite", "warning", "error", "crash", "hang")  # what it must not
LIMIT = 120.0  # s for one scene, after which it counts as hung
WORK = 2e7  # node evaluations, after which a run is cut short between increments: its frames so far are judged
SAMPLES = 8  # frames of a scene that are rechecked, besides those that slipped
SLIPS = 4
DENSE = 256  # nodes of the cell up to which the stability of frames is judged: half a second for each
RESTS = 3  # frames whose stability is looked at, besides those that slipped and the last
SIDEWAYS = ("shear", "back", "forth")  # stages in which a load may be held
UNSTABLE = 1e-3  # growth per unit of time of the motion from which on a frame is no rest; a branch ends at 0
SAME_TRACTION = 1e-9  # of the springs' size, beyond what a spring at the tangential edge of the window amounts to


def judge(case):
    """The outcome of one Case as a plain dict: `verdict`, `reason`, and what was measured on the way."""
    found = {"number": case.number, "kind": case.kind, "probed": list(case.probed), "set": case.line}
    start = perf_counter()
    try:
        with warnings.catch_warnings(), np.errstate(over="raise", invalid="raise", divide="raise"):
            warnings.simplefilter("error")
            verdict, reason = _judged(case, found)
    except (Warning, FloatingPointError) as error:
        verdict, reason = "warning", _where(error)
    except Exception as error:
        verdict, reason = "error", _where(error)
    return found | {"verdict": verdict, "reason": reason, "seconds": perf_counter() - start}


def _where(error):
    """Type, text and the innermost lines of the traceback."""
    places, frame = [], error.__traceback__
    while frame is not None:
        places.append(f"{os.path.basename(frame.tb_frame.f_code.co_filename)}:{frame.tb_lineno}")
        frame = frame.tb_next
    return f"{type(error).__name__}: {error} at {' > '.join(places[-4:])}"


def _judged(case, found):
    try:
        scene = case.scene()
    except SceneError as error:
        return "refused", str(error)
    if case.kind == "refused":
        return "wrong", "out of range, and yet accepted"
    found |= {
        "frames": 0,
        "evaluations": 0,
        "slips": 0,
        "asked": sum(step.increments + 1 for step in load_steps_of(scene)),
    }
    kept, failure, work, end = Sample(), None, 0, ""
    with suppress(StopIteration):
        frames = load_path(scene)
        while work < WORK:
            try:
                frame = next(frames)
            except PulledOff as error:  # what a soft machine does under tension: no failure of the solver
                end = str(error)
                break
            except NotConverged as error:
                failure = str(error)
                break
            if not _finite(frame):
                return "non-finite", f"{frame.stage} increment {frame.index}"
            if not frame.residual <= scene.tolerance:
                return "wrong", f"{frame.stage} increment {frame.index} yielded at residual {frame.residual:.3g} nm"
            work += frame.evaluations * frame.u.shape[1]
            found["frames"] += 1
            found["evaluations"] += frame.evaluations
            found["slips"] += len(frame.slips)
            if frame.T.any() or not kept:
                kept.see(frame)
    found["cut"] = work >= WORK
    wrong = _rechecked(scene, kept, found)
    if wrong:
        return "wrong", wrong
    return ("gave up", failure) if failure else ("converged", end)


def _finite(frame):
    numbers = frame.F_bar, frame.L_bar, frame.A_bar, frame.residual, frame.U_x, frame.delta
    return all(map(isfinite, numbers)) and np.isfinite(frame.u).all() and np.isfinite(frame.T).all()


class Sample:
    """Some of the frames seen, spread evenly over the run, the last one included; and the first ones after a slip."""

    def __init__(self):
        self.frames, self.slipped, self.last, self._stride, self._seen = [], [], None, 1, 0

    def __bool__(self):
        return self.last is not None

    def see(self, frame):
        """Take in the next frame; keeps at most 2 SAMPLES + SLIPS + 1 of them, for they may be large."""
        if self._seen % self._stride == 0:
            self.frames.append(frame)
        if len(self.frames) > 2 * SAMPLES:
            self.frames, self._stride = self.frames[::2], 2 * self._stride
        if frame.slip and len(self.slipped) < SLIPS:
            self.slipped.append(frame)
        self.last, self._seen = frame, self._seen + 1

    def __iter__(self):
        chosen = {(f.stage, f.index): f for f in [*self.frames, *self.slipped, self.last] if f is not None}
        return iter(chosen.values())


def _rechecked(scene, frames, found):
    """What is wrong with these frames, or None; notes the largest deviations in `found`."""
    found |= {"checked": 0, "residual": 0.0, "floor": 0.0, "traction": 0.0, "forces": 0.0, "window": 0.0}
    for frame in frames:
        second, place = recheck(scene, frame), f"{frame.stage} increment {frame.index}"
        found["checked"] += 1
        for name in ("floor", "traction", "forces", "window"):
            found[name] = max(found[name], getattr(second, name))
        found["residual"] = max(found["residual"], second.residual / scene.tolerance)
        if not second.residual <= scene.tolerance + second.floor:
            return (
                f"{place}: residual {second.residual:.3g} nm, tolerance {scene.tolerance:g}, reported"
                f" {frame.residual:.3g}, round-off {second.floor:.2g}"
            )
        if second.window > DROPPED:
            return f"{place}: a node {second.window:.3g} delta_n on the wrong side of the window"
        # a site just at the window's edge may be in for the one and out for the other, by round-off: exp(-window_t^2)
        if max(second.traction, second.forces) > SAME_TRACTION + 2.0 * exp(-(scene.window_t**2)):
            return f"{place}: traction off by {second.traction:.3g}, forces by {second.forces:.3g}"
    return _unstable(scene, frames, found)


def _unstable(scene, frames, found):
    """A frame that is no rest of the scene's motion, or None: of those that slipped, the last, and some others.

    Of all modes of the whole surface, real and complex; only where their dense eigenvalues are to be had. A frame that
    says itself that it may flutter is counted apart, and not wrong.
    """
    found |= {"growth": None, "spectra": 0, "unstable": 0, "said": 0}
    wrong, alike = None, scene.surface == "flat"
    if scene.nodes > DENSE and not alike:
        return None
    others = frames.frames[:: max(1, len(frames.frames) // RESTS)]
    for frame in {(f.stage, f.index): f for f in [*frames.slipped, *others, frames.last] if f is not None}.values():
        held = scene.hold == "load" and frame.stage in SIDEWAYS
        rate = growth(scene, frame, held)
        found["growth"] = rate if found["growth"] is None else max(rate, found["growth"])
        found["spectra"] += 1
        if rate > UNSTABLE and frame.may_flutter:
            found["said"] += 1
        elif rate > UNSTABLE:
            found["unstable"] += 1
            wrong = f"{frame.stage} increment {frame.index}: unstable, disturbances grow as exp({rate:.3g} t)"
    return wrong


def atlas(asked, workers=None, progress=lambda part: None, limit=LIMIT):
    """The outcome of every Case asked for, in order, from processes of their own; workers, limit: as of `outcomes`."""
    results = [None] * len(asked)
    for done, (k, found) in enumerate(outcomes(judge, asked, workers or os.cpu_count() or 1, limit), start=1):
        if isinstance(found, Lost):
            case = asked[k]
            found = {"number": case.number, "kind": case.kind, "probed": list(case.probed), "set": case.line} | {
                "verdict": found.kind,
                "reason": found.reason,
            }
        results[k] = found
        progress(done / len(asked))
    return results


def counts(results):
    """{verdict: scenes} over all verdicts."""
    return {verdict: sum(r["verdict"] == verdict for r in results) for verdict in (*GOOD, *BAD)}


def unstable(results):
    """(frames that are no rests, those that say so themselves, frames judged by the spectrum of the motion)."""
    return tuple(sum(r.get(name, 0) for r in results) for name in ("unstable", "said", "spectra"))


def by_region(results):
    """[(region, its outcomes)] for what was probed: every axis, and whatever else scenes differ in."""
    names = dict.fromkeys([*CENTRE, *(name for r in results for name in r["probed"])])
    found = [(name, [r for r in results if name in r["probed"]]) for name in names]
    return [(name, some) for name, some in found if some]
