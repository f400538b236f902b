"""The unstable branches of a run, for workers."""

from typing import Any

from solver import NotFollowed, Skeleton, unstable_branch
from solver.analysis.unstable import MOST as POINTS
from solver.run.frame import slips_in

MOST = 40  # slips that are drawn
DIFFERENT = 4  # slips that are computed; the others repeat them
SOON = 100  # points of a branch while a slider is held: a quarter of a second at most


def branches(skeleton: Skeleton, exact: bool = True) -> tuple[list[dict[str, Any]], str]:
    """Return ([{U_x, A (nm), F, L (N/m)}] of the slips up to u_x_max, what the last one says).

    exact: as many points as they need, of all that differ; else the first SOON of one.
    """
    points, different = (POINTS, DIFFERENT) if exact else (SOON, 1)
    scene, made, why = skeleton.scene, list[dict[str, Any]](), "This run has no slips."
    unit, known = scene.width * scene.E, {}
    passes = zip(slips_in(skeleton)[:MOST], skeleton.trace.passes(), strict=False)
    for number, (_, (index, turns)) in enumerate(passes):
        try:
            if index not in known and len(known) < different:
                known[index] = unstable_branch(skeleton, number, points), turns
        except NotFollowed as failure:
            return made, f"{failure}"
        if index in known:
            branch, first = known[index]
            U_x, why = branch.U_x + (turns - first) * skeleton.period, branch.why
            lists = {"U_x": U_x, "F": branch.F_bar * unit, "L": branch.L_bar * unit, "A": branch.A_bar * scene.width}
            made.append({name: [float(f"{x:.6g}") for x in values] for name, values in lists.items()})
    return made, why
