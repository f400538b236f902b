"""The nodes that can interact: their tractions and tangents, and the layer's response to them."""

import numpy as np

from . import cohesive_law, kernels
from .cohesive_law import traction
from .layer import Convolution, Modes

REACH = 25.0  # delta_n: farther apart, a spring pulls with less than 25 exp(-25) = 3.5e-10 of phi_n/delta_n


class Contact:
    """The patch of `size` neighbouring nodes from node `first` on; counts its force evaluations.

    Nodes outside carry no traction; the tractions of the patch displace them. `observe()` is called after evaluations,
    of which compiled loops make several; it may raise to end the increment. If it has a true attribute `every_step`, it
    is called at every step of a motion, with (surface, y, load). Owns its buffers: two threads need two objects.

    Attributes: part, the slice of the patch in the cell; modes of the layer; layer, its Convolution; law, work: as of
    `kernels`.
    """

    def __init__(self, scene, first, size):
        self.scene, self.first, self.size, self.nodes = scene, first, size, scene.nodes
        self.part = slice(first, first + size)
        self.profile = np.ascontiguousarray(scene.profile[self.part])
        self.law, self.work = cohesive_law.law_constants(scene), np.empty((cohesive_law.WORK, size))
        self.modes = Modes.of(scene)
        self.layer = Convolution(self.modes, size)
        self.evaluations, self.observe = 0, None

    def evaluated(self, *moving, times=1) -> None:
        """Count force evaluations, with the state of a motion; raises what `observe` raises."""
        self.evaluations += times
        if self.observe:
            self.observe(*moving)

    def response(self, u) -> np.ndarray:
        """C T(u), (2, size) nm, of u (2, size) nm: one force evaluation; a buffer, valid until the next."""
        self.evaluated()
        self.traction(u, self.layer.field)
        self.layer.apply()
        return self.layer.product

    @property
    def last_traction(self) -> np.ndarray:
        """T (2, size) of the last `response`, GPa; its buffer."""
        return self.layer.field

    def traction(self, u, out=None) -> np.ndarray:
        """T(u), (2, size) GPa: `out`, or a new array."""
        out = np.empty((2, self.size)) if out is None else out
        cohesive_law.tractions(u, self.profile, self.law, self.work, out)
        return out

    def tangents(self, u) -> np.ndarray:
        """dT/du of every node, rows as in `cohesive_law.tangents`, (4, size) GPa/nm; a new array."""
        tangents = np.empty((4, self.size))
        cohesive_law.tangents(u, self.profile, self.law, self.work, tangents)
        return tangents

    def stiffest(self, u) -> float:
        """The largest sum of magnitudes in a row of dT/du of any node, GPa/nm; nan if one is."""
        return kernels.stiffest(u[0], u[1], self.profile, self.law, self.work)

    def pressure(self, T_z) -> float:
        """Mean over the cell, GPa, of normal tractions (size,) GPa."""
        return float(T_z.sum()) / self.nodes

    def comply(self, T) -> np.ndarray:
        """C T, (2, size) nm, of T (2, size) GPa; a buffer; counts as a force evaluation, without exponentials."""
        self.evaluated()
        self.layer.field[:] = T
        self.layer.apply()
        return self.layer.product

    def distance(self, u) -> float:
        """The smallest gap, nm."""
        return float((self.profile + u[1]).min())

    def outside(self, u) -> float:
        """The smaller gap at the ends of the patch, nm: nodes outside are farther; inf if it is the whole cell."""
        return float((self.profile + u[1])[[0, -1]].min()) if self.size < self.nodes else np.inf


def patch(scene) -> tuple[int, int]:
    """(first, size) of the nodes that springs can reach in any state of a run: the others are farther than REACH.

    An estimate, which a run verifies no further: attraction is at most p = -T_z(delta_n) a node. Friction is taken as
    q, that without overlap; surfaces that overlap resist exp(-Delta_n/delta_n) times as much. So much draws no node by
    more than p sum |C_zz| + q sum |C_xz|; a held load lets the top sink by as much again. A node under repulsion has a
    negative gap, so it is lifted by less than that plus the indentation. The layer beside it sinks by at most the share
    of that lift which C_zz has of negative values.
    """
    _, zz, xz = Modes.of(scene).kernels
    p = -traction(scene, 0.0, scene.delta_n)[1]
    q = traction(scene, np.linspace(0.0, scene.spacing, 65), 0.0)[0].max()  # its error is 1e-3
    drawn = (p * np.abs(zz).sum() + q * np.abs(xz).sum()) * (2.0 if scene.hold == "load" else 1.0)
    sinks = -np.minimum(zz, 0.0).sum() / np.maximum(zz, 0.0).sum()
    lifted = max(scene.deepest + drawn, 0.0)
    near = scene.profile - scene.deepest <= REACH * scene.delta_n + drawn + sinks * lifted
    if not near.any():
        return int(scene.profile.argmin()), 1
    first, last = np.flatnonzero(near)[[0, -1]]
    return int(first), int(last - first + 1)
