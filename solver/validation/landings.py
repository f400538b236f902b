"""Which equilibrium each slip reaches, by the paper's GFMD alone: what the branches of all runs are judged by.

Nothing but the damped motion in explicit steps, from rest to rest. An increment in which the surface slips is halved
until it is shorter than SHORT, so that the motion begins at rest just beyond the end of the branch, and not with the
swing that the rest of a long increment would set off. Where half the time step leads elsewhere, the motion itself
bifurcates, and nobody can tell which branch is right.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..continuation.gfmd import Gfmd
from .compare import Run, ends, on_branch, perform, same_branch

SHORT = 2e-3  # nm in units of the problem's: the increment in which a slip begins
STEP = 0.5  # delta: increments at most; from one site on, slips would pass for elastic displacement
FACTORS = (5, 2, 1)  # increments of the scene in one of the judge's
TOLERANCE = {False: 1e-6, True: 1e-5}  # nm, quick or not: branches lie SAME_BRANCH apart
LONGEST = {False: 40.0, True: 8.0}  # s for one judgement


class Halving(Gfmd):
    """GFMD that halves increments in which the surface slips."""

    def increment(self, state, target):
        problem = self.problem
        done = super().increment(state, target)
        if not done.slips or target - state.load <= SHORT * problem.unit:
            return done
        self.problem = problem  # it may have grown
        first = self.increment(state, 0.5 * (state.load + target))
        second = self.increment(first.state, target)
        return replace(second, slips=first.slips + second.slips)


class Finer(Halving):
    """The same with half the time step."""

    pace = 0.5


@dataclass(frozen=True)
class Judgement:
    """What GFMD says of the reference; slips as (stage, load). Plain and picklable."""

    tolerance: float  # nm
    seconds: float
    finer: bool  # whether half the time step was tried as well
    failure: str | None  # why it did not come to the end
    differs: tuple  # slips after which the reference is on another branch
    changed: tuple  # slips after which GFMD is elsewhere with half its time step: not judged
    untold: tuple  # slips beyond what it reached
    right: int  # how many slips the reference follows GFMD through
    apart: float | None  # nm between slips of both in shear, at most; None: they differ in number, or are none
    error: float | None  # of F, L, A before the first slip


def scene_for(scene, quick):
    """The Scene the judge runs: coarse increments, for it refines them itself where it matters."""
    tolerance = max(TOLERANCE[quick], 2.0 * scene.attainable)
    for name in ("du_x", "du_z"):
        own = getattr(scene, name)
        scene = scene.changed(**{name: own * next(n for n in FACTORS if n == 1 or own * n <= STEP)})
    return scene.changed(tolerance=tolerance)


def judge(scene, known, quick):
    """Generator of progress (0..1); returns (Curves that judge, Judgement of the reference `known`)."""
    short = scene_for(scene, quick)
    share = 1.0 if quick else 1.0 / 3.0
    curves = yield from _part(perform(Run("judge", Halving, 0.0, short), known, LONGEST[quick]), 0.0, share)
    finer = curves
    if not quick:
        finer = yield from _part(perform(Run("judge", Finer, 0.0, short), known, 2.0 * LONGEST[quick]), share, 1.0)
    states, told = dict(curves.states), {True: [], False: [], None: [], "changed": []}
    for (stage, event), end in zip(known.slips, ends(known), strict=True):
        same = same_branch(known, curves, stage, event.load, end)
        if same_branch(curves, finer, stage, event.load, end) is False:
            same = "changed"
            low, high = (event.load, end) if stage == "shear" else (0.0, 0.0)
            states = {at: state for at, state in states.items() if not low <= at <= high}
        told[same].append((stage, event.load))
    loads, others = known.shear_slips(), curves.shear_slips()
    errors = on_branch(curves, known)
    return replace(curves, states=states), Judgement(
        short.tolerance,
        curves.seconds + (0.0 if quick else finer.seconds),
        not quick,
        curves.failure or finer.failure,
        tuple(told[False]),
        tuple(told["changed"]),
        tuple(told[None]),
        len(told[True]),
        float(np.abs(np.subtract(loads, others)).max()) if loads and len(loads) == len(others) else None,
        None if None in errors else max(errors),
    )


def _part(work, start, end):
    """Pass on the progress of a generator as from start to end; returns what it returns."""
    try:
        while True:
            yield start + (end - start) * next(work)
    except StopIteration as last:
        return last.value
