"""The damped motion from the end of a branch to the next equilibrium, finished by Anderson steps.

The motion starts just beyond the end of the branch. Once it has nearly died down, Anderson steps solve for the
equilibrium. Where it does not come to rest, the load rises slowly. `landing` decides whether the equilibrium depends on
the time step or on the start.
"""

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from .corrector import LONGEST, Corrector
from .motion import Creep, Motion
from .state import NotConverged, Outcome, Restless, State

# A "unit" is the problem's `unit`.
STEPS = 8  # time steps between two checks; half as many again lead to other equilibria
DEPARTURE = 0.05  # units from an end, where the motion starts; from farther, soft layers come to rest elsewhere
# factor of the usual steps while the motion starts and moves less than a quarter of CRAWL between two checks; without
# that limit a few slips ended in other equilibria
SLOW = 3.0
# divisors of the steps: the next one is tried where a motion diverged, as when surfaces clash. The first three also
# serve a motion that never rests, because a soft layer may swing for ever at one step and at no other
DIVISORS = (1, 2, 4, 16)
# units between two checks. In the overdamped limit, steps are halved if a state moves more than CRAWL, and doubled (up
# to 256 times the usual) if it moves less than a quarter of it
CRAWL = 0.08
# units of residual and swing below which Anderson steps begin; from 0.1 on they reach other equilibria than the
# motion
LANDING = 0.03
# Used in place of LANDING while the motion starts. There the residual is small anyway: about half the curvature
# times the distance squared
NEAR = 1e-4
# most steps of one motion. Very soft layers that detach need most (tests/validation/stability.py)
BUDGET = 250_000
# factor by which the load's rise since the end of the branch grows before Anderson steps that failed are tried again.
# Tried at each rise, they led some motions to equilibria that the motion passes
FARTHER = 1.3
# units from both ends of the motion: where it slows down and speeds up again farther from them, it has stalled, as
# at a saddle that it just passes, or where it just turns back. Oscillations about the ends stay below
STALLED = 0.3
# factor of the distance from the end of a branch. Near the border of stick-slip the surface creeps away from a fold for
# longer than a motion takes that never rests; while it gets farther, it is not restless. Without inertia that took more
# than BUDGET steps
FARTHER_BY = 1.01
STALLS = 50  # most states kept for that; so many mean that it has stalled
# units from the end of a branch, which an oscillation after flutter soon reaches, whatever its start. From 0.6 on the
# motion is decided: repeated from there, a rough surface landed alike where motions from the end do not
LEAVING = 0.3
# units from the end of a branch, which no oscillation after flutter reaches. From there on the load stays. Where it
# rose on, the surface came to rest up to 0.2 units later, and its slip counted as sensitive
LEFT = 0.6
WANDERED = 0.2  # units of rise of the load beyond which a motion does not determine the equilibrium
DIVERGED = 1e9  # units of displacement, or stiffness over the closed one: far beyond any state


class Trial(NamedTuple):
    """How a motion differs from the usual one."""

    finer: float = 1.0  # divisor of its time steps
    nearer: float = 1.0  # divisor of the distance from the end of the branch at which it starts
    kick: float = 0.0  # units, standard deviation of a random displacement of all unknowns, which breaks symmetries


class Fall(NamedTuple):
    """Where a motion leaves the end of a branch after an oscillation: a Motion as it was, the load, and the state.

    steps: those of the oscillation.
    """

    motion: Motion
    load: float  # nm
    v: np.ndarray  # (size,)
    steps: int


class TooLong(Restless):
    """The motion diverged, or did not come to rest; shorter steps may help."""


