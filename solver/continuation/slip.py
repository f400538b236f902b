"""From the end of a branch to the next rest: the damped motion, finished by Anderson steps."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from .corrector import Corrector
from .motion import motion_of
from .state import NotConverged, State


@dataclass(frozen=True)
class Limits:
    """Of a slip; lengths in units of the problem's `unit`.

    check: steps between two looks at where the motion has got. left: distance from the end of the branch from which on
    the slow start of the motion is over, for which its steps are `slow` times longer. crawl: least and most way between
    two looks at which steps of the overdamped limit stay as they are, and how much longer they may get. finer:
    divisions of the steps, each where the ones before diverged, as surfaces clashed; from a fold, whole steps that do
    not lead to rest are not believed either: a soft layer may swing on and on at one step, and at no other.
    shortest: slip; short: the landing, as follows, of one that ends before the surface has left.
    landing: swing and residual below which Anderson steps may finish, less each time they fail; from 0.1 on they reach
    other rests than the motion. From damping `creeps` on, a residual of `crept` times that is enough. drawn: how far
    these steps may lead; landing_steps: of them. come_and_go: changes of a node at the edge of the window, after which
    it stays as it is.
    patience: periods of the slowest mode (over damping below one), and at least `steps` steps, `creep_steps` in the
    overdamped limit, after which a motion counts as one that does not come to rest under this load; then the load goes
    on until it does, or for `farthest`: in every look by the share `raise_[1]` of the way that it has gone, between the
    other two; oscillations grow slowly where they begin to: raised ten times as fast, the load went 0.3 nm too far,
    and where it is raised faster than the last, the surface slides on and on. budget: force evaluations. diverged:
    displacement, or stiffness over the closed one. filmed: way between two states that a film takes.
    """

    check: int = 8
    left: float = 0.2
    shortest: float = 0.08
    short: float = 1e-5
    slow: float = 3.0
    crawl: tuple = (0.02, 0.08, 256.0)
    finer: tuple = (1, 2, 4, 16)
    creeps: float = 0.5
    crept: float = 0.1
    landing: float = 0.03
    drawn: float = 0.3
    landing_steps: int = 60
    come_and_go: int = 10
    patience: float = 8.0
    steps: int = 4000
    creep_steps: int = 40_000
    raise_: tuple = (1e-4, 1e-2, 1e-3)
    farthest: float = 5.0
    budget: int = 300_000
    diverged: float = 1e9
    filmed: float = 0.01


LIMITS = Limits()


class TooLong(NotConverged):
    """Steps of the motion were too long, or seem so."""


def motion_to_rest(problem, watch, damping, end, closed, film=None):
    """(problem, State) at which the motion from a LimitPoint comes to rest; raises NotConverged.

    At the load of the LimitPoint, or, if there the motion goes on for ever, at the next load at which it does not.
    damping: over critical; closed: stiffness of the interaction at its closed place. The problem grows where it must.
    film: a list that takes (problem, v, active, load) of states on the way, from the end of the branch to rest.
    """
    begun = len(film) if film is not None else 0
    for finer in LIMITS.finer:
        try:
            return _moved(problem, watch, damping, end, closed, finer, film)
        except TooLong as failure:
            last = failure
            if film is not None:
                del film[begun:]
    raise last


def _moved(problem, watch, damping, end, closed, finer, film=None):
    """`motion_to_rest` with the usual steps divided by `finer`; raises TooLong."""
    load, v, unit, end_v = end.load, end.v + end.away, problem.unit, end.v
    end_active = end.active
    if film is not None:
        film.append((problem, end_v, end_active, load))
    active = problem.active_of(v, load)
    dynamics = problem.motion()
    motion = motion_of(dynamics, dynamics.start(v, active, load), load, damping, closed)
    changes, r = np.zeros(active.size, int), np.empty(problem.size)
    landing, looks, limit = LIMITS.landing * unit, 0, problem.evaluations + LIMITS.budget
    short, elapsed, ahead = LIMITS.short * unit, 0.0, np.zeros(problem.size)
    patience, least, crawl, modes = 0.0, LIMITS.creep_steps, 1.0, None
    if isfinite(damping):
        least = LIMITS.steps
        patience = LIMITS.patience * 4.0 * np.pi / (dynamics.critical * min(1.0, damping))
    while True:
        near = end.located and np.abs(v - end_v).max() < LIMITS.left * unit
        # surfaces that are about to clash stiffen
        stiffness = max(dynamics.interface(v, active), dynamics.interface(v + ahead, active))
        if not stiffness < LIMITS.diverged * closed:
            raise TooLong("the motion diverges")
        slow = LIMITS.slow if near else 1.0
        if not isfinite(damping):  # without inertia, steps may follow the speed
            crawl = slow = _longer(crawl, np.abs(ahead).max() / unit)
        motion.soften(stiffness, slow / finer)
        if film is None:
            motion.advance(active, LIMITS.check)
        else:
            _filmed(film, problem, motion, active, load)
        looks, elapsed, before = looks + 1, elapsed + LIMITS.check * motion.time, v
        v = dynamics.unknowns(motion.y, load)
        if not np.abs(v).max() < LIMITS.diverged * unit:  # nan is not, either
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
        small = short if near else landing
        if worst < small:
            calm = damping >= LIMITS.creeps and worst < LIMITS.crept * small
            if calm or np.abs(dynamics.displacement(motion.swing())).max() < small:
                state, modes = _landed(problem, watch, v, active, load, modes)
                if state is not None and not (end.located and np.abs(state.v - end_v).max() < LIMITS.shortest * unit):
                    if film is not None:
                        film.append((problem, state.v, state.active, load))
                    return problem, state
                short, landing = (0.3 * short, landing) if near else (short, 0.3 * landing)
        returned = near and worst <= problem.tolerance  # the end of the branch lies a little farther
        restless = elapsed > patience and looks * LIMITS.check > least
        if restless and finer == 1 and end.kind == "fold":
            raise TooLong("the motion does not come to rest")
        if returned or restless:
            least, share, most = LIMITS.raise_
            load += min(max(least * unit, share * (load - end.load)), most * unit)
            landing = LIMITS.landing * unit
            motion.drive(load)
        if load > end.load + LIMITS.farthest * unit:
            raise NotConverged(f"the surface does not come to rest: it flutters, residual {worst:.2g} nm")
        if problem.evaluations > limit:
            raise NotConverged(f"still moving, residual {worst:.2g} nm, after {LIMITS.budget} force evaluations")


def _filmed(film, problem, motion, active, load):
    """The steps between two looks, with the states that are some way from the last in the film added to it."""
    for _ in range(LIMITS.check):
        motion.advance(active, 1)
        v, last = motion.dynamics.unknowns(motion.y, load), film[-1][1]
        if v.size != last.size or np.abs(v - last).max() > LIMITS.filmed * problem.unit:
            film.append((problem, v, active, load))


def _longer(slow, moved):
    """How many times longer the steps should be, which were `slow` times longer when the state moved so far."""
    if moved == 0.0 or LIMITS.crawl[0] <= moved <= LIMITS.crawl[1]:
        return slow
    return min(2.0 * slow, LIMITS.crawl[2]) if moved < LIMITS.crawl[0] else max(0.5 * slow, 1.0)


def _landed(problem, watch, v, active, load, modes):
    """(State by Anderson steps from v, None if they fail, lead away, or to no rest; modes of what they led to).

    modes: of what the landing before led to: while oscillations go on, often the same equilibrium, which is no rest.
    """
    corrector = Corrector(problem)
    corrector.begin(State.at_rest(load, v, active))
    secants, rest = corrector.secants(), v.copy()
    active = corrector.settle(rest, active, load, secants, LIMITS.landing_steps)
    if active is None or np.abs(rest - v).max() > LIMITS.drawn * problem.unit:
        return None, modes
    if modes is not None and (modes.v.size != v.size or np.abs(rest - modes.v).max() > LIMITS.drawn * problem.unit):
        modes = None
    stability = watch.sure(problem, rest, active, load, modes, smooth=corrector.inverse)
    if not stability.rests:
        return None, stability.modes
    state = State.at_rest(load, rest, active)
    state.secants, state.sharp, state.modes = secants, corrector.sharp, stability.modes
    return state, stability.modes
