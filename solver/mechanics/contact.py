"""The nodes that can interact: their tractions and tangents, and the layer's response to them."""

from functools import cached_property

import numpy as np

from . import cohesive_law
from .layer import Convolution, Modes

REACH = 25.0  # delta_n: farther apart, a spring pulls with less than 25 exp(-25) = 3.5e-10 of phi_n/delta_n
# Nodes that a patch gains at each end, at least, and part of its size. As each growth repeats an increment, patches
# grow by half or more: four times make one five times as large.
LEAST_GROWTH, GROWTH = 16, 0.25


class Contact:
    """The patch of `size` neighbouring nodes from node `first` on; counts its force evaluations.

    Nodes outside carry no traction; the tractions of the patch displace them. A flat's patch of one node is
    `uniform`: this node represents all, and the cell has `count` = 1 node, else as many as the scene. `observe()` is
    called at every evaluation, in a motion with (surface, y, load); it may raise to end the increment. Owns its
    buffers: two threads need two objects.

    Attributes: part, the slice of the patch in the cell; modes of the layer; cell: those that `count` nodes can show.
    """

    def __init__(self, scene, first, size):
        self.scene, self.first, self.size, self.nodes = scene, first, size, scene.nodes
        self.part = slice(first, first + size)
        self.profile = np.ascontiguousarray(scene.profile[self.part])
        self.reach = REACH * scene.delta_n
        self.law, self._work = cohesive_law.law_constants(scene), np.empty((cohesive_law.WORK, size))
        self.uniform = size == 1 and scene.surface == "flat"
        self.count = 1 if self.uniform else scene.nodes
        self.covers_cell = size == self.count
        self.modes, self.cell = Modes.of(scene), Modes.of(scene, self.count)
        self._layer = Convolution(self.cell, size)
        self.evaluations, self.observe = 0, None

    def evaluated(self, *moving) -> None:
        """Count a force evaluation, with the state of a motion; raises what `observe` raises."""
        self.evaluations += 1
        if self.observe:
            self.observe(*moving)

    def response(self, u) -> np.ndarray:
        """C T(u), (2, size) nm, of u (2, size) nm: one force evaluation; a buffer, valid until the next."""
        self.evaluated()
        self.traction(u, self._layer.field)
        self._layer.apply()
        return self._layer.product

    @property
    def last_traction(self) -> np.ndarray:
        """T (2, size) of the last `response`, GPa; its buffer."""
        return self._layer.field

    def traction(self, u, out=None) -> np.ndarray:
        """T(u), (2, size) GPa: `out`, or a new array."""
        out = np.empty((2, self.size)) if out is None else out
        cohesive_law.tractions(u, self.profile, self.law, self._work, out)
        return out

    def tangents(self, u) -> np.ndarray:
        """dT/du of every node, rows as in `cohesive_law.tangents`, (4, size) GPa/nm; a new array."""
        tangents = np.empty((4, self.size))
        cohesive_law.tangents(u, self.profile, self.law, self._work, tangents)
        return tangents

    def pressure(self, T_z) -> float:
        """Mean over the cell, GPa, of normal tractions (size,) GPa."""
        return float(T_z.sum()) / self.count

    def comply(self, T) -> np.ndarray:
        """C T, (2, size) nm, of T (2, size) GPa; a buffer; counts as a force evaluation, without exponentials."""
        self.evaluated()
        self._layer.field[:] = T
        self._layer.apply()
        return self._layer.product

    def distance(self, u) -> float:
        """The smallest gap, nm."""
        return float((self.profile + u[1]).min())

    def crowded(self, u) -> bool:
        """Whether an end of the patch lies within REACH, so that its neighbours outside may interact as well."""
        return not self.covers_cell and bool((self.profile + u[1])[[0, -1]].min() <= self.reach)

    @cached_property
    def summits_outside(self) -> bool:
        """Whether the gap has minima outside the patch, where nodes may touch before those at its ends do."""
        slopes = np.diff(self.scene.profile)
        last = self.first + self.size - 1
        return not self.covers_cell and bool((slopes[: self.first] > 0.0).any() or (slopes[last:] < 0.0).any())

    def overlooked(self, u_z) -> bool:
        """Whether a node outside the patch has come within REACH; u_z: displacement of all nodes, (nodes,) nm."""
        gap = self.scene.profile + u_z
        gap[self.part] = np.inf
        return bool(gap.min() <= self.reach)

    def wider(self) -> "Contact":
        """The Contact of a patch wider by half or more; of the whole cell if that reaches its ends, or if `uniform`."""
        more = max(LEAST_GROWTH, int(GROWTH * self.size))
        low, high = self.first - more, self.first + self.size + more
        whole = self.uniform or low < 0 or high > self.nodes
        wide = Contact(self.scene, 0, self.nodes) if whole else Contact(self.scene, low, high - low)
        wide.evaluations, wide.observe = self.evaluations, self.observe
        return wide


def patch(scene, bulge) -> tuple[int, int]:
    """(first, size) of a run's first patch: from the first to the last node that may come within REACH.

    These have a gap up to `bulge` delta_n beyond it at the full indentation; if none has, the lowest node.
    """
    profile = scene.profile
    near = np.flatnonzero(profile - scene.delta <= (REACH + bulge) * scene.delta_n)
    if near.size == 0:
        return int(profile.argmin()), 1
    return int(near[0]), int(near[-1] - near[0] + 1)
