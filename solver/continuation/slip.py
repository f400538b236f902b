"""From the end of a branch to the next rest: the damped motion, finished by Anderson steps."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from .corrector import Corrector
from .motion import motion_of
from .state import NotConverged, Restless, State


@dataclass(frozen=True)
class Limits:
    """Of a slip; a "unit" is the problem's `unit`, a "look" examines the state of the motion and adapts the steps."""

    check: int = 8  # steps between two looks
    left: float = 0.2  # units from the end of the branch, within which the motion counts as starting
    slow: float = 3.0  # times longer steps while it is starting, as it grows slowly then
    # divisors of the steps, each tried where the one before diverged, as when surfaces clash. A motion in whole steps
    # that does not rest is tried again as well: a soft layer may swing for ever at one step and at no other. Not from a
    # flutter, where it often swings until the load has gone on
    finer: tuple = (1, 2, 4, 16)
    crawl_least: float = 0.02  # units between two looks; in the overdamped limit steps double where a state moves less
    crawl_most: float = 0.08  # units between two looks; they are halved where it moves more
    crawl_longest: float = 256.0  # times as long as usual, at most
    # units of residual and swing below which Anderson steps look for the rest, 0.3 times as much each time they fail;
    landing: float = 0.03  # from 0.1 on they reach other rests than the motion
    short: float = 1e-5  # units, the same while the motion is starting
    shortest: float = 0.08  # units; a rest closer to the end of the branch than that does not count as one
    creeps: float = 0.5  # damping over critical, from which on a residual of `crept` landings will do at any swing
    crept: float = 0.1  # see `creeps`
    drawn: float = 0.3  # units, farthest that Anderson steps may lead
    landing_steps: int = 60  # Anderson steps, at most; 100 reached no more rests on 13 scenes of the slider box
    come_and_go: int = 10  # changes of a node at the edge of the window, after which it stays as it is
    patience: float = 8.0  # periods of the slowest mode, divided by a damping below one: longer motions are restless
    steps: int = 4000  # of a restless motion, at least
    creep_steps: int = 40_000  # the same in the overdamped limit
    # where a motion is restless, the load is raised in every look until it rests. Oscillations grow slowly where they
    # begin: raised ten times as fast, the load went 0.3 nm too far; by more than `raise_most`, surfaces slide on and on
    raise_share: float = 1e-2  # of the way that the load has gone since the end of the branch
    raise_least: float = 1e-4  # units
    raise_most: float = 1e-3  # units
    farthest: float = 5.0  # units by which the load may be raised
    # landings that fail in a row before a motion counts as one that never rests. A wave of E 10 and friction 2 rested
    # after 139, others of the slider box after 59, a punch pulled off after 271; where waves drift, thousands fail
    failures: int = 400
    budget: int = 300_000  # force evaluations of one motion
    diverged: float = 1e9  # units of displacement; or stiffness of the interaction over the closed one
    filmed: float = 0.01  # units between two states that a film takes


LIMITS = Limits()


class TooLong(Restless):
    """The motion diverged, or did not come to rest where it may in shorter steps."""


def motion_to_rest(problem, watch, damping, end, closed, film=None):
    """(problem, State) in which the motion from a LimitPoint comes to rest; raises NotConverged.

    The load is that of the LimitPoint or, if the motion does not rest there, the next at which it does. The problem is
    the one given, or one grown from it. damping: over critical; closed: as of `motion.Motion`. film: a list that takes
    (problem, v, active, load) of states on the way, from the end of the branch to the rest.
    """
    begun = len(film) if film is not None else 0
    for finer in LIMITS.finer:
        try:
            return _with_steps(finer, problem, watch, damping, end, closed, film)
        except TooLong as failure:
            last = failure
            if film is not None:
                del film[begun:]
    raise last


