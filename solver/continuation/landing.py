"""The equilibrium in which a slip lands, and whether that depends on details of the motion.

Where a node passes a barrier, and from flutter, the time step and the start of the motion may decide. There further
motions with others must agree; if they do not, the slip is `sensitive`.
"""

from functools import partial

import numpy as np

from .state import End, NotConverged
from .transient import BUDGET, DIVISORS, WANDERED, TooLong, Transient, Trial

USUAL = Trial()
LONGER = 3.0  # a repetition is given up that takes so many times the steps that it should
TWICE = Trial(0.5)  # where such a motion lands as the usual one does, finer ones do too, for less evaluations
HALF = Trial(2.0)  # over one barrier: half of the usual step
# Over several barriers. The first trial changes only the step: two trials with other starts were wrong together
FINE = Trial(4.0), Trial(8.0, 10.0, -1e-3)
# From flutter GFMD leaves a branch before its linear end, by a jolt of 0.03 to 0.3 units, and may land elsewhere. The
# oscillation before may take most of the motion. If it lasted for SATURATED steps, from which on a motion may count as
# restless, its start is forgotten, and the motion is repeated from its last state near the end. From shorter ones, some
# small cells landed alike where motions from the end do not
SATURATED = 4_000
FARTHER = Trial(nearer=0.2)
# Where all nodes are alike, waves must grow near the end of the branch. From the usual start, five times as far, a cell
# of tests/bench/landings.py fell before they had grown. From 4 and 20 times nearer it lands in the same state.
DISTURBED = Trial(nearer=5.0, kick=1e-3)


def motion_to_rest(problem, end, judge, damping, closed, undecided=False) -> End:
    """An End with the State `after` in which the motion from it comes to rest, and whether that is `sensitive`.

    The state's load is that of the End or, if the motion does not rest there, the next at which it does. damping: over
    critical; closed: as of `motion.Motion`; undecided: of the State before it. Raises NotConverged.
    """
    motion = partial(_moved, problem, end, judge=judge, damping=damping, closed=closed)
    state, stalled, steps, fall = motion(USUAL)
    slip = end._replace(after=state)
    if end.sensitive or _wandered(problem, end, slip.after):
        return slip._replace(sensitive=True)
    finer, agreeing = _finer(problem.sites(end.v, state.v), stalled)
    # A slip before might have landed elsewhere, so that no step leads to the one right state. Twice the usual one tells
    # whether this slip is sensitive as well
    if undecided:
        finer, agreeing = finer and (TWICE,), min(agreeing, 1)
    flutter, alike = end.kind == "flutter", problem.alike(end.v)
    if fall is not None and fall.steps > SATURATED and not alike:
        return slip._replace(sensitive=not _same(problem, state, _tried(motion, problem, end, TWICE, steps, fall)))
    starts = (FARTHER,) * flutter + (DISTURBED,) * alike
    may_change = not (starts or undecided)  # else one disagreement makes the slip sensitive
    for trial in starts:
        if not _same(problem, slip.after, _tried(motion, problem, end, trial, steps)):
            return slip._replace(sensitive=True)
    for trial in finer:
        if not agreeing:
            break
        state = _tried(motion, problem, end, trial, steps)
        if _same(problem, slip.after, state):
            agreeing -= 1
        elif not may_change:
            return slip._replace(sensitive=True)
        else:  # the finer motion is right, if the next one agrees with it
            slip, may_change = slip._replace(after=state or slip.after), False
    return slip._replace(sensitive=agreeing > 0)


def _finer(sites, stalled):
    """(trials with finer steps, how many of them must agree) for a slip by so many sites, on which it stalled.

    A node that moved by more than half a site has passed a barrier. If the motion stalled there, small errors decide
    whether it passes. A node that moved by more than 1.2 sites has passed several, and errors of its energy add up.
    """
    # nearly all first slips that go wrong at the usual step go beyond 1.2 sites (tests/bench/landings.py)
    if sites <= 0.5 or (sites <= 1.2 and not stalled):
        return (), 0
    if sites <= 1.2:
        return (HALF, *FINE), 1
    return FINE, 1 if sites < 5.0 else 2  # some slips beyond 5 sites need two


def _tried(motion, problem, end, trial, steps, fall=None):
    """The State in which a motion comes to rest; None where it does not, or where it wanders before.

    steps: of the usual motion. With finer steps it is given up beyond LONGER times as many of them.
    """
    try:
        state, *_ = motion(trial, most=int(LONGER * steps) if trial.finer > 1.0 else BUDGET, fall=fall)
    except NotConverged:
        return None
    return None if _wandered(problem, end, state) else state


def _wandered(problem, end, state):
    """Whether the load rose by more than WANDERED units before the surface came to rest.

    Then the motion does not determine the equilibrium, nor how far along its branch the surface comes.
    """
    return state.load > end.load + WANDERED * problem.unit


def _same(problem, state, other):
    """Whether two States are one equilibrium. Between their loads the branch may have moved it, as in `slipped`."""
    if other is None:
        return False
    rise = abs(other.load - state.load)
    # at another site, a node is a unit off
    return bool(np.abs(other.v - state.v).max() <= 0.05 * problem.unit + 2.0 * rise)


def _moved(problem, end, trial, most=BUDGET, **how):
    """(State at rest, whether the motion stalled, its steps, its `fall`), with the longest steps that lead there.

    most: steps of a motion, times its `finer`.
    """
    # with other steps a trial would be another one
    for finer in DIVISORS if trial is USUAL else DIVISORS[:1]:
        try:
            slower = trial._replace(finer=finer * trial.finer)
            moving = Transient(problem, end, slower, most=min(BUDGET, int(most * slower.finer)), **how)
            return *moving.to_rest(), moving.steps, moving.fall
        except TooLong as failure:
            last = failure
    raise last
