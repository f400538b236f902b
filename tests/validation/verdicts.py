"""The verdict on each stiff or extreme scene, its frames rechecked in long double."""

import os
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from math import exp, isfinite
from time import perf_counter
from traceback import extract_tb
from typing import NamedTuple

import numpy as np
from atlas import Case
from helpers import outcomes
from recheck import Recheck, recheck
from spectrum import growth

from app.service.caller import Lost
from solver.continuation.state import NotConverged, PulledOff
from solver.run.frame import Frame
from solver.run.load_steps import load_steps_of
from solver.run.loadpath import until
from solver.scene import Scene, SceneError

GOOD = ("converged", "refused", "gave up")  # acceptable verdicts on a scene
BAD = ("wrong", "non-finite", "warning", "error", "crash", "hang")
ANSWER = 60.0  # s for one scene, after which its run ends with that reason
# s for one scene, on the clock, after which it counts as hung: far above ANSWER, which is processor time, and the
# checks after it, also beside other work; WORK takes a second of force evaluations
LIMIT = 300.0
WORK = 2e7  # node evaluations, at 20 to 40 ns each, after which a run is cut short between increments and checked
SAMPLES = 8  # frames of a scene that are rechecked, besides those that slipped: enough to see every stage of a run
SLIPS = 4  # frames with slips that are rechecked: more slips of a run repeat these
MEMORY = 1e9  # bytes of the frames that are kept: 16,384 nodes and a fine du_z made 17 GB
DENSE = 256  # nodes of the cell up to which the stability of frames is checked: half a second for each
SPECTRA = 3  # frames whose stability is checked, besides those that slipped and the last
SIDEWAYS = ("shear", "back", "forth")  # stages in which a load may be held
UNSTABLE = 1e-3  # growth per unit of time of the transient, above which a frame is unstable; a branch ends at 0
SAME_TRACTION = 1e-9  # of the springs' size, besides one spring at the tangential edge of the window


class Verdict(NamedTuple):
    """verdict: of GOOD or BAD. reason: a message for people, "" if there is none."""

    verdict: str
    reason: str = ""


