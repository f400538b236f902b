"""A point of a map: the regime of a scene and numbers of its first slip."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...following.skeleton import Skeleton
from ...run.frame import Frame, SlipEvent, slips_in
from ..peeling import peel_asymmetry

# A contact touches where a node has passed the peak of adhesion, at the gap delta_n. All regimes are up to u_x_max,
# or up to the end of a retraction
REGIMES = (
    "no result",
    "never touches",
    "sticks",
    "smooth sliding",
    "slips in part",
    "slips by one site",
    "slips by more sites",
    "detaches",
)
NO_RESULT, NEVER_TOUCHES, STICKS, SMOOTH, IN_PART, ONE_SITE, MORE_SITES, DETACHES = REGIMES


@dataclass(frozen=True)
class Point:
    """A point (i, j) of a map; picklable. Numbers are None where there is none.

    U_s (nm), F_s (N/m), A_s (nm) at the first slip, A_0 (nm) at U_x = 0: as of `summarize`. asymmetry: as of
    `peel_asymmetry`, from U_x = 0 up to the slip. sites: the sites by which the slip moves the node of least gap.
    reattached: the part of the area lost before the slip that the slip restores, 0 where the area shrinks. L_min, L_off
    (N/m): largest pull and parting load, as of `summarize`, on path unload only. branches: those until the run repeats
    itself, 0 if unknown. Where a contact detaches under a held load, U_s, F_s and A_s are those of the last increment.
    """

    i: int = 0
    j: int = 0
    regime: str = NO_RESULT
    U_s: float | None = None
    F_s: float | None = None
    A_s: float | None = None
    A_0: float | None = None
    asymmetry: float | None = None
    sites: int | None = None
    reattached: float | None = None
    L_min: float | None = None
    L_off: float | None = None
    branches: int = 0
    followed: bool = False
    evaluations: int = 0  # force evaluations spent on it
    reason: str = ""  # why there is no result

    @property
    def code(self) -> int:
        """The index of the regime in REGIMES."""
        return REGIMES.index(self.regime)

    @property
    def kind(self) -> tuple:
        """Regime, sites and branches: only points of one kind are continued from each other."""
        return self.regime, self.sites, self.branches


COLUMNS = tuple(field.name for field in fields(Point))
# numbers that a map can show
QUANTITIES = "U_s", "F_s", "A_s", "A_0", "asymmetry", "sites", "reattached", "L_min", "L_off"


def touches(frame: Frame) -> bool:
    """Whether a node of a Frame is within the peak of adhesion."""
    return least_gap(frame)[1] <= frame.scene.delta_n


def least_gap(frame: Frame) -> tuple[int, float]:
    """(node, its gap, nm) where the gap is least."""
    k = int(frame.gap.argmin())
    return frame.first + k, float(frame.gap[k])


def at_slip(start: Frame, before: Frame, after: Frame, event: SlipEvent) -> dict[str, Any]:
    """Fields of a Point with a first slip, from Frames at U_x = 0, before and after it, and its SlipEvent."""
    node, a = least_gap(before)[0], before.scene.spacing
    sites = round(after.u[0, node - after.first] / a) - round(before.u[0, node - before.first] / a)
    regime = DETACHES if not touches(after) else IN_PART if sites < 1 else ONE_SITE if sites == 1 else MORE_SITES
    lost, asymmetry = start.A_bar - event.A_bar, peel_asymmetry(start, before)
    return {
        "regime": regime,
        "U_s": event.load,
        "F_s": event.F_bar * start.unit,
        "A_s": event.A_bar * start.scene.width,
        "A_0": start.A,
        "asymmetry": None if np.isnan(asymmetry) else asymmetry,
        "sites": sites,
        # of peeled area below a tenth of a spacing no share is given: edges are interpolated to some hundredths
        "reattached": max(0.0, after.A_bar - event.A_bar) / lost if lost > 0.1 / start.scene.nodes else None,
    }


def of_skeleton(skeleton: Skeleton) -> dict[str, Any]:
    """Fields of a Point from the Skeleton of its run."""
    start = skeleton.frames([0.0])[0]
    if not touches(start):
        return {"regime": NEVER_TOUCHES, "A_0": start.A}
    counted = {"branches": len(skeleton.branches)}
    event = next(iter(slips_in(skeleton)), None)
    if event is None:
        return counted | {"regime": SMOOTH if skeleton.branches[0].periodic else STICKS, "A_0": start.A}
    before, after = skeleton.frames([event.load, np.nextafter(event.load, np.inf)])
    return counted | at_slip(start, before, after, event)
