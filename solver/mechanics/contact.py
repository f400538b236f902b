"""The nodes that can interact: their tractions and tangents, and the layer's response to them."""

from functools import cached_property

import numpy as np

from . import cohesive_law
from .layer import Convolution, Modes

MARGIN = 1e-3  # delta_n: a node becomes active, or inactive, once so far beyond the edge of the window


class Contact:
    """The patch of `size` neighbouring nodes from node `first` on; counts its force evaluations.

    Nodes outside carry no traction; their displacements follow from the patch (`whole`). A flat's patch of one node is
    `uniform`: that node stands for all, and the cell has `count` = 1 node, else `nodes`. Buffers belong to this object:
    not for use by two threads. `watch()` is called at every evaluation, and may raise to end the increment in hand.

    Attributes: modes of the layer; cell: those that the `count` nodes show.
    """

    def __init__(self, scene, first, size):
        self.scene, self.first, self.size, self.nodes = scene, first, size, scene.nodes
        self.part = slice(first, first + size)
        self.profile = np.ascontiguousarray(scene.profile[self.part])
        self.window = scene.window_n * scene.delta_n
        self.law, self.work = cohesive_law.law_constants(scene), np.empty((cohesive_law.WORK, size))
        self.uniform = size == 1 and scene.surface == "flat"
        self.count = 1 if self.uniform else scene.nodes
        self.modes, self.cell = Modes.of(scene), Modes.of(scene, self.count)
        self._layer = Convolution(self.cell, size)
        self.covers_cell = size == self.count
        self.evaluations, self.watch = 0, None

    def evaluated(self):
        """One more force evaluation; raises what `watch` raises."""
        self.evaluations += 1
        if self.watch:
            self.watch()

    def response(self, u, active):
        """C T(u), (2, size) nm, of u (2, size) nm: one force evaluation; a buffer, valid until the next."""
        self.evaluated()
        self.fill(u, active, self._layer.field)
        self._layer.apply()
        return self._layer.product

    @property
    def last_traction(self):
        """T (2, size) of the last `response`, GPa; its buffer."""
        return self._layer.field

    def traction(self, u, active):
        """T(u), (2, size) GPa; a new array."""
        return self.fill(u, active, np.empty((2, self.size)))

    def fill(self, u, active, out):
        """The same written to `out`, and returned."""
        cohesive_law.tractions(u, self.profile, active, self.law, self.work, out)
        return out

    def pressure(self, T_z):
        """Mean over the cell, GPa, of normal tractions (size,) GPa."""
        return float(T_z.sum()) / self.count

    def tangents(self, u, active):
        """dT/du of every node, rows as in `cohesive_law.tangents`, (4, size) GPa/nm; a new array."""
        tangents = np.empty((4, self.size))
        cohesive_law.tangents(u, self.profile, active, self.law, self.work, tangents)
        return tangents

    def product(self, tangents, w):
        """(C dT/du w nm, dT/du w GPa), (2, size) each, buffers; counts as a force evaluation, without exponentials."""
        self._layer.field[:] = 0.0
        cohesive_law.add_product(tangents, w, self._layer.field)
        return self.comply(self._layer.field), self._layer.field

    def comply(self, T):
        """C T, (2, size) nm, of T (2, size) GPa; a buffer; counts as a force evaluation, without exponentials."""
        self.evaluated()
        self._layer.field[:] = T
        self._layer.apply()
        return self._layer.product

    def within_window(self, u):
        """Nodes whose gap lies within the interaction window, bool (size,)."""
        return self.profile + u[1] <= self.window

    def admitted(self, u, active, settled=None):
        """`active` itself, or a new set if nodes lie on the other side of the window's edge by more than MARGIN.

        settled (bool (size,), optional): nodes that stay as they are.
        """
        beyond = self.profile + u[1] - self.window
        changed = np.where(active, beyond, -beyond) > MARGIN * self.scene.delta_n
        if settled is not None:
            changed &= ~settled
        return active ^ changed if changed.any() else active

    def crowded(self, active):
        """Whether an active node stands at an end of the patch, so that its neighbours outside may interact as well."""
        return not self.covers_cell and bool(active[0] or active[-1])

    def overlooked(self, u, active, height):
        """Whether a node outside the patch has come within the window; looked at only where summits stand outside.

        u: (2, size) nm in equilibrium with the top at U_z = height, nm.
        """
        if not self._summits_outside:
            return False
        gap = self.scene.profile + height + self.whole(self.traction(u, active))[1]
        gap[self.part] = np.inf
        return bool(gap.min() <= self.window)

    @cached_property
    def _summits_outside(self):
        """Whether the gap has minima outside the patch, where nodes may touch before those at its ends do."""
        slopes = np.diff(self.scene.profile)
        last = self.first + self.size - 1
        return not self.covers_cell and bool((slopes[: self.first] > 0.0).any() or (slopes[last:] < 0.0).any())

    @cached_property
    def _spread(self):
        return Convolution(self.modes, self.nodes)

    def whole(self, traction):
        """C T on every node of the cell, (2, nodes) nm, for T (2, size) GPa; a buffer."""
        self._spread.field[:, self.part] = traction
        self._spread.apply()
        return self._spread.product

    def wider(self):
        """The Contact of a patch wider by half or more; of the whole cell if that reaches its ends, or if `uniform`."""
        more = max(16, self.size // 4)
        low, high = self.first - more, self.first + self.size + more
        whole = self.uniform or low < 0 or high > self.nodes
        first, size = (0, self.nodes) if whole else (low, high - low)
        wide = Contact(self.scene, first, size)
        wide.evaluations, wide.watch = self.evaluations, self.watch
        return wide


def patch(scene, bulge):
    """(first, size) of a run's first patch: from the first to the last node that may come within the window.

    These have a gap up to `bulge` delta_n beyond the window at the full indentation; if none has, the lowest node.
    """
    profile = scene.profile
    near = np.flatnonzero(profile - scene.delta <= (scene.window_n + bulge) * scene.delta_n)
    if near.size == 0:
        return int(profile.argmin()), 1
    return int(near[0]), int(near[-1] - near[0] + 1)
