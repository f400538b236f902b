"""The damped motion from the end of a branch to the next equilibrium, finished by Anderson steps.

A `Transient` starts just beyond the end of the branch. Once it has nearly died down, Anderson steps solve for the
equilibrium; `landing` decides whether that depends on the time step or the start.
"""

from dataclasses import dataclass
from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from .corrector import OPTIONS as CORRECTOR
from .corrector import Corrector, CorrectorOptions
from .motion import OPTIONS as MOTION
from .motion import MotionOptions, motion_of
from .state import NotConverged, Restless, State


@dataclass(frozen=True)
class SlipOptions:
    """How the motion of a slip is followed and ended; a "unit" is the problem's `unit`."""

    steps: int = 8  # time steps between two checks; 12 save 2 % of the evaluations, but lead to other equilibria
    start: float = 0.05  # units from an end, where the motion starts; from farther, soft layers come to rest elsewhere
    # units from the end of the branch within which the motion counts as starting: four times where it starts
    left: float = 0.2
    # factor of the usual steps while the motion starts slowly; 4 leads to other equilibria. With 3 a slip in a thousand
    # does, which a motion of finer steps shows, as it does without that factor
    slow: float = 3.0
    # divisors of the steps: the next one is tried where a motion diverged, as when surfaces clash. The first three also
    # serve a motion that never rests, because a soft layer may swing for ever at one step and at no other
    finer: tuple = (1, 2, 4, 16)
    # units between two checks: in the overdamped limit steps are halved where a state moves more, and doubled where it
    # moves less than a quarter of that, which a doubled step does not exceed, up to `crawl_longest` times the usual
    crawl: float = 0.08
    crawl_longest: float = 256.0
    # units of residual and swing below which Anderson steps begin; from 0.1 on they reach other equilibria than the
    # motion
    landing: float = 0.03
    # of that, the next one after steps that failed; 0.15 and 0.6 lead to the same equilibria, with up to 5 % fewer
    # evaluations (tests/bench/constants.py)
    later: float = 0.3
    near: float = 1e-4  # the same within `left`: below the residual at the start, about bend/2 times its square
    # periods of the slowest mode, over its decay in units of the critical one, after which a motion is restless: by
    # then the mode has decayed by exp(-16 pi). Without that factor, a strongly damped fall under a soft drive had no
    # time to come to rest
    patience: float = 8.0
    least: int = 4000  # steps of a restless motion, at least, half of what the slowest slip of the slider box takes
    # steps, the same in the overdamped limit, where surfaces come to rest more slowly; half and twice change no run of
    # tests/bench/constants.py
    least_creep: int = 40_000
    # part of the rise since the end of the branch by which each check raises the load of a restless motion; with ten
    # times as much the load rose 0.3 nm too far, because oscillations grow slowly at their onset
    raised: float = 1e-2
    raised_least: float = 1e-4  # units, the least such rise
    raised_most: float = 1e-3  # units, the largest; with more, surfaces slide on and on
    farthest: float = 5.0  # units by which the load may be raised
    # most steps of one motion: the slider box needs 8,000, but with 60,000 a twentieth of the atlas gives up, very soft
    # layers that detach
    budget: int = 250_000
    diverged: float = 1e9  # units of displacement, or stiffness over the closed one: far beyond any state
    motion: MotionOptions = MOTION
    corrector: CorrectorOptions = CORRECTOR


OPTIONS = SlipOptions()


class Trial(NamedTuple):
    """How a motion differs from the usual one."""

    finer: float = 1.0  # divisor of its time steps
    nearer: float = 1.0  # divisor of the distance from the end of the branch at which it starts
    kick: float = 0.0  # units, random displacement of the unknowns, which breaks symmetries


class TooLong(Restless):
    """The motion diverged, or did not come to rest; shorter steps may help."""


