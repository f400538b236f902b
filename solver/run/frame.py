"""What an increment leaves behind: the fields on the patch, the forces, the contact area and its edges."""

from dataclasses import dataclass

import numpy as np
from numba import njit

NORMAL = ("approach", "unload", "reload", "press")  # stages along which the indentation changes


@dataclass(frozen=True)
class SlipEvent:
    """The end of a branch: load U_x (or delta, in approach and retraction) in nm, and F_bar, L_bar, A_bar just before.

    kind: "fold", where the load has a maximum; "flutter", where an oscillation grows; "bifurcation", where a mode grows
    otherwise; "lost", where the branch could not be followed. located: whether the load is that of the end itself, to
    1e-6 nm, or that of the increment in which it lies.
    """

    load: float
    F_bar: float
    L_bar: float
    A_bar: float
    stage: str = ""
    kind: str = "fold"
    located: bool = True

    def as_dict(self):
        """The event by plain names, as JSON has it: the load is "delta" in approach and retraction, else "U_x"."""
        load = "delta" if self.stage in NORMAL else "U_x"
        numbers = {"F_bar": self.F_bar, "L_bar": self.L_bar, "A_bar": self.A_bar}
        return {"stage": self.stage, load: self.load} | numbers | {"kind": self.kind, "located": self.located}


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
    """A_bar: the length under repulsion over w, of all patches, from sign changes of T_z interpolated between nodes."""
    return _contact(scene, T, first)[0] / scene.nodes


def contact_edges(scene, T, first):
    """(patches, 2) nm, undeformed: the trailing and the leading edge of every patch, in order; nan in full contact.

    A patch across the ends of the cell, and those after it, lie beyond w: the order starts behind the widest gap.
    """
    return _contact(scene, T, first)[1]


def _contact(scene, T, first):
    """(repulsive length in spacings, edges (patches, 2) in nm)."""
    # repulsion weaker than an error of the tolerance makes is none: on the flat at dn = 0 it would flicker
    least = scene.tolerance * scene.phi_n / scene.delta_n**2
    n, closed = T.shape[1], T.shape[1] == scene.nodes
    edges = np.empty((n // 2 + 1, 2))
    length, patches = _edges(T, closed, least, edges)
    edges = edges[:patches]
    if closed and patches > 1 and edges[-1, 1] > n:  # a patch across the ends of the cell
        gaps = np.append(edges[1:, 0], edges[0, 0] + n) - edges[:, 1]
        k = int(np.argmax(gaps)) + 1
        edges = np.concatenate((edges[k:], edges[:k] + n))
        edges -= n * (edges[0, 0] // n)
    return length, (first + edges) * scene.spacing


@njit(cache=True, nogil=True)
def _edges(T, closed, least, out):
    """(repulsive length, patches); out (>= patches, 2): their edges in spacings; closed: the last node meets the first.

    The order starts at a node without contact; a first edge before node 0 is negative, a last one may lie beyond n.
    """
    n = T.shape[1]
    start, stop = -1, n
    if closed:  # from a node without contact on, once round
        start = 0
        while start < n and T[1, start] > least:
            start += 1
        if start == n:
            out[0] = np.nan
            return float(n), 1
        if start > 0 and T[1, n - 1] <= least:
            start = -1
        stop = start + n
    length, patches = 0.0, 0
    here = T[1, start] - least if closed else -least
    for i in range(start, stop):
        after = (T[1, (i + 1) % n] if closed or i + 1 < n else 0.0) - least
        if here > 0.0 and after > 0.0:
            length += 1.0
        elif after > 0.0:
            edge = here / (here - after)
            length += 1.0 - edge
            out[patches, 0] = i + edge
        elif here > 0.0:
            edge = here / (here - after)
            length += edge
            out[patches, 1] = i + edge
            patches += 1
        here = after
    return length, patches


def slip_event(scene, first, load, T):
    """The SlipEvent of a branch that ended at that load (nm) with tractions T (2, m), GPa."""
    return SlipEvent(float(load), *forces(scene, T), contact_area(scene, T, first))