def sampled(frames: Sequence[Frame], most: int) -> list[Frame]:
    """Some `most` frames in contact, spread evenly; the first one, the last one, and the first few with slips."""
    touching = [frame for frame in frames if frame.T.any()]
    even = touching[:: max(1, len(touching) // most)]
    slipped = [frame for frame in frames if frame.slip][:SLIPS]
    return list({id(frame): frame for frame in [*frames[:1], *even, *slipped, *frames[-1:]]}.values())


def assess(case: Case) -> dict:
    """The outcome of one Case as plain data: `verdict`, `reason`, and the numbers measured on the way."""
    start = perf_counter()
    try:
        with warnings.catch_warnings(), np.errstate(over="raise", invalid="raise", divide="raise"):
            warnings.simplefilter("error")
            verdict, numbers = _assessed(case)
    except (Warning, FloatingPointError) as error:
        verdict, numbers = Verdict("warning", _traced(error)), {}
    except Exception as error:
        verdict, numbers = Verdict("error", _traced(error)), {}
    return _described(case) | numbers | verdict._asdict() | {"seconds": perf_counter() - start}


def _described(case):
    return {"number": case.number, "probed": list(case.probed), "set": case.line}


def _traced(error):
    """Type, text and the innermost lines of the traceback."""
    lines = [f"{os.path.basename(frame.filename)}:{frame.lineno}" for frame in extract_tb(error.__traceback__)[-4:]]
    return f"{type(error).__name__}: {error} at {' > '.join(lines)}"


def _assessed(case):
    """(Verdict, numbers) of a Case."""
    try:
        scene = case.scene()
    except SceneError as error:
        return Verdict("refused", str(error)), {}
    verdict, frames, counts = run(scene)
    numbers = dict(counts) | {"asked": sum(step.increments + 1 for step in load_steps_of(scene))}
    for check in (rechecked, stable):
        if verdict.verdict in BAD:
            break
        wrong, measured = check(scene, frames)
        numbers |= measured
        verdict = wrong or verdict
    return verdict, numbers


def run(scene: Scene) -> tuple[Verdict, list[Frame], Counter[str]]:
    """(the Verdict on a run by its frames alone, the frames, numbers of them, their evaluations and slips).

    Of frames that take more than MEMORY every second one without a slip goes, again and again.
    """
    frames: list[Frame] = []
    counts, work = Counter(frames=0, evaluations=0, slips=0), 0
    try:
        for frame, _ in until(scene, limit=ANSWER):
            if wrong := _wrong(scene, frame):
                return wrong, frames, counts
            frames.append(frame)
            counts.update(frames=1, evaluations=frame.evaluations, slips=len(frame.slips))
            if len(frames) * (frame.u.nbytes + frame.T.nbytes) > MEMORY:
                frames = [each for k, each in enumerate(frames) if k % 2 == 0 or each.slip]
            work += frame.evaluations * frame.u.shape[1]
            if work > WORK:
                break
    except PulledOff as end:  # a soft machine under tension: no failure of the solver
        return Verdict("converged", str(end)), frames, counts
    except NotConverged as failure:
        return Verdict("gave up", str(failure)), frames, counts
    return Verdict("converged"), frames, counts


def _wrong(scene, frame):
    """The Verdict on a frame that is not finite or not within the tolerance, or None."""
    numbers = frame.F_bar, frame.L_bar, frame.A_bar, frame.residual, frame.U_x, frame.delta
    if not (all(map(isfinite, numbers)) and np.isfinite(frame.u).all() and np.isfinite(frame.T).all()):
        return Verdict("non-finite", f"{frame.stage} increment {frame.index}")
    if not frame.residual <= scene.tolerance:
        return Verdict("wrong", f"{frame.stage} increment {frame.index} returned at residual {frame.residual:.3g} nm")
    return None


def rechecked(scene: Scene, frames: Sequence[Frame]) -> tuple[Verdict | None, dict]:
    """(what is wrong with a sample of the frames by `recheck`, the largest deviations)."""
    largest = dict.fromkeys(("checked", "residual", "floor", "traction", "forces"), 0.0) | {"checked": 0}
    for frame in sampled(frames, SAMPLES):
        second = recheck(scene, frame)
        largest |= {name: max(largest[name], getattr(second, name)) for name in ("floor", "traction", "forces")}
        largest["residual"] = max(largest["residual"], second.residual / scene.tolerance)
        largest["checked"] += 1
        if wrong := _deviation(scene, frame, second):
            return Verdict("wrong", f"{frame.stage} increment {frame.index}: {wrong}"), largest
    return None, largest


def _deviation(scene, frame, second: Recheck):
    """The deviation of a frame that no round-off explains, as text, or None."""
    if not second.residual <= scene.tolerance + second.floor:
        return (
            f"residual {second.residual:.3g} nm, tolerance {scene.tolerance:g}, reported {frame.residual:.3g},"
            f" round-off {second.floor:.2g}"
        )
    # round-off decides whether a site at the window's edge is in: exp(-window_t^2)
    if max(second.traction, second.forces) > SAME_TRACTION + 2.0 * exp(-(scene.window_t**2)):
        return f"traction off by {second.traction:.3g}, forces by {second.forces:.3g}"
    return None


def stable(scene: Scene, frames: Sequence[Frame]) -> tuple[Verdict | None, dict]:
    """(which of a sample of frames is unstable, the largest growth and the counts), by the whole surface's spectrum.

    Only where dense eigenvalues are cheap. A frame that reports possible flutter counts as `cautioned`, not as wrong.
    """
    rates, counts, wrong = [], {"spectra": 0, "unstable": 0, "cautioned": 0}, None
    judged = sampled(frames, SPECTRA) if scene.nodes <= DENSE or scene.surface == "flat" else []
    for frame in judged:
        held = scene.hold == "load" and frame.stage in SIDEWAYS
        rates.append(growth(scene, frame, held))
        if rates[-1] > UNSTABLE and frame.may_flutter:
            counts["cautioned"] += 1
        elif rates[-1] > UNSTABLE:
            counts["unstable"] += 1
            text = f"{frame.stage} increment {frame.index}: unstable, disturbances grow as exp({rates[-1]:.3g} t)"
            wrong = Verdict("wrong", text)
    return wrong, counts | {"spectra": len(judged), "growth": max(rates, default=None)}


def atlas(
    asked: list[Case],
    workers: int | str | None = None,
    progress: Callable[[float], None] = lambda part: None,
    limit: float = LIMIT,
) -> list[dict]:
    """The outcome of every Case, in order, from processes of their own; workers, limit: as of `helpers.outcomes`."""
    results: list[dict] = [{}] * len(asked)
    for done, (k, outcome) in enumerate(outcomes(assess, asked, workers, limit), start=1):
        lost = isinstance(outcome, Lost)
        results[k] = _described(asked[k]) | Verdict(outcome.kind, outcome.reason)._asdict() if lost else outcome
        progress(done / len(asked))
    return results