class Transient:
    """One motion to rest, with the steps and the start of a Trial; raises TooLong if shorter steps may help.

    Attributes: motion, load, v: the present state; ahead: the way since the last check; starting: whether it is
    still near the end of the branch.
    """

    def __init__(self, problem, end, trial, judge, damping, closed, options: SlipOptions = OPTIONS):
        self.problem, self.judge, self.damping, self.end, self.closed = problem, judge, damping, end, closed
        self.unit, self.mode, self.options = problem.unit, None, options
        self.finer, self._crawl = trial.finer, 1.0  # divisor of the usual steps; their factor without inertia
        self.away = options.start * self.unit * end.phi
        self.load, self.v = end.load, end.v + self.away / trial.nearer
        if trial.kick:
            self.v += trial.kick * self.unit * np.random.default_rng(1).normal(size=self.v.size)
        self.dynamics = problem.motion()
        y = self.dynamics.start(self.v, self.load)
        self.motion = motion_of(self.dynamics, y, self.load, damping, closed, options.motion)
        self.ahead, self._r = np.zeros(problem.size), np.empty(problem.size)
        self._worst: float | None = None
        self.landing, self.near = options.landing * self.unit, options.near * self.unit / trial.nearer**2
        self.starting, self.steps, self.elapsed = end.located, 0, 0.0

    def to_rest(self) -> State:
        """The State at rest."""
        while True:
            self.step()
            self.look()
            state = self.land()
            if state is not None:
                return state
            self.raise_load()
            self.check()

    def step(self) -> None:
        """Some time steps, adapted to the stiffness here and where the state is about to be."""
        dynamics, motion, options = self.dynamics, self.motion, self.options
        # surfaces that are about to clash stiffen
        stiffness = max(dynamics.interface(self.v), dynamics.interface(self.v + self.ahead))
        if not stiffness < options.diverged * self.closed:
            raise TooLong("the motion diverges")
        motion.soften(stiffness, self._pace() / self.finer)
        motion.advance(options.steps)
        self.steps, self.elapsed = self.steps + options.steps, self.elapsed + options.steps * motion.time

    def _pace(self):
        """The factor of the usual steps until the next check; without inertia, steps may adapt to the speed."""
        options = self.options
        if isfinite(self.damping):
            return options.slow if self.starting and self.finer == 1.0 else 1.0
        moved = np.abs(self.ahead).max() / self.unit
        if moved > options.crawl:
            self._crawl = max(0.5 * self._crawl, 1.0)
        elif 0.0 < moved < 0.25 * options.crawl:
            self._crawl = min(2.0 * self._crawl, options.crawl_longest)
        return self._crawl

    def look(self) -> None:
        """Update the state."""
        before, self.v = self.v, self.dynamics.unknowns(self.motion.y)
        if not np.abs(self.v).max() < self.options.diverged * self.unit:  # nan fails it too
            raise TooLong("the motion diverges")
        self.ahead, self._worst = self.v - before, None
        self.problem.hold(self.v, self.load)
        self.starting = self._near_end(self.v)

    @property
    def residual(self) -> float:
        """Residual of the present state, nm."""
        if self._worst is None:
            self._worst = self.problem.residual(self.v, self.load, self._r)
        return self._worst

    def land(self) -> State | None:
        """The State that Anderson steps reach from here; None if it is too early, or they fail."""
        if not self._nearly_at_rest(self.landing if not self.starting else self.near):
            return None
        state = self._rest_near()
        if state is None or self._returned(state.v):
            self.landing, self.near = self.options.later * self.landing, self.options.later * self.near
            return None
        return state

    def _near_end(self, v):
        """Whether v is still close to the end of the branch."""
        return self.end.located and bool(np.abs(v - self.end.v).max() < self.options.left * self.unit)

    def _returned(self, v):
        """Whether v is the end of the branch or lies before it: less than half-way to the start of the motion."""
        return self._near_end(v) and bool((v - self.end.v) @ self.away < 0.5 * (self.away @ self.away))

    def _nearly_at_rest(self, bound):
        """Whether velocities and residual are below a bound, nm; velocities first: they need no force evaluation."""
        swing = np.abs(self.dynamics.unknowns(self.motion.y + self.motion.swing()) - self.v).max()
        return swing < bound and self.residual < bound

    def _rest_near(self):
        """The State that Anderson steps lead to; None if they fail, go too far or reach an unstable state."""
        corrector = Corrector(self.problem, self.options.corrector)
        corrector.begin(State.at_rest(self.load, self.v))
        secants, v = corrector.secants(), self.v.copy()
        solved, farthest = corrector.solve(v, self.load, secants), self.options.corrector.longest * self.unit
        if solved is None or np.abs(v - self.v).max() > farthest:
            return None  # farther off they may reach other equilibria than the motion
        # while an oscillation goes on, attempts often lead to the same state
        self.mode = self.judge.rightmost(self.problem, v, self.mode, corrector.inverse)
        if not self.mode.rests:
            return None
        solved = {"secants": secants, "sharp": corrector.sharp, "mode": self.mode, "residual": corrector.worst}
        return State.at_rest(self.load, v, **solved)

    def raise_load(self) -> None:
        """Raise the load where the motion does not rest, or where the branch goes on a little farther."""
        returned = self.starting and self._nearly_at_rest(self.problem.tolerance)
        if not returned and not self._restless():
            return
        if not returned and self.finer < 4 and self.end.kind != "flutter":
            raise TooLong("the motion does not come to rest")
        share = self.options.raised * (self.load - self.end.load)
        self.load += min(max(self.options.raised_least * self.unit, share), self.options.raised_most * self.unit)
        self.landing = self.options.landing * self.unit
        self.motion.load = self.load

    def _restless(self):
        """Whether the motion has lasted so long that it may never rest."""
        if not isfinite(self.damping):
            return self.steps > self.options.least_creep
        slow = self.damping - sqrt(max(self.damping**2 - 1.0, 0.0))  # decay of the slowest mode over critical
        period = 4.0 * np.pi / (self.dynamics.critical * slow)
        # from an unstable state the surface falls as exp(growth t)
        patience = self.options.patience * (period + 1.0 / self.end.growth)
        return self.steps > self.options.least and self.elapsed > patience

    def check(self) -> None:
        """Raises Restless or NotConverged where it is time to give up."""
        if self.load > self.end.load + self.options.farthest * self.unit:
            raise Restless(f"the surface does not come to rest: it flutters, residual {self.residual:.2g} nm")
        if self.steps > self.options.budget:
            raise NotConverged(f"still moving, residual {self.residual:.2g} nm, after {self.options.budget} steps")
