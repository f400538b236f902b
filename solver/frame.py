"""What an increment leaves behind: the fields on the patch, the forces, the contact area and its edges."""

from dataclasses import dataclass

import numpy as np
from numba import njit


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
    repeated: bool = False  # known from an earlier lattice period, moved on and verified

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
    scale = 1.0 / (scene.nodes * scene.E)
    F, L = _sums(T)
    return -F * scale, L * scale


@njit(cache=True, nogil=True)
def _sums(T):
    x = z = 0.0
    for i in range(T.shape[1]):
        x += T[0, i]
        z += T[1, i]
    return x, z


def contact_area(scene, T, first):
    """(A_bar, trailing, leading) from the sign changes of T_z, interpolated between nodes.

    A_bar: repulsive length over w; trailing, leading: outermost edges in nm (nan without contact).
    """
    # repulsion weaker than an error of the tolerance makes is none: on the flat at dn = 0 it would flicker
    least = scene.tolerance * scene.phi_n / scene.delta_n**2
    length, trailing, leading = _contact(T, T.shape[1] == scene.nodes, least)
    return length / scene.nodes, (first + trailing) * scene.spacing, (first + leading) * scene.spacing


@njit(cache=True, nogil=True)
def _contact(T, closed, least):
    """Repulsive length, first opening and last closing edge, in spacings; closed: the last node meets the first."""
    n = T.shape[1]
    length, trailing, leading = 0.0, np.nan, np.nan
    for i in range(0 if closed else -1, n):
        here = T[1, i] - least if i >= 0 else -least
        after = (T[1, i + 1] if i + 1 < n else (T[1, 0] if closed else 0.0)) - least
        if here > 0.0 and after > 0.0:
            length += 1.0
        elif after > 0.0:
            edge = here / (here - after)
            length += 1.0 - edge
            if np.isnan(trailing):
                trailing = i + edge
        elif here > 0.0:
            edge = here / (here - after)
            length += edge
            leading = i + edge
    return length, trailing, leading


def slip_event(scene, first, load, T):
    """The SlipEvent of a branch that ended at that load (nm) with tractions T (2, m), GPa."""
    return SlipEvent(float(load), *forces(scene, T), contact_area(scene, T, first)[0])
