"""The boundary between stick-slip and smooth sliding: where the last slip of a scene ends as a parameter changes.

The fold at which a slip begins and the fold at which the branch turns again merge in a cusp (`cusp`). The search
follows a fold of the scene to its cusp, then walks once over the period just beyond: while there is another fold, it
follows that one. From a scene that slides smoothly it starts where its branch is least steep.

Under tension a surface may slip only because it has jumped into contact on approach. A stiffer one jumps later. Where
the jump would come at delta itself, it stays out of contact. If it slides smoothly there, slips end at this E, without
a cusp.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..continuation.arc import walk_arc
from ..continuation.corrector import Corrector
from ..continuation.state import NotConverged, Point
from ..following.from_run import skeleton_of
from ..following.moved import NotFollowed, Solver
from ..following.skeleton import Skeleton
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.load_steps import vertical
from ..run.loadpath import until
from ..scene import LIMITS, Scene, SceneError
from ..schema import unknown_name
from ..threads import computation
from .cusp import Lost, State, System, along_folds, newton

SMOOTHER = {"phi_ratio": -1.0, "E": 1.0}  # whether sliding gets smoother as the parameter grows, or as it falls
BELOW = 1e-3  # of the parameter: so far on the smooth side of a cusp a period is walked
BEYOND = 0.4  # of log p: a search that leaves the range by more than this ends
SMOOTH = 100.0  # the factor by which a parameter changes to a scene that slides more smoothly
FOLDS = 8  # most folds that are followed to their cusps
PLACES = 256  # loads of a smooth period among which the least slope is looked for
GENTLE = 0.1  # slope of the load over the largest one: where it is less, a small fold may lie between two points
BACK = 0.03  # units: the distance of the first two points of a walk
SOLVED = 1e-6  # nm, residual of its points
WALKED = 200  # most points of a period
# Of log p: the first step and the longest one to where the jump into contact comes at delta, and the last one
TRIED, FARTHEST, SURE = 0.01, 0.1, 1e-9
TRIES = 40  # of such steps
PAST = 3e-3  # of the parameter: so far beyond, a run shows whether the surface slips; nearer the jump it is soft
SLIPPING = 0.9, 0.5, 0.2  # of E: scenes that may slip where one slides smoothly


class Beyond(Lost):
    """The boundary is out of range."""


@dataclass(frozen=True, eq=False, repr=False)
class Boundary:
    """Where stick-slip ends and smooth sliding begins.

    value: of the parameter `name`; None where it was not found, and `why` says the reason. U_x, nm: the load at which
    the last slip vanishes; nan where slips end as the surface no longer jumps into contact. scene: with that value.
    evaluations: force evaluations, but for those of the scene's run.

    Example: `boundary(Scene(), "E", within=(10.0, 3000.0))`
    """

    name: str
    value: float | None
    U_x: float = np.nan
    scene: Scene | None = field(default=None, repr=False)
    evaluations: int = 0
    why: str = ""

    def __repr__(self) -> str:
        found = f"{self.name} = {self.value:.10g}" if self.value is not None else f"none found: {self.why}"
        return f"Boundary: {found}, {self.evaluations} force evaluations"


@computation
def boundary(run: Scene | Skeleton, name: str, within: tuple[float, float] | None = None) -> Boundary:
    """Computes the value of a parameter at which slips end and sliding becomes smooth.

    The first pull and the sliding after it have the same boundary. Its relative error is below 1e-6.

    Parameters: run: a Scene, or its Skeleton, which saves the run; name: "phi_ratio" or "E"; within: range of values
    that is searched (default: those that a Scene allows).
    Returns a Boundary: of a scene that slips, where its slips end; of one that slides smoothly, where they begin.
    Raises SceneError for another name. Anything else that fails gives a Boundary without a value, that says why.

    Example: `boundary(Scene(), "phi_ratio").value`
    """
    if name not in SMOOTHER:
        raise unknown_name(name, SMOOTHER)
    search = _Search(name, within or (LIMITS[name].low, LIMITS[name].high))
    try:
        state = search.found(run)
    except (Lost, NotFollowed, NotConverged, SceneError, np.linalg.LinAlgError) as failure:
        return Boundary(name, None, evaluations=search.evaluations, why=str(failure))
    return Boundary(name, search.value(state), state.load, state.scene, search.evaluations)


class _Search:
    """The search for the boundary by one parameter; counts its force evaluations."""

    def __init__(self, name, within):
        self.name, self.within, self.way, self.evaluations = name, within, SMOOTHER[name], 0

    def value(self, state):
        """The parameter of a State."""
        return float(getattr(state.scene, self.name))

    def spend(self, at):
        """Count the evaluations of a System; raises Lost where it is far out of range."""
        self.evaluations += at.evaluations()
        low, high = (bound * np.exp(far) for bound, far in zip(self.within, (-BEYOND, BEYOND), strict=True))
        if not low <= self.value(at.state) <= high:
            raise self.beyond()

    def beyond(self):
        """The exception for a boundary out of range."""
        return Beyond(f"the boundary lies beyond {self.name} = {self.within[0]:g} .. {self.within[1]:g}")

    def found(self, run) -> State:
        """The State at the boundary, from a Scene or its Skeleton; raises Lost."""
        scene = run.scene if isinstance(run, Skeleton) else run
        if self.name != "E" or scene.delta >= 0.0 or scene.hold == "load":  # phi_ratio hardly moves the jump
            return self.by_cusp(run)
        run = run if isinstance(run, Skeleton) else skeleton_of(run)
        slips = run.branches[-1].slip is not None
        state = entry = self.entry(run) if slips and run.trace.jumps else None
        try:
            state = self.by_cusp(run)
        except (Lost, NotFollowed, NotConverged, SceneError, np.linalg.LinAlgError):
            if slips and entry is None:
                raise
        if state is None:
            return self.found(self.skeleton(self.slipping(scene)))
        if entry is not None and self.way * (self.value(entry) - self.value(state)) < 0.0:
            state = entry
        if slips and state is not entry:
            return state
        beyond = state.moved(self.name, 0.0, 0.0, PAST).scene
        return self.found(self.skeleton(beyond)) if self.within[1] >= beyond.E and self.slips(beyond) else state

    def skeleton(self, scene) -> Skeleton:
        """The Skeleton of another scene than that of the search."""
        made = skeleton_of(scene)
        self.evaluations += made.evaluations
        return made

    def slips(self, scene) -> bool:
        """Whether the surface slips in the shear of a scene's run."""
        for frame, _ in until(scene, lambda frame: frame.stage == "shear" and bool(frame.slips or frame.repeated)):
            self.evaluations += frame.evaluations
        return bool(frame.slips)

    def slipping(self, scene) -> Scene:
        """A scene of smaller E in which the surface slips; raises Lost."""
        values = [scene.E * part for part in SLIPPING if scene.E * part >= self.within[0]]
        for E in values:
            if self.slips(other := scene.changed(E=E)):
                return other
        raise Lost(f"the surface slides smoothly at E = {', '.join(f'{E:.4g}' for E in values) or scene.E}, too")

    def entry(self, skeleton) -> State | None:
        """The State in which the surface jumps into contact at delta, at a larger E; None if there is none in range."""
        scene, step = skeleton.scene, self.way * TRIED
        jump: Any = skeleton.trace.jumps[-1]
        before = None  # (log p, delta of the jump)
        for _ in range(TRIES):
            contact = Contact(scene, skeleton.first, skeleton.nodes)
            try:
                jump = Solver(Equilibrium(contact, vertical(1.0))).fold(jump, "the jump into contact")
            except NotFollowed:
                return None
            finally:
                self.evaluations += contact.evaluations
            there = np.log(getattr(scene, self.name)), jump.load
            if before and there[1] != before[1]:
                step = (scene.delta - there[1]) * (there[0] - before[0]) / (there[1] - before[1])
            state = State(scene, skeleton.first, jump.v, np.nan, jump.phi)
            if abs(step) < SURE:
                return state if self.way * (self.value(state) - self.value(skeleton)) > 0.0 else None
            before, step = there, float(np.clip(step, -FARTHEST, FARTHEST))
            if not self.within[0] <= getattr(scene, self.name) * np.exp(step) <= self.within[1]:
                return None
            scene = state.moved(self.name, 0.0, 0.0, step).scene
        return None

    def by_cusp(self, run) -> State:
        """The State at the cusp of a Scene or its Skeleton or, if that fails, of a scene that is smoother."""
        scene = run.scene if isinstance(run, Skeleton) else run
        try:
            return self.lowest(run if isinstance(run, Skeleton) else skeleton_of(run))
        except Beyond:
            raise
        except (Lost, NotFollowed, np.linalg.LinAlgError):
            if isinstance(run, Skeleton) and not run.branches[-1].slip:
                raise
        value = np.clip(getattr(scene, self.name) * SMOOTH**self.way, *self.within)
        return self.lowest(self.skeleton(scene.changed(**{self.name: float(value)})))

    def lowest(self, skeleton) -> State:
        """The State at the cusp beyond which sliding is smooth; raises Lost."""
        if skeleton.scene.phi_ratio == 0.0:
            raise Lost("nothing resists shear: use a phi_ratio above 0")
        if not skeleton.period:
            raise Lost("the run does not repeat itself: use a larger u_x_max")
        state = self.end_of_slips(skeleton) if skeleton.branches[-1].slip else self.begin_of_slips(skeleton)
        for _ in range(FOLDS):
            if not self.within[0] <= self.value(state) <= self.within[1]:
                raise self.beyond()
            lower = self.lower(state)
            if lower is None:
                return state
            state = lower
        raise Lost(f"slips remain beyond {FOLDS} cusps")

    def end_of_slips(self, skeleton):
        """The cusp of the fold of a Skeleton from which a slip leads farthest, or of another one that has a cusp."""
        ends = [branch for branch in skeleton.branches if branch.slip]
        jumps = [np.abs(np.subtract(*skeleton.unknowns([b.end, np.nextafter(b.end, np.inf)]))).max() for b in ends]
        failure = Lost("")
        for k in np.argsort(jumps)[::-1]:
            slip = ends[k].slip
            try:
                return self.from_fold(_state(skeleton, slip.v, slip.load, slip.phi, slip.psi))
            except Lost as lost:
                failure = lost
        raise failure

    def from_fold(self, state):
        """The cusp at which the curve of folds from a State ends; raises Lost."""
        return self.cusp(along_folds(state, self.name, self.way, self.spend))

    def begin_of_slips(self, skeleton):
        """The cusp next to the state of a smooth period in which the surface moves fastest; raises Lost."""
        (branch,) = skeleton.branches
        loads = np.linspace(branch.start, branch.end, PLACES)
        v = skeleton.unknowns(loads)
        moves = np.diff(v, axis=0)
        k = int(np.abs(moves).max(axis=1).argmax())
        return self.cusp(_state(skeleton, v[k], loads[k], moves[k]))

    def cusp(self, state):
        """The cusp near a State; raises Lost."""
        return newton(state, self.name, self.spend)

    def lower(self, state):
        """The cusp of a fold that is left just beyond that of a State; None if sliding is smooth there."""
        at, points, slopes = self.walked(state)
        if slopes[-1] < 0.0:
            places = [len(slopes) - 1]
        else:  # a fold may lie between two points
            gentle = GENTLE * max(slopes)
            places = [k for k in range(1, len(slopes) - 1) if slopes[k] < min(gentle, slopes[k - 1], slopes[k + 1])]
        for k in places:
            near = replace(at.state, v=points[k].v, load=points[k].load, phi=points[k + 1].v - points[k].v, psi=None)
            try:
                found = self.from_fold(near) if slopes[k] < 0.0 else self.cusp(near)
            except Lost:
                if slopes[k] < 0.0:
                    raise
                continue
            if self.way * (self.value(found) - self.value(at.state)) > 0.0:
                return found
            if slopes[k] < 0.0:
                raise Lost("a slip remains beyond the cusp that was found")
        return None

    def walked(self, state):
        """(System, Points, slopes between them) of the period just beyond the cusp of a State, or up to a slip."""
        at = System(state.moved(self.name, 0.0, 0.0, self.way * BELOW), self.name)
        start, _ = at.moved(0.0, 0.0)
        back = BACK * at.problem.unit / np.abs(at.phi).max()
        slope = at.g / np.linalg.norm(at.problem.direction)
        points, slopes = [Point(start.load - back * slope, start.v - back * at.phi), Point(start.load, start.v)], []
        for point in walk_arc(Corrector(at.problem.solved_to(SOLVED)), points[::-1]):
            points.append(point)
            slopes.append((point.load - points[-2].load) / np.abs(point.v - points[-2].v).max())
            if slopes[-1] < 0.0 or point.load > start.load + state.scene.spacing or len(slopes) > WALKED:
                break
        self.spend(at)
        if not slopes or (slopes[-1] > 0.0 and points[-1].load < start.load + state.scene.spacing):
            raise Lost("the branch beyond the cusp that was found cannot be followed over a period")
        return at, points[1:], slopes


def _state(skeleton, v, load, phi, psi=None):
    """The State of a Skeleton's scene."""
    return State(skeleton.scene, skeleton.first, v, float(load), phi, psi, skeleton.held)