class Transient:
    """One motion to rest, with the steps and the start of a Trial.

    Attributes: load, v: the present state; fall: after a flutter, where the motion left its end; ahead: the change
    since the last check; starting: whether it is still near the end of the branch; pace: factor of the usual steps;
    sharper: factor of the bounds below which Anderson steps are tried.
    """

    def __init__(self, problem, end, trial, judge, damping, closed, most=BUDGET, fall=None):
        """fall: of an earlier motion, which is repeated from there with the steps of the Trial."""
        self.most, self.fall, self.repeats = most, fall, fall is not None
        self.problem, self.judge, self.damping, self.end = problem, judge, damping, end
        self.unit, self.trial, self.mode, self.sharper = problem.unit, trial, None, 1.0
        self.away = DEPARTURE * self.unit * end.phi
        self.load, self.v = end.load, end.v + self.away / trial.nearer
        if trial.kick:
            self.v += trial.kick * self.unit * np.random.default_rng(1).normal(size=self.v.size)
        y = problem.motion().start(self.v, self.load)
        self.motion = (Motion if isfinite(damping) else Creep)(problem.motion(), y, self.load, damping, closed)
        self.pace = SLOW if isfinite(damping) and trial.finer == 1.0 else 1.0
        self.ahead, self.starting, self.steps, self.elapsed = np.zeros(problem.size), end.located, 0, 0.0
        self._left, self._since, self._farthest = False, (0, 0.0), 0.0
        if fall is not None:
            self.motion, self.load, self.v = fall.motion.copy(), fall.load, fall.v.copy()
            self.pace, self.starting = 1.0, False
        self._tried = 0.0  # nm, rise of the load since the end of the branch at which Anderson steps were last tried
        self._speeds, self._stalls = (0.0, 0.0), list[np.ndarray]()  # nm per time, at the last two checks

    def to_rest(self) -> tuple[State, bool]:
        """The State at rest, and whether the motion stalled on the way, close to a saddle.

        Raises TooLong where shorter steps may help, another NotConverged where not.
        """
        while True:
            self._advance()
            near = NEAR / self.trial.nearer**2
            bound = self.sharper * self.unit * (near if self.starting else LANDING)
            swung = self.motion.dynamics.unknowns(self.motion.y + self.motion.swing())
            unrest = float(np.abs(swung - self.v).max())
            if unrest < bound:  # only then the residual is worth a force evaluation
                unrest = max(unrest, self._residual())
            if unrest < bound:
                state = self._rest_near()
                if state is not None:
                    far = STALLED * self.unit
                    stalled = any(np.abs(v - state.v).max() > far for v in self._stalls)
                    return state, stalled or len(self._stalls) == STALLS
                self.sharper *= 0.3
            returned = self.starting and unrest < self.problem.tolerance
            if returned or self._restless():
                self._raise_load(returned)

    def _advance(self):
        """Make some time steps, adapted to the stiffness here and where the state is about to be."""
        motion, dynamics = self.motion, self.motion.dynamics
        # surfaces that are about to clash stiffen
        stiffness = max(dynamics.interface(self.v), dynamics.interface(self.v + self.ahead))
        if not stiffness < DIVERGED * motion.closed:
            raise TooLong("the motion diverges")
        if self.steps > self.most:
            still = f"still moving, residual {self._residual():.2g} nm, after {self.most} steps"
            raise NotConverged(still, Outcome.RESTLESS)  # it may be slow, or never come to rest
        self._set_pace()
        motion.soften(stiffness, self.pace / self.trial.finer)
        motion.advance(STEPS)
        self.steps, self.elapsed = self.steps + STEPS, self.elapsed + STEPS * motion.time
        before, self.v = self.v, dynamics.unknowns(motion.y)
        if not np.abs(self.v).max() < DIVERGED * self.unit:  # nan fails it too
            raise TooLong("the motion diverges")
        self.ahead = self.v - before
        self._note_stall(before, np.abs(self.ahead).max() / (STEPS * motion.time))
        self.problem.hold(self.v, self.load)
        self.starting = self._near_end(self.v) and not self.repeats
        if self.end.kind == "flutter" and not self._left:
            self._note_fall()
        elif self.starting and (away := np.abs(self.v - self.end.v).max()) > FARTHER_BY * self._farthest:
            self._farthest, self._since = away, (self.steps, self.elapsed)

    def _note_fall(self):
        """Keep the present state if it is still near the end of the branch, which moves about as far as the load.

        Once it has left, the load stays for as long as a surface may take to come to rest.
        """
        away = np.abs(self.v - self.end.v).max() - (self.load - self.end.load)
        if away > LEFT * self.unit:
            self._left, self._since = True, (self.steps, self.elapsed)
        elif away < LEAVING * self.unit and not self.repeats:
            self.fall = Fall(self.motion.copy(), self.load, self.v, self.steps)

    def _note_stall(self, before, speed):
        """Keep the state before the last check if the motion was slower there than before and after."""
        last, self._speeds = self._speeds, (self._speeds[1], speed)
        far = np.abs(before - self.end.v).max() > STALLED * self.unit
        if last[0] > last[1] < speed and far and len(self._stalls) < STALLS:
            self._stalls.append(before)

    def _set_pace(self):
        """Set the factor of the usual steps until the next check; without inertia, they may adapt to the speed."""
        moved = np.abs(self.ahead).max() / self.unit
        slowly = moved < 0.25 * CRAWL
        if isfinite(self.damping):
            if not self.starting or not (slowly or self.end.kind == "flutter"):
                self.pace = 1.0  # for good: changes of the steps add energy
        elif moved > CRAWL:
            self.pace = max(0.5 * self.pace, 1.0)
        elif slowly and self.steps:
            self.pace = min(2.0 * self.pace, 256.0)

    def _residual(self):
        return self.problem.residual(self.v, self.load, np.empty(self.v.size))

    def _near_end(self, v):
        """Whether v is still close to the end of the branch: within four times the distance of the start."""
        return self.end.located and bool(np.abs(v - self.end.v).max() < 4.0 * DEPARTURE * self.unit)

    def _rest_near(self):
        """The State that Anderson steps lead to; None if they fail, go too far, back or to an unstable state."""
        corrector = Corrector(self.problem)
        corrector.begin(State.at_rest(self.load, self.v))
        secants = corrector.secants()
        solution = corrector.solve(self.v, self.load, secants)
        if solution is None or np.abs(solution.v - self.v).max() > LONGEST * self.unit:
            return None  # farther off they may reach other equilibria than the motion
        # while an oscillation goes on, attempts often lead to the same state
        self.mode = self.judge.rightmost(self.problem, solution.v, self.mode)
        # it went back if it is less than half-way from the end of the branch to the start of the motion
        way, away = solution.v - self.end.v, self.away
        if not self.mode.rests or (self._near_end(solution.v) and way @ away < 0.5 * (away @ away)):
            return None
        solved = {"secants": secants, "sharp": corrector.sharp, "mode": self.mode, "residual": solution.residual}
        return State.at_rest(self.load, solution.v, **solved)

    def _restless(self):
        """Whether the motion has lasted so long that it may never rest.

        The slowest slips of the slider box take longer than 4,000 steps. In the overdamped limit surfaces come to rest
        more slowly.
        """
        if not isfinite(self.damping):
            return self.steps > 40_000
        slow = self.damping - sqrt(max(self.damping**2 - 1.0, 0.0))  # decay of the slowest mode over critical
        period = 4.0 * np.pi / (self.motion.dynamics.critical * slow)
        steps, elapsed = self.steps - self._since[0], self.elapsed - self._since[1]
        # after eight periods the mode has decayed by exp(-16 pi); from an unstable state the surface falls as
        # exp(growth t)
        return steps > 4_000 and elapsed > 8.0 * (period + 1.0 / self.end.growth)

    def _raise_load(self, returned):
        """Raise the load if the motion does not come to rest, or if it `returned` to the branch it left.

        From flutter, motions with finer steps raise it at the same rate. Raises TooLong or Restless if that does not
        help.
        """
        if not returned and self.trial.finer < 4 and self.end.kind != "flutter":
            raise TooLong("the motion does not come to rest")
        # each check of the usual steps raises the load by 2e-3 of the rise so far. At the onset oscillations grow
        # slowly: with five times as much, motions with finer steps lost a surface that plain GFMD brings to rest within
        # 0.005 nm of load. With more than 1e-3 units in a check, surfaces slide on and on
        share = min(max(1e-4 * self.unit, 2e-3 * (self.load - self.end.load)), 1e-3 * self.unit)
        self.load += share / self.trial.finer if self.end.kind == "flutter" else share
        if self.load > self.end.load + 5.0 * self.unit:
            how = "it flutters" if self.end.kind == "flutter" else "it moves on while the load rises"
            raise Restless(f"the surface does not come to rest: {how}, residual {self._residual():.2g} nm")
        rise = self.load - self.end.load
        if self.repeats and rise > WANDERED * self.unit:
            raise NotConverged("the load rises too far for the motion to agree with another one", Outcome.RESTLESS)
        if self.sharper == 1.0 or rise > FARTHER * self._tried:
            self.sharper, self._tried = 1.0, rise
        self.motion.load = self.load
