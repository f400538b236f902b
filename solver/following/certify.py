"""The certificate of a skeleton: what an exact run would find is checked, in place of computed again.

The run's fold, states and landings are known, if not quite exactly. So every state is solved to the scene's tolerance,
every fold located, the stability judged along each branch, every landing repeated by the motion, and the approach
walked in long steps, which shows a jump that following has forgotten.
"""

from dataclasses import dataclass, field, replace
from math import isfinite
from typing import NamedTuple

import numpy as np

from ..continuation.branch import SEARCH
from ..continuation.corrector import Corrector
from ..continuation.fold import fold_near
from ..continuation.landing import motion_to_rest
from ..continuation.rest import Judge
from ..continuation.state import End, NotConverged, Point, State
from ..continuation.trace import Branch, Trace
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..mechanics.surface import closed_stiffness
from ..run.load_steps import sideways, vertical
from ..run.loadpath import far_of
from ..scene import PARAMETERS
from ..text import counted
from ..threads import computation
from .approach import begun, latest, rested, undeformed, walk
from .moved import NotFollowed, Solver
from .refinement import refined
from .skeleton import Held, Skeleton, skeleton_in

# force evaluations, seven times those of the default: one landing at a saddle took ten exact runs. In the overdamped
# limit surfaces come to rest far more slowly
LIMIT, OVERDAMPED = 20_000, 300_000
FOLD = 1e-4  # nm, of a load: what followed runs promise
SAME = 0.01  # units of the problem: the end of the approach, and the first state of the shear
NEAR = 0.03  # units: a followed state from the one solved from it. Right ones lie within 1e-4, those of a ratio 2 % off
# mostly beyond; a state that is not is handed on as solved, and is right
ALIKE = 0.05  # units: two landings that are one; at another site a node is a unit off
BEYOND = 1e-5  # nm: where a slip lands, the load of a followed end has that error
BETWEEN = 1e-3  # of the largest force of the approach: error of forces between its states
NOT_OF_THE_APPROACH = {"delta_bar", "u_x_max", "du_x", "du_z", "hold"}


class Finding(NamedTuple):
    """What does not hold: at a load (nm, of the stage "approach" or "shear"), and by how much (nm), if that is known.

    what: "jump", "held load", "state", "unstable", "fold", "landing", "period", "end" or "limit".
    """

    what: str
    stage: str
    load: float
    off: float = np.nan
    why: str = ""

    def __repr__(self) -> str:
        place = f"{'U_x' if self.stage == 'shear' else 'delta'} = {self.load:.6g} nm"
        off = f", {self.off:.2g} nm off" * bool(np.isfinite(self.off))
        return f"{self.what} at {place}{off}{f': {self.why}' if self.why else ''}"


@dataclass(frozen=True, eq=False, repr=False)
class Certificate:
    """Whether a Skeleton is the run of its scene: found is what does not hold; nothing where it `holds`.

    skeleton: with the states, folds and landings that were computed, so that it is exact, and with `sensitive` slips;
    the one given, where something was found. states, folds, landings: how many were checked, at the cost of so many
    force `evaluations`. approach: its Branches over delta (nm), from which its frames are interpolated, and by which a
    scene of another depth is certified for less.

    Example: `certify(follow(skeleton_of(Scene()), Scene(E=72.0))).holds`
    """

    skeleton: Skeleton
    found: tuple[Finding, ...]
    states: int
    folds: int
    landings: int
    evaluations: int
    approach: tuple[Branch, ...] = field(default=(), repr=False)

    @property
    def holds(self) -> bool:
        """Whether nothing was found."""
        return not self.found

    def __repr__(self) -> str:
        numbers = counted(self.states, "state"), counted(self.folds, "fold"), counted(self.landings, "landing")
        said = "nothing found" if self.holds else f"found {'; '.join(map(repr, self.found))}"
        return f"Certificate: {', '.join(numbers)} checked in {self.evaluations} force evaluations, {said}"


class _TooLong(Exception):
    """More force evaluations than the limit; no NotConverged, which a motion that is repeated may raise."""


@computation
def certify(skeleton: Skeleton, limit: int | None = None, known: Certificate | None = None) -> Certificate:
    """Checks that a skeleton is the run of its scene, for a part of the cost of that run.

    Parameters: skeleton: as of `follow` or `skeleton_of`; limit: most force evaluations (default: LIMIT, at infinite
    damping OVERDAMPED); known: the Certificate of a scene that differs in its depth or shear alone, whose approach
    serves; one of another scene is not used.
    Returns a Certificate. Its `found` names what does not hold, or that the limit was reached: compute the run then.
    Raises TypeError for anything but a Skeleton.

    Example: `certify(follow(skeleton_of(Scene()), Scene(E=72.0))).skeleton.slips`
    """
    skeleton = skeleton_in(skeleton)
    if not isinstance(known, Certificate | None):
        raise TypeError(f"known = {type(known).__name__}: allowed: a Certificate; use certify(skeleton)")
    if limit is None:
        limit = LIMIT if isfinite(skeleton.scene.damping) else OVERDAMPED
    check, exact = _Check(skeleton, limit), None
    try:
        v = check.approach(known if _serves(known, skeleton.scene) else None)
        exact = None if check.found else check.shear(v)
    except _TooLong:
        check.note("limit", check.stage, check.load, why=f"more than {limit} force evaluations")
    except NotConverged as failure:
        check.note("landing", check.stage, check.load, why=str(failure))
    evaluations, (states, folds, landings) = check.contact.evaluations, check.counts
    if exact is not None:
        skeleton = replace(exact, evaluations=skeleton.evaluations + evaluations)
    found, walked = tuple(check.found), tuple(check.walked)
    return Certificate(skeleton, found, states, folds, landings, evaluations, walked)


