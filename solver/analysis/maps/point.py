"""What is told of a scene up to just beyond its first slip, in numbers and a word."""

from dataclasses import asdict, dataclass, fields

import numpy as np

from ..peeling import peel_asymmetry

# "touches": a node has come through the peak of adhesion, the gap delta_n; all of what follows it is up to u_x_max
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
LOST = 0.1  # node spacings; where less peeled, no share of it reattaches


@dataclass(frozen=True)
class Point:
    """A point (i, j) of a map, plain and picklable; numbers are None where there is none.

    U_s (nm), F_s, A_s at the first slip, A_0 at U_x = 0: as of `summarize`. asymmetry: as of `peel_asymmetry`, from
    U_x = 0 up to the slip. sites: by how many the node of the least gap goes on in it. reattached: the part of the area
    lost before the slip that is there again after it, 0 where it shrinks further. L_min: the pull-off, of path unload
    only. branches: until the run repeats itself, 0 where that is not known. Where a contact comes off under a held
    load, U_s, F_s and A_s are those of the last increment.
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
    branches: int = 0
    followed: bool = False
    evaluations: int = 0  # force evaluations spent on it
    reason: str = ""  # why there is no result

    @property
    def code(self):
        """Of its regime: the place in REGIMES."""
        return REGIMES.index(self.regime)

    @property
    def kind(self):
        """What points have in common if one can be followed from the others."""
        return self.regime, self.sites, self.branches

    def as_row(self):
        """{column: value} with "" for None."""
        return {name: "" if value is None else value for name, value in asdict(self).items()}

    @staticmethod
    def from_row(row):
        """From {column: text or value}, as `as_row` gives it or a CSV file of it."""
        read = {"regime": str, "reason": str, "followed": lambda text: str(text) == "True"}
        whole = dict.fromkeys(("i", "j", "sites", "branches", "evaluations"), int)
        read = dict.fromkeys(COLUMNS, float) | whole | read
        return Point(**{k: None if row[k] == "" and k not in ("reason",) else read[k](row[k]) for k in COLUMNS})


COLUMNS = tuple(field.name for field in fields(Point))
QUANTITIES = "U_s", "F_s", "A_s", "A_0", "asymmetry", "sites", "reattached", "L_min"  # what a map may be of


def touches(frame):
    """Whether a node of a Frame is within the peak of adhesion."""
    return least_gap(frame)[1] <= frame.scene.delta_n


def least_gap(frame):
    """(node, its gap, nm) where the gap is least."""
    gap = frame.scene.profile[frame.first : frame.first + frame.u.shape[1]] + frame.u[1]
    k = int(gap.argmin())
    return frame.first + k, float(gap[k])


def at_slip(start, before, after, event):
    """What a Point says of a first slip: Frames at U_x = 0, before and after it, its SlipEvent."""
    sites = _sites(before, after)
    regime = DETACHES if not touches(after) else IN_PART if sites < 1 else ONE_SITE if sites == 1 else MORE_SITES
    lost, asymmetry = start.A_bar - event.A_bar, peel_asymmetry(start.scene, start, before)
    return {
        "regime": regime,
        "U_s": event.load,
        "F_s": event.F_bar,
        "A_s": event.A_bar,
        "A_0": start.A_bar,
        "asymmetry": None if np.isnan(asymmetry) else asymmetry,
        "sites": sites,
        "reattached": max(0.0, after.A_bar - event.A_bar) / lost if lost > LOST / start.scene.nodes else None,
    }


def _sites(before, after):
    """By how many sites the node in the closest contact before a slip goes on in it."""
    node, a = least_gap(before)[0], before.scene.spacing
    return round(after.u[0, node - after.first] / a) - round(before.u[0, node - before.first] / a)


def of_skeleton(skeleton):
    """What a Point says of a run that is known by its Skeleton."""
    start = skeleton.frames([0.0])[0]
    if not touches(start):
        return {"regime": NEVER_TOUCHES, "A_0": start.A_bar}
    known = {"branches": len(skeleton.branches)}
    event = first_slip(skeleton)
    if event is None:
        return known | {"regime": SMOOTH if skeleton.branches[0].periodic else STICKS, "A_0": start.A_bar}
    before, after = skeleton.frames([event.load, np.nextafter(event.load, np.inf)])
    return known | at_slip(start, before, after, event)


def first_slip(skeleton):
    """The first SlipEvent of a Skeleton, or None."""
    return next(iter(slips_in(skeleton)), None)


def slips_in(run):
    """SlipEvents of a Frame or Skeleton, without the jump where a held load takes over; see `summarize`."""
    return [event for event in run.slips if event.kind != "control"]
