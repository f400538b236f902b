"""The unstable branch that a slip jumps over: the equilibria between two stable branches, which no run visits.

At the fold where a slip begins the branch turns back. It goes on to lower loads, unstable, until it turns again and
becomes the stable branch in which the slip lands. On the way it may turn several times, where a front of slip passes
from node to node. Pieces between such turns may be stable, but no run with rising load reaches them.
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
from ..following.skeleton import skeleton_in
from ..run.frame import contact_area, forces, slips_in
from ..scene import Scene
from ..text import counted
from ..threads import computation

SOLVED = 1e-8  # nm, residual of the states
FOLDS = FoldOptions(state=1e-8, accuracy=1e-3)  # units
LEAST = FoldOptions(state=1e-8, accuracy=1e-4, least=True)  # with 1e-3 a soft mode was missed
BACK = 0.03  # units, from the fold to the point before it
MOST = 400  # points; the default's branch has 72, as one node after another moves on


@dataclass(frozen=True, eq=False, repr=False)
class UnstableBranch:
    """The states of an unstable branch, from the fold where a slip begins to that where the next branch does.

    U_x (k,): loads, nm; F_bar, L_bar, A_bar (k,); v (k, size): unknowns as of a Skeleton. sites: the sites over which
    the slip leads. ends: whether the last state is that fold; else `why` says where the branch was lost. residual: the
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
def unstable_branch(run: Any, slip: int = 0, most: int = MOST) -> UnstableBranch:
    """Computes the unstable branch that a slip jumps over.

    Parameters: run: a Result, or a Skeleton; slip: number of the slip in shear, from 0 on;
    most: points after which the walk ends.
    Returns the UnstableBranch from the fold at which the slip begins to that of the branch which outlasts this one.
    Raises NotFollowed for a run without a Skeleton, such as one in which a branch ends by flutter, and where Newton's
    steps do not solve the fold; IndexError for a slip that the run does not have.

    Example: `unstable_branch(simulate(Scene()), 1).F_bar`
    """
    skeleton = skeleton_in(run)
    passes = [at for _, at in zip(slips_in(skeleton), skeleton.trace.passes(), strict=False)]
    if not 0 <= slip < len(passes):
        raise IndexError(f"slip = {slip}: allowed for this run: 0 .. {len(passes) - 1}; choose another")
    index, turns = passes[slip]
    branch, problem = skeleton.branches[index], skeleton.problem().solved_to(SOLVED)
    fold = fold_near(problem, branch.slip, FOLDS) if branch.slip else None
    if fold is None:
        raise NotFollowed(f"the fold at {branch.end:g} nm is not solved by Newton's steps")
    forth = fold.phi @ (fold.v - branch.states[-2].v)
    points, end = _walked(problem, fold, np.sign(forth) * fold.phi, most)
    sites = round(problem.sites(fold.v, skeleton.unknowns(np.nextafter(branch.end, np.inf))[0]))
    return _branch(skeleton, problem, points, turns * skeleton.period, sites, end is not None, most)


def _walked(problem, fold, phi, most):
    """(the Points from a fold on, the End where the next branch begins, the last Point; or None if that is lost)."""
    before = Point(fold.load, fold.v - BACK * problem.unit * phi / np.abs(phi).max())
    points, least = [Point(fold.load, fold.v)], 0  # least: number of the last minimum
    for point in walk_arc(Corrector(problem, twice=False), [points[0], before]):
        if least and point.load > fold.load:
            low, above = points[least : least + 2]
            end = fold_near(problem, End(low.load, low.v, above.v - low.v), LEAST)
            return [*points[:least], low if end is None else Point(end.load, end.v)], end
        points.append(point)
        if len(points) > 2 and points[-3].load > points[-2].load < point.load:
            least = len(points) - 2
        if len(points) > most:
            break
    return points, None


def _branch(skeleton, problem, points, shift, sites, ends, most):
    """The UnstableBranch of Points, moved on by `shift` nm."""
    v, r = np.array([point.v for point in points]), np.empty(problem.size)
    residual = max(problem.residual(point.v, point.load, r) for point in points)
    T, evaluations = skeleton.tractions(v[:, : 2 * skeleton.nodes]), problem.evaluations
    v += shift * problem.direction
    loads, areas = (
        np.array([point.load for point in points]) + shift,
        [contact_area(skeleton.scene, each) for each in T],
    )
    why = "It ends at the fold where the branch of the next site begins."
    if not ends:
        how = f"was followed over {len(points)} states" if len(points) > most else "could be followed"
        why = f"It {how} to U_x = {loads[-1]:.6g} nm only."
    elif sites > 1:
        why = "It ends at the fold where the branch begins in which the slip lands."
    if sites > 1:
        why += f" The slip leads over {sites} sites."
    if turns := int((np.diff(np.sign(np.diff(loads))) != 0.0).sum()):
        why += f" It turns {counted(turns, 'time')} on the way, where a front of slip passes from node to node."
    bars = *forces(skeleton.scene, T), np.array(areas)
    return UnstableBranch(skeleton.scene, np.array(loads), *bars, v, sites, ends, why, float(residual), evaluations)