def _with_steps(finer, problem, watch, damping, end, closed, film):
    """`motion_to_rest` with the usual steps divided by `finer`; raises TooLong where these may be too long."""
    load, v, unit, end_v = end.load, end.v + end.away, problem.unit, end.v
    end_active = end.active
    if film is not None:
        film.append((problem, end_v, end_active, load))
    active = problem.active_of(v, load)
    dynamics = problem.motion()
    motion = motion_of(dynamics, dynamics.start(v, active, load), load, damping, closed)
    changes, r = np.zeros(active.size, int), np.empty(problem.size)
    landing, limit = LIMITS.landing * unit, problem.evaluations + LIMITS.budget
    looks = failures = 0
    short, elapsed, ahead = LIMITS.short * unit, 0.0, np.zeros(problem.size)  # ahead: the way since the last look
    patience, least_steps, crawl, modes = 0.0, LIMITS.creep_steps, 1.0, None
    if isfinite(damping):
        least_steps = LIMITS.steps
        patience = LIMITS.patience * 4.0 * np.pi / (dynamics.critical * min(1.0, damping))
    while True:
        starting = end.located and np.abs(v - end_v).max() < LIMITS.left * unit
        # here, and about where the state will be at the next look, as surfaces that are about to clash stiffen
        stiffness = max(dynamics.interface(v, active), dynamics.interface(v + ahead, active))
        if not stiffness < LIMITS.diverged * closed:
            raise TooLong("the motion diverges")
        pace = LIMITS.slow if starting else 1.0
        if not isfinite(damping):  # without inertia, steps may follow the speed
            crawl = pace = _crawl_pace(crawl, np.abs(ahead).max() / unit)
        motion.soften(stiffness, pace / finer)
        if film is None:
            motion.advance(active, LIMITS.check)
        else:
            _filmed(film, problem, motion, active, load)
        looks, elapsed, before = looks + 1, elapsed + LIMITS.check * motion.time, v
        v = dynamics.unknowns(motion.y)
        if not np.abs(v).max() < LIMITS.diverged * unit:  # nan fails it too
            raise TooLong("the motion diverges")
        ahead = v - before
        now = problem.active_of(v, load)
        changed = now != active
        if changed.any():
            changes += changed
            active = np.where(changes > LIMITS.come_and_go, active, now)
            while problem.crowded(v, active, load):
                _, end_v, end_active = problem.grown(end_v, end_active, load)
                problem, v, active = problem.grown(v, active, load)
                dynamics = motion.dynamics = problem.motion()
                changes, r, ahead = np.zeros(active.size, int), np.empty(problem.size), np.zeros(problem.size)
        worst = problem.residual(v, active, load, r)
        small = short if starting else landing
        if worst < small:
            calm = damping >= LIMITS.creeps and worst < LIMITS.crept * small
            if calm or np.abs(dynamics.displacement(motion.swing())).max() < small:
                state, modes = _landed(problem, watch, v, active, load, modes)
                if state is not None and not (end.located and np.abs(state.v - end_v).max() < LIMITS.shortest * unit):
                    if film is not None:
                        film.append((problem, state.v, state.active, load))
                    return problem, state
                failures += state is None
                short, landing = (0.3 * short, landing) if starting else (short, 0.3 * landing)
        returned = starting and worst <= problem.tolerance  # the branch goes on a little farther than thought
        restless = elapsed > patience and looks * LIMITS.check > least_steps
        if restless and finer == 1 and end.kind != "flutter":
            raise TooLong("the motion does not come to rest")
        if returned or restless:
            share = LIMITS.raise_share * (load - end.load)
            load += min(max(LIMITS.raise_least * unit, share), LIMITS.raise_most * unit)
            landing = LIMITS.landing * unit
            motion.drive(load)
        if load > end.load + LIMITS.farthest * unit or failures > LIMITS.failures:
            raise Restless(f"the surface does not come to rest: it flutters, residual {worst:.2g} nm")
        if problem.evaluations > limit:
            raise NotConverged(f"still moving, residual {worst:.2g} nm, after {LIMITS.budget} force evaluations")


def _filmed(film, problem, motion, active, load):
    """Make the steps between two looks; a state far enough from the film's last one is added to it."""
    for _ in range(LIMITS.check):
        motion.advance(active, 1)
        v, last = motion.dynamics.unknowns(motion.y), film[-1][1]
        if v.size != last.size or np.abs(v - last).max() > LIMITS.filmed * problem.unit:
            film.append((problem, v, active, load))


def _crawl_pace(pace, moved):
    """How many times longer than usual the next steps may be, if at `pace` the state moved so many units."""
    if moved == 0.0 or LIMITS.crawl_least <= moved <= LIMITS.crawl_most:
        return pace
    return min(2.0 * pace, LIMITS.crawl_longest) if moved < LIMITS.crawl_least else max(0.5 * pace, 1.0)


def _landed(problem, watch, v, active, load, modes):
    """(State that Anderson steps lead to from v, None if they fail, go too far or find no rest; the modes there).

    modes: of the landing before, or None: while an oscillation goes on, that often led to the same state.
    """
    corrector = Corrector(problem)
    corrector.begin(State.at_rest(load, v, active))
    secants, rest = corrector.secants(), v.copy()
    active = corrector.settle(rest, active, load, secants, LIMITS.landing_steps)
    if active is None or np.abs(rest - v).max() > LIMITS.drawn * problem.unit:
        return None, modes
    if modes is not None and (modes.v.size != v.size or np.abs(rest - modes.v).max() > LIMITS.drawn * problem.unit):
        modes = None
    stability = watch.sure(problem, rest, active, modes, smooth=corrector.inverse)
    if not stability.rests:
        return None, stability.modes
    state = State.at_rest(load, rest, active)
    state.secants, state.sharp, state.modes = secants, corrector.sharp, stability.modes
    return state, stability.modes
