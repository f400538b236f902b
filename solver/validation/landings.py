"""The equilibrium that each slip reaches, by the paper's GFMD alone; the branches of all runs are compared with it.

Nothing but the damped motion in explicit steps, from equilibrium to equilibrium. An increment with a slip is halved
until it is shorter than SHORT. The transient then begins at rest just beyond the end of the branch; the remainder of a
long increment would set it swinging. Where half the time step leads elsewhere, the transient itself bifurcates, and
neither branch is right.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..continuation.gfmd import Gfmd
from ..continuation.state import Increment
from ..scene import Scene
from .compare import Curves, Run, on_branch, perform, same_branch

SHORT = 2e-3  # of the problem's unit: the increment in which a slip begins
STEP = 0.5  # of delta_t and delta_n: the longest increment; longer than a site, it would hide slips
FACTORS = (5, 2, 1)  # increments of the scene in one of these runs


class Halving(Gfmd):
    """GFMD that halves increments in which the surface slips; pace: factor of its time step."""

    def __init__(self, problem, damping, closed, pace=1.0):
        super().__init__(problem, damping, closed)
        self.pace = pace

    def increment(self, state, target) -> Increment:
        """The Increment from `state` to load `target`, nm; raises NotConverged."""
        problem = self.problem
        done = super().increment(state, target)
        if not done.slips or target - state.load <= SHORT * problem.unit:
            return done
        self.problem = problem  # it may have grown
        first = self.increment(state, 0.5 * (state.load + target))
        second = self.increment(first.state, target)
        return replace(second, slips=first.slips + second.slips)


@dataclass(frozen=True)
class Landings:
    """GFMD's branches beside the reference's; slips as (stage, load, nm). Plain and picklable."""

    tolerance: float  # nm
    seconds: float
    finer: bool  # whether half the time step was tried as well
    failure: str | None  # why it did not come to the end
    differs: tuple  # slips after which the reference is on another branch
    changed: tuple  # slips after which GFMD is elsewhere with half its time step: no branch is right
    untold: tuple  # slips beyond its end, or with the next slip too near
    right: int  # number of slips through which the reference follows GFMD
    apart: float | None  # nm between slips of both in shear, at most; None: they differ in number, or are none
    error: float | None  # of F, L, A before the first slip


def scene_for(scene: Scene, tolerance: float) -> Scene:
    """The Scene of these runs: long increments, which `Halving` refines at slips."""
    for name in ("du_x", "du_z"):
        own = getattr(scene, name)
        scene = scene.changed(**{name: own * next(n for n in FACTORS if n == 1 or own * n <= STEP)})
    return scene.changed(tolerance=max(tolerance, 2.0 * scene.attainable))


def landings(scene: Scene, known: Curves, longest: float, finer: bool) -> tuple[Curves, Landings]:
    """(Curves with the right states, the Landings of the reference `known`) in the scene of `scene_for`.

    longest: s for one run. finer: make another run with half the time step, for twice as long.
    """
    curves = half = perform(Run("", Halving, 0.0, scene), known, longest)
    if finer:
        half = perform(Run("", partial(Halving, pace=0.5), 0.0, scene), known, 2.0 * longest)
    states, slips = dict(curves.states), {True: [], False: [], None: [], "changed": []}
    for event, end in zip(known.slips, known.following(), strict=True):
        same = same_branch(known, curves, event, end)
        if same_branch(curves, half, event, end) is False:
            same = "changed"
            low, high = (event.load, end) if event.stage == "shear" else (0.0, 0.0)
            states = {at: state for at, state in states.items() if not low <= at <= high}
        slips[same].append((event.stage, event.load))
    own, others, errors = known.shear_slips, curves.shear_slips, on_branch(curves, known)
    landed = Landings(
        tolerance=scene.tolerance,
        seconds=curves.seconds + finer * half.seconds,
        finer=finer,
        failure=curves.failure or half.failure,
        differs=tuple(slips[False]),
        changed=tuple(slips["changed"]),
        untold=tuple(slips[None]),
        right=len(slips[True]),
        apart=float(np.abs(np.subtract(own, others)).max()) if own and len(own) == len(others) else None,
        error=None if None in errors else max(errors),
    )
    return replace(curves, states=states), landed