def _serves(known, scene):
    """Whether the approach of a Certificate is that of a scene, to another depth."""
    if known is None or not known.holds:
        return False
    other, same = known.skeleton.scene, PARAMETERS.keys() - NOT_OF_THE_APPROACH
    return other.measured == scene.measured and all(getattr(other, name) == getattr(scene, name) for name in same)


class _Check:
    """Checks one Skeleton.

    Attributes: found; counts, [states, folds, landings]; walked: Branches of the approach; stage and load, nm: place.
    """

    def __init__(self, skeleton, limit):
        scene = skeleton.scene
        self.skeleton, self.scene, self.contact = skeleton, scene, Contact(scene, skeleton.first, skeleton.nodes)
        self.judge, self.closed = Judge(scene.damping, far_of(scene)), closed_stiffness(scene)
        self.found, self.counts, self.walked = list[Finding](), [0, 0, 0], list[Branch]()
        self.jumps, self.residual = list[End](), 0.0
        self.stage, self.load = "approach", -scene.delta_0
        self.undecided = any(jump.sensitive for jump in skeleton.trace.jumps)

        def observe(*_):
            if self.contact.evaluations > limit:
                raise _TooLong

        self.contact.observe = observe

    def note(self, what, stage, load, off=np.nan, why="") -> None:
        """Add a Finding."""
        self.found.append(Finding(what, stage, float(load), float(off), why))

    def lands(self, problem, end) -> End:
        """The End with the State in which the surface comes to rest; counts a landing."""
        self.counts[2] += 1
        slip = motion_to_rest(problem, end, self.judge, self.scene.damping, self.closed, self.undecided)
        self.undecided |= slip.sensitive
        return slip

    # the approach

    def approach(self, known) -> np.ndarray:
        """The unknowns (2 m,) at its end, from a `known` Certificate's states on, if there are any."""
        skeleton, scene, problem = self.skeleton, self.scene, Equilibrium(self.contact, vertical(1.0))
        stored = begun(known.approach, scene.delta, problem.size) if known else []
        state = latest(stored[-1]) if stored else undeformed(problem, -scene.delta_0)
        self.walked = stored or [Branch((Point(*state[:2]),))]
        expected = [jump for jump in skeleton.trace.jumps if jump.load > state.load]
        self.jumps = [jump for jump in skeleton.trace.jumps if jump.load <= state.load]
        for reached in walk(problem, self.judge, self.closed, state, scene.delta, [*expected]):
            self.load = reached.load
            if isinstance(reached, End) and not self._jumped(reached, expected):
                return state.v
            state = rested(reached)
            self._walked(state, reached)
            self.counts[0] += 1
        if expected:
            self.note("jump", "approach", expected[0].load, why="there is none")
        wanted = skeleton.unknowns(0.0)[0] if skeleton.held is None else skeleton.held.v
        off = np.abs(state.v - wanted[: problem.size]).max()
        if off > SAME * problem.unit:
            self.note("end", "approach", scene.delta, off)
        self.walked = [self._fine(problem, branch, k) for k, branch in enumerate(self.walked, 1)]
        return state.v

    def _fine(self, problem, branch, number):
        """A Branch of the approach with as many states as frames between them need, or as it is."""
        try:
            solver = Solver(problem, self.scene.damping)
            return refined(self.scene, self.skeleton.first, solver, branch, number, BETWEEN)
        except NotFollowed:
            return branch

    def _walked(self, state, reached):
        """Add the State after what a walk has `reached`."""
        if isinstance(reached, End):
            self.walked[-1] = self.walked[-1].ended(reached)
            self.walked.append(Branch((Point(*state[:2]),)))
        else:
            self.walked[-1] = self.walked[-1].added(Point(*state[:2]))

    def _jumped(self, end, expected):
        """Whether a jump is the next one `expected`; of a Skeleton whose jumps are lost, any is."""
        self.counts[1] += 1
        self.counts[2] += 1
        self.jumps.append(end._replace(after=None))
        if self.skeleton.lost:
            return True
        if not expected:
            self.note("jump", "approach", end.load, why="it was forgotten")
            return False
        jump = expected.pop(0)
        if end.kind != "fold" or abs(end.load - jump.load) > FOLD:
            self.note("jump", "approach", end.load, abs(end.load - jump.load), end.kind * (end.kind != "fold"))
            return False
        return True

    # the shear

    def shear(self, v) -> Skeleton | None:
        """The exact Skeleton, from the unknowns v (2 m,) at the end of the approach; None where something is found."""
        self.stage, self.load = "shear", 0.0
        skeleton, trace = self.skeleton, self.skeleton.trace
        problem, held = self._held(v)
        corrector = Corrector(problem)
        corrector.begin(State.at_rest(*trace.branches[0].states[0]))
        branches, secants, mode = list[Branch](), corrector.secants(), None
        for k, branch in enumerate(trace.branches):
            start = branches[-1].end if branches else branch.start
            solved, mode = self._branch(corrector, secants, branch, start, mode)
            if solved is None:
                return None
            branches.append(solved)
            if solved.slip is not None and solved.end <= self.scene.u_x_max:
                branches[k] = replace(solved, slip=self._landed(problem, solved.slip, branch.end))
            if self.found:
                return None
        if not skeleton.period and branches[-1].slip is None and branches[-1].end < self.scene.u_x_max - FOLD:
            self.note("end", "shear", branches[-1].end, why="the run goes on")
        if self.found:
            return None
        lost = any(jump.kind != "fold" for jump in self.jumps)
        exact = Trace(tuple(branches), trace.home, trace.period, () if lost else tuple(self.jumps))
        return replace(skeleton, trace=exact, lost=lost, held=held, residual=self.residual)

    def _held(self, v):
        """(the problem of the shear, its Held or None), with the checks of what happens at U_x = 0."""
        skeleton, scene = self.skeleton, self.scene
        given = Equilibrium(self.contact, sideways(1.0, -scene.delta))
        if skeleton.held is None:
            return given, None
        pressure = self.contact.pressure(given.traction(v)[1])
        problem, v_held = Equilibrium(self.contact, sideways(1.0, 0.0), pressure), np.append(v, -scene.delta)
        mode = self.judge.accept(problem, v_held)
        kind = "" if mode.rests else "control"
        if kind != (skeleton.held.kind or ""):
            self.note("held load", "shear", 0.0, why=f"the state is {'un' * bool(kind)}stable under it")
        elif kind:
            end = End(0.0, v_held, mode.x / np.abs(mode.x).max(), kind, growth=mode.growth)
            self._landed(problem, end, 0.0)
        elif (off := np.abs(v_held - skeleton.unknowns(0.0)[0]).max()) > SAME * problem.unit:
            self.note("end", "shear", 0.0, off, "the shear begins elsewhere")
        return problem, Held(v, kind)

    def _branch(self, corrector, secants, branch, start, mode):
        """(the Branch from load `start`, nm, solved and judged, or None; the last Mode)."""
        problem, fold = corrector.problem, None
        if branch.slip is not None:
            self.counts[1] += 1
            fold = fold_near(problem, branch.slip, SEARCH)
            if fold is None or abs(fold.load - branch.end) > FOLD:
                self.note("fold", "shear", branch.end, np.nan if fold is None else abs(fold.load - branch.end))
                return None, mode
            self.residual = max(self.residual, fold.residual)
            fold = fold._replace(sensitive=branch.slip.sensitive)
        states = list[Point]()
        left = branch.states[:-1] if fold or branch.periodic else branch.states
        for load, v in (Point(start, left[0].v), *left[1:]):
            self.load = load
            self.counts[0] += 1
            solution = corrector.solve(v, load, secants)
            off = np.inf if solution is None else np.abs(solution.v - v).max()
            if off > NEAR * problem.unit:
                self.note("state", "shear", load, off)
                return None, mode
            mode = self.judge.accept(problem, solution.v, mode)
            if not mode.rests:
                self.note("unstable", "shear", load)
                return None, mode
            self.residual = max(self.residual, solution.residual)
            states.append(Point(load, solution.v))
        if fold:
            states.append(Point(fold.load, fold.v))
        if branch.periodic:
            states.append(self._closed(problem, branch, states[0]))
        return replace(branch, states=tuple(states), slip=fold), mode

    def _closed(self, problem, branch, first):
        """The last Point of a period of smooth sliding: the first one, moved on."""
        way = (branch.end - branch.start) * problem.direction
        off = np.abs(branch.states[-1].v - branch.states[0].v - way).max()
        if off > SAME * problem.unit:
            self.note("period", "shear", branch.end, off)
        return Point(branch.end, first.v + way)

    def _landed(self, problem, end, followed):
        """The End of a branch, `sensitive` if its motion is; notes where the skeleton's slip lands elsewhere."""
        self.load = end.load
        slip = self.lands(problem, end)
        wanted = self.skeleton.unknowns(max(slip.after.load, followed) + BEYOND)[0]
        off = np.abs(slip.after.v - wanted).max()
        if off > ALIKE * problem.unit:
            self.note("landing", "shear", end.load, off)
        return end._replace(sensitive=slip.sensitive)
