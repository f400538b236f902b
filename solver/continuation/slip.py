"""From the end of a branch to the next rest: the damped motion, finished by Anderson steps.

A slip is a sequence of steps with names. `start` puts the surface just beyond the end of the branch; `step` moves it
for a while; `look` examines where it is; `land` looks for the rest with Anderson steps, once the motion has nearly
died down; `raise_load` goes on under a higher load where the motion does not rest; `check` gives up.
"""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from .corrector import LIMITS as CORRECTOR
from .corrector import Corrector
from .motion import motion_of
from .state import NotConverged, Restless, State


@dataclass(frozen=True)
class Limits:
    """Of a slip; a "unit" is the problem's `unit`."""

    steps: int = 8  # of the motion between two looks; 12 save 2 % of the evaluations, but lead to other rests
    # units from the end of the branch, within which the motion counts as starting, and a rest does not count as one
    left: float = 0.2
    slow: float = 3.0  # times longer steps while it is starting, as it grows slowly then; 4 lead to other rests
    # divisors of the steps, each tried where the one before diverged, as when surfaces clash. A motion that never rests
    # is tried twice again as well: a soft layer may swing for ever at one step and at no other. Not from a flutter,
    # where it often swings until the load has gone on
    finer: tuple = (1, 2, 4, 16)
    # units between two looks: in the overdamped limit steps are halved where a state moves more, doubled where it moves
    # less than a quarter of that, up to so many times as long as usual
    crawl: float = 0.08
    crawl_longest: float = 256.0
    # units of residual and swing below which Anderson steps look for the rest, 0.3 times as much each time they fail;
    landing: float = 0.03  # from 0.1 on they reach other rests than the motion
    # changes of a node at the edge of the window, after which it stays as it is, lest it swing on
    come_and_go: int = 10
    patience: float = 8.0  # periods of the slowest mode, divided by a damping below one: longer motions are restless
    least: int = 4000  # steps of a restless motion, at least; ten times as many in the overdamped limit
    # where a motion is restless, the load is raised in every look until it rests, by this part of the way that it has
    # gone since the end of the branch. Oscillations grow slowly where they begin: raised ten times as fast, the load
    # went 0.3 nm too far
    raised: float = 1e-2
    raised_least: float = 1e-4  # units
    raised_most: float = 1e-3  # units; by more, surfaces slide on and on
    farthest: float = 5.0  # units by which the load may be raised
    # steps of one motion: 8,000 are the most in the slider box, but with 60,000 a twentieth of the atlas gives up, very
    # soft layers that let go
    budget: int = 250_000
    diverged: float = 1e9  # units of displacement; or stiffness of the interaction over the closed one


LIMITS = Limits()


class TooLong(Restless):
    """The motion diverged, or did not come to rest where it may in shorter steps."""


def motion_to_rest(problem, judge, damping, end, closed, film=None):
    """(problem, State) in which the motion from a LimitPoint comes to rest; raises NotConverged.

    The load is that of the LimitPoint or, if the motion does not rest there, the next at which it does. The problem is
    the one given, or one grown from it. damping: over critical; closed: as of `motion.Motion`. film: a list that takes
    (problem, v, active, load) of states on the way, from the end of the branch to the rest.
    """
    begun = len(film) if film is not None else 0
    for finer in LIMITS.finer:
        try:
            return _Passage(problem, judge, damping, end, closed, film, finer).to_rest()
        except TooLong as failure:
            last = failure
            if film is not None:
                del film[begun:]
    raise last


class Pace:
    """Step control: how many times the usual steps are long, given how far (units) the state moved since last asked."""

    def __init__(self, finer, overdamped):
        self.finer, self.overdamped, self._crawl = finer, overdamped, 1.0

    def next(self, moved, starting):
        """The factor of the usual steps until the next look."""
        if not self.overdamped:
            return (LIMITS.slow if starting else 1.0) / self.finer
        if moved > LIMITS.crawl:  # without inertia, steps may follow the speed
            self._crawl = max(0.5 * self._crawl, 1.0)
        elif 0.0 < moved < 0.25 * LIMITS.crawl:
            self._crawl = min(2.0 * self._crawl, LIMITS.crawl_longest)
        return self._crawl / self.finer


