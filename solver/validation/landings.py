"""The equilibrium that each slip reaches, by the paper's GFMD alone; the branches of all runs are compared with it.

Nothing but the damped motion in explicit steps, from equilibrium to equilibrium. An increment with a slip is halved
until it is shorter than SHORT. The transient then begins at rest just beyond the end of the branch; the remainder of a
long increment would set it swinging. Where half the time step leads elsewhere, the transient itself bifurcates, and
neither branch is right.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

from ..continuation.gfmd import Gfmd
from ..continuation.state import Increment
from ..scene import Scene
from .compare import Curves, SlipError, perform, same_state, slip_errors

SHORT = 2e-3  # of the problem's unit: the increment in which a slip begins
STEP = 0.5  # of delta_t and delta_n: the longest increment; longer than a site, it would hide slips
FACTORS = (5, 2, 1)  # increments of the scene in one of these runs
TOLERANCE = 1e-5  # nm: branches lie compare.SAME_BRANCH apart, ten thousand times as far


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
        return second._replace(slips=first.slips + second.slips)


class Landings(NamedTuple):
    """GFMD's run, without the states that half its time step does not reach, and the slips after which it does not."""

    curves: Curves
    changed: tuple[SlipError, ...]


def landings(scene: Scene, longest: float, finer: bool) -> Landings:
    """The Landings of a scene, at long increments, which `Halving` refines at slips.

    longest: s for the run. finer: make another run with half the time step, for twice as long.
    """
    for name in ("du_x", "du_z"):
        own = getattr(scene, name)
        scene = scene.changed(**{name: own * next(n for n in FACTORS if n == 1 or own * n <= STEP)})
    scene = scene.changed(tolerance=max(TOLERANCE, 2.0 * scene.attainable))
    curves = perform(scene, Halving, longest=longest)
    if not finer:
        return Landings(curves, ())
    half = perform(scene, partial(Halving, pace=0.5), curves.states, 2.0 * longest)
    changed = tuple(slip for slip in slip_errors(half, curves, curves) if slip.same_branch is False)
    states = {
        at: frame for at, frame in curves.states.items() if at not in half.states or same_state(frame, half.states[at])
    }
    seconds, failure = curves.seconds + half.seconds, curves.failure or half.failure
    return Landings(replace(curves, states=states, seconds=seconds, failure=failure), changed)
