"""What an increment leaves behind: the fields on the patch, the forces, the contact area and its edges."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SlipEvent:
    """The end of a branch: load U_x (or delta, during approach) in nm, and F_bar, L_bar, A_bar just before the slip."""

    load: float
    F_bar: float
    L_bar: float
    A_bar: float


@dataclass(frozen=True)
class Frame:
    """One converged increment (paper Eq. 6 for the forces).

    u, T: (2, m) displacement (nm) and traction on the layer (GPa) of the patch, whose first node is `first`; read-only.
    """

    stage: str  # "approach" or "shear"
    index: int  # of the increment within its stage
    U_x: float  # nm
    delta: float  # nm
    first: int
    u: np.ndarray
    T: np.ndarray
    F_bar: float
    L_bar: float
    A_bar: float
    trailing: float  # contact edges on the undeformed surface, nm; nan without contact
    leading: float
    residual: float  # max |U + C T(u) - u|, nm
    evaluations: int  # force evaluations of this increment
    slips: tuple = ()  # SlipEvents in this increment

    @property
    def slip(self):
        """Whether the branch ended within this increment."""
        return bool(self.slips)

    @property
    def U_slip(self):
        """Load at the first slip of this increment, nm, or None."""
        return self.slips[0].load if self.slips else None


def forces(scene, T):
    """(F_bar, L_bar): tangential and normal force over w E; attraction is negative."""
    scale = scene.spacing / (scene.width * scene.E)
    return -float(T[0].sum()) * scale, float(T[1].sum()) * scale


def contact_area(scene, T, first):
    """(A_bar, trailing, leading) from the sign changes of T_z, interpolated between nodes.

    A_bar: repulsive length over w; trailing, leading: outermost edges in nm (nan without contact).
    """
    n, a, tz = T.shape[1], scene.spacing, T[1]
    if n < scene.nodes:
        tz = np.concatenate(([0.0], tz, [0.0]))
        first -= 1
    inside = tz > 0.0
    if not inside.any():
        return 0.0, np.nan, np.nan
    if inside.all():
        return 1.0, np.nan, np.nan
    after, follows = np.roll(tz, -1), np.roll(inside, -1)
    i = np.flatnonzero(inside != follows)
    share = tz[i] / (tz[i] - after[i])  # from node i to the edge, in spacings
    opens = follows[i]
    length = np.count_nonzero(inside & follows) + float(np.where(opens, 1.0 - share, share).sum())
    edges = (first + i + share) * a
    return length / scene.nodes, float(edges[opens].min()), float(edges[~opens].max())


def slip_event(scene, first, slip):
    """The SlipEvent of a Slip."""
    return SlipEvent(slip.load, *forces(scene, slip.traction), contact_area(scene, slip.traction, first)[0])