class _Passage:
    """One attempt to come to rest, in steps of the usual length over `finer`; raises TooLong if these may be too long.

    Attributes: where the motion is: problem, dynamics, motion, load, v, active; what the last look found: residual
    `worst`, `ahead`, the way since the look before, and whether it is still `starting`.
    """

    def __init__(self, problem, judge, damping, end, closed, film, finer):
        self.judge, self.damping, self.end, self.closed, self.film = judge, damping, end, closed, film
        self.unit = problem.unit
        self.pace, self.mode = Pace(finer, not isfinite(damping)), None
        self.start(problem)

    def to_rest(self):
        """(problem, State) of the rest."""
        while True:
            self.step()
            self.look()
            state = self.land()
            if state is not None:
                return self.problem, state
            self.raise_load()
            self.check()

    def start(self, problem):
        """From rest, just beyond the end of the branch."""
        end = self.end
        self.load, self.v = end.load, end.v + end.away
        if self.film is not None:
            self.film.append((problem, end.v, end.active, end.load))
        self.active = problem.active(self.v, self.load)
        self.dynamics = problem.motion()
        y = self.dynamics.start(self.v, self.active, self.load)
        self.motion = motion_of(self.dynamics, y, self.load, self.damping, self.closed)
        self._of(problem)
        self.landing = LIMITS.landing * self.unit
        self.starting, self.steps, self.elapsed = end.located, 0, 0.0

    def _of(self, problem):
        """Room for what is known of each unknown."""
        self.problem, self.ahead, self._r = problem, np.zeros(problem.size), np.empty(problem.size)
        self._changes = np.zeros(self.active.size, int)

    def step(self):
        """Some steps of the motion, adapted to the interaction here, and about where the state will be then."""
        dynamics, motion = self.dynamics, self.motion
        # as surfaces that are about to clash stiffen
        stiffness = max(dynamics.interface(self.v, self.active), dynamics.interface(self.v + self.ahead, self.active))
        if not stiffness < LIMITS.diverged * self.closed:
            raise TooLong("the motion diverges")
        motion.soften(stiffness, self.pace.next(np.abs(self.ahead).max() / self.unit, self.starting))
        if self.film is None:
            motion.advance(self.active, LIMITS.steps)
        else:
            self._filmed()
        self.steps, self.elapsed = self.steps + LIMITS.steps, self.elapsed + LIMITS.steps * motion.time

    def _filmed(self):
        """The same, a step at a time; a state as far from the film's last one as a step may crawl is added to it."""
        least = LIMITS.crawl / LIMITS.steps * self.unit
        for _ in range(LIMITS.steps):
            self.motion.advance(self.active, 1)
            v, last = self.dynamics.unknowns(self.motion.y), self.film[-1][1]
            if v.size != last.size or np.abs(v - last).max() > least:
                self.film.append((self.problem, v, self.active, self.load))

    def look(self):
        """Where the motion is; nodes that have come within the window, or left it, and more unknowns if need be."""
        before, self.v = self.v, self.dynamics.unknowns(self.motion.y)
        if not np.abs(self.v).max() < LIMITS.diverged * self.unit:  # nan fails it too
            raise TooLong("the motion diverges")
        self.ahead = self.v - before
        now = self.problem.active(self.v, self.load)
        changed = now != self.active
        if changed.any():
            self._changes += changed
            self.active = np.where(self._changes > LIMITS.come_and_go, self.active, now)
            self._grow()
        self.worst = self.problem.residual(self.v, self.active, self.load, self._r)
        self.starting = self._near_end(self.v)

    def _grow(self):
        """More unknowns while some are needed."""
        while (grown := self.problem.grown(self.v, self.active, self.load)) is not None:
            _, v, active = self.problem.grown(self.end.v, self.end.active, self.end.load, True)
            self.end = replace(self.end, v=v, active=active)
            problem, self.v, self.active = grown
            self.dynamics = self.motion.dynamics = problem.motion()
            self.mode = None
            self._of(problem)

    def land(self):
        """The State in which Anderson steps come to rest from here; None if it is too early, or they fail."""
        if self.starting or not self.worst < self.landing or not self._swing() < self.landing:
            return None
        state = self._rest_near()
        if state is None or self._near_end(state.v):
            self.landing *= 0.3
            return None
        if self.film is not None:
            self.film.append((self.problem, state.v, state.active, self.load))
        return state

    def _near_end(self, v):
        """Whether v is not yet another state than the end of the branch."""
        return self.end.located and bool(np.abs(v - self.end.v).max() < LIMITS.left * self.unit)

    def _swing(self):
        """How far the velocities would carry an unknown, nm."""
        return np.abs(self.dynamics.unknowns(self.motion.y + self.motion.swing()) - self.v).max()

    def _rest_near(self):
        """The State that Anderson steps lead to; None if they fail, go too far or find no rest."""
        corrector = Corrector(self.problem)
        corrector.begin(State.at_rest(self.load, self.v, self.active))
        secants, v = corrector.secants(), self.v.copy()
        active = corrector.settle(v, self.active, self.load, secants)
        if active is None or np.abs(v - self.v).max() > CORRECTOR.longest * self.unit:
            return None  # that far they may lead to other rests than the motion
        # while an oscillation goes on, landings often lead to the same state
        self.mode = self.judge.rightmost(self.problem, v, active, self.mode, corrector.inverse)
        if not (self.mode.rests or self.mode.hidden):
            return None
        known = {"secants": secants, "sharp": corrector.sharp, "mode": self.mode, "residual": corrector.worst}
        return State.at_rest(self.load, v, active, **known)

    def raise_load(self):
        """Go on under a higher load where the motion does not rest, or where the branch goes on a little farther."""
        returned = self.starting and self.worst <= self.problem.tolerance
        if not returned and not self._restless():
            return
        if not returned and self.pace.finer < 4 and self.end.kind != "flutter":
            raise TooLong("the motion does not come to rest")
        share = LIMITS.raised * (self.load - self.end.load)
        self.load += min(max(LIMITS.raised_least * self.unit, share), LIMITS.raised_most * self.unit)
        self.landing = LIMITS.landing * self.unit
        self.motion.load = self.load

    def _restless(self):
        """Whether the motion has gone on for so long that it may never rest."""
        if not isfinite(self.damping):
            return self.steps > 10 * LIMITS.least
        period = 4.0 * np.pi / (self.dynamics.critical * min(1.0, self.damping))
        return self.steps > LIMITS.least and self.elapsed > LIMITS.patience * period

    def check(self):
        """Raises Restless or NotConverged where going on makes no sense."""
        if self.load > self.end.load + LIMITS.farthest * self.unit:
            raise Restless(f"the surface does not come to rest: it flutters, residual {self.worst:.2g} nm")
        if self.steps > LIMITS.budget:
            raise NotConverged(f"still moving, residual {self.worst:.2g} nm, after {LIMITS.budget} steps")
