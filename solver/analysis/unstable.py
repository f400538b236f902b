"""The unstable branch that a slip jumps over: the equilibria between two stable branches, which no run visits.

At the fold where a slip begins the branch turns back. It goes on to lower loads, unstable, until it turns again and
becomes the stable branch of the next site.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..continuation.arc import walk_arc
from ..continuation.corrector import Corrector
from ..continuation.fold import FoldOptions, fold_near
from ..continuation.state import End, Point
from ..following.moved import NotFollowed
from ..following.skeleton import Skeleton
from ..run.frame import contact_area, forces, slips_in
from ..scene import Scene
from ..threads import computation

SOLVED = 1e-8  # nm, residual of the states
FOLDS = FoldOptions(state=1e-8, accuracy=1e-3)  # units
LEAST = FoldOptions(state=1e-8, accuracy=1e-3, least=True)
BACK = 0.03  # units, from the fold to the point before it
MOST = 400  # points; the default's branch has 106, as one node after another moves on


@dataclass(frozen=True, eq=False, repr=False)
class UnstableBranch:
    """The states of an unstable branch from the fold where a slip begins to the next fold, in order.

    U_x (k,): loads, nm; F_bar, L_bar, A_bar (k,); v (k, size): unknowns as of a Skeleton. sites: the sites over which
    the slip leads. ends: whether the last state is a fold; else `why` says where the branch was lost. residual: the
    largest, nm.

    Example: `unstable_branch(skeleton_of(Scene())).U_x[[0, -1]]`
    """

    scene: Scene = field(repr=False)
    U_x: NDArray[np.float64]
    F_bar: NDArray[np.float64]
    L_bar: NDArray[np.float64]
    A_bar: NDArray[np.float64]
    v: NDArray[np.float64]
    sites: int
    ends: bool
    why: str
    residual: float
    evaluations: int

    def __repr__(self) -> str:
        return f"UnstableBranch: {len(self.U_x)} states, U_x = {self.U_x[0]:.6g} .. {self.U_x[-1]:.6g} nm. {self.why}"


@computation
def unstable_branch(run: Any, slip: int = 0) -> UnstableBranch:
    """Computes the unstable branch that a slip jumps over.

    Parameters: run: a Result, or a Skeleton; slip: number of the slip in shear, from 0 on.
    Returns the UnstableBranch from the fold at which the slip begins to the next fold.
    Raises NotFollowed for a run without a Skeleton, such as one in which a branch ends by flutter, and where Newton's
    steps do not solve the fold; IndexError for a slip that the run does not have.

    Example: `unstable_branch(simulate(Scene()), 1).F_bar`
    """
    skeleton = run if isinstance(run, Skeleton) else run.skeleton
    passes = [at for _, at in zip(slips_in(skeleton), skeleton.trace.passes(), strict=False)]
    if not 0 <= slip < len(passes):
        raise IndexError(f"slip = {slip}: allowed for this run: 0 .. {len(passes) - 1}; choose another")
    index, turns = passes[slip]
    branch, problem = skeleton.branches[index], skeleton.problem().solved_to(SOLVED)
    fold = fold_near(problem, branch.slip, FOLDS) if branch.slip else None
    if fold is None:
        raise NotFollowed(f"the fold at {branch.end:g} nm is not solved by Newton's steps")
    forth = fold.phi @ (fold.v - branch.states[-2].v)
    points, end = _walked(problem, fold, np.sign(forth) * fold.phi)
    sites = round(problem.sites(fold.v, skeleton.unknowns(np.nextafter(branch.end, np.inf))[0]))
    return _branch(skeleton, problem, points, turns * skeleton.period, sites, end is not None)


def _walked(problem, fold, phi):
    """(the Points from a fold on, the End at the next fold, the last Point; or None if the branch is lost)."""
    before = Point(fold.load, fold.v - BACK * problem.unit * phi / np.abs(phi).max())
    points = [Point(fold.load, fold.v)]
    for point in walk_arc(Corrector(problem), [points[0], before]):
        if point.load > points[-1].load and len(points) > 1:
            last = points[-1]
            end = fold_near(problem, End(last.load, last.v, point.v - last.v), LEAST)
            return (points if end is None else [*points[:-1], Point(end.load, end.v)]), end
        points.append(point)
        if len(points) > MOST:
            break
    return points, None


def _branch(skeleton, problem, points, shift, sites, ends):
    """The UnstableBranch of Points, moved on by `shift` nm."""
    v, r = np.array([point.v for point in points]), np.empty(problem.size)
    residual = max(problem.residual(point.v, point.load, r) for point in points)
    T, evaluations = skeleton.tractions(v[:, : 2 * skeleton.nodes]), problem.evaluations
    v += shift * problem.direction
    loads, areas = (
        np.array([point.load for point in points]) + shift,
        [contact_area(skeleton.scene, each) for each in T],
    )
    why = "It ends at the next fold, where the branch of the next site begins."
    if not ends:
        why = f"It could be followed down to U_x = {loads[-1]:.6g} nm only."
    elif sites > 1:
        why = f"It ends at the next fold. The slip does not rest on the branch beyond: it leads over {sites} sites."
    bars = *forces(skeleton.scene, T), np.array(areas)
    return UnstableBranch(skeleton.scene, np.array(loads), *bars, v, sites, ends, why, float(residual), evaluations)
