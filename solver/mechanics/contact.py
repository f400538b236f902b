"""The nodes that can interact: their tractions and tangents, and the layer's response to them."""

import numpy as np
from numba import njit

from . import cohesive_law
from .layer import Convolution, Modes, UniformMode

MARGIN = 1e-3  # delta_n: a node becomes active, or inactive, once so far beyond the edge of the window
LOOK = 16  # force evaluations between two calls of `watch`
EDGE = 2  # nodes at each end of a patch: once one of them is active, the patch is too narrow


class Contact:
    """The patch of `size` neighbouring nodes from node `first` on; counts its force evaluations.

    Nodes outside carry no traction; their displacements follow from the patch (`run.summary.whole_surface`). A flat's
    patch of one node is `uniform`: that node stands for all. normal_only: tangential tractions are zero throughout.
    Buffers belong to this object: not for use by two threads. `watch()` is called every LOOK evaluations, and may raise
    to end the increment in hand.
    """

    def __init__(self, scene, first, size, normal_only=False):
        self.scene, self.first, self.size = scene, first, size
        self.profile = np.ascontiguousarray(scene.profile[first : first + size])
        self.window = scene.window_n * scene.delta_n
        self.law = cohesive_law.law_constants(scene)
        self.modes, self.nodes, self.normal_only = Modes.of(scene), scene.nodes, normal_only
        self.uniform = size == 1 and scene.surface == "flat"
        modes = self.modes.compliance
        self._layer = UniformMode(modes) if self.uniform else Convolution(modes, scene.nodes, size, normal_only)
        self.covers_cell = self.uniform or size == scene.nodes
        self._summits_outside = not self.covers_cell and _summits_outside(scene.profile, first, size)
        self._whole = None  # the layer's response over all nodes, once `overlooked` needs it
        self.work = np.empty((cohesive_law.WORK, size))
        self.evaluations, self.watch = 0, None

    def count(self):
        """One more force evaluation; raises what `watch` raises."""
        self.evaluations += 1
        if self.watch is not None and self.evaluations % LOOK == 0:
            self.watch()

    def response(self, u, active):
        """C T(u), (2, size) nm, of u (2, size) nm: one force evaluation; a buffer, valid until the next."""
        self.count()
        cohesive_law.tractions(u, self.profile, active, self.law, self.work, self._layer.field, self.size)
        self._layer.apply()
        return self._layer.product

    @property
    def last_traction(self):
        """T (2, size) of the last `response`, GPa; its buffer."""
        return self._layer.field

    def traction(self, u, active):
        """T(u), (2, size) GPa; a new array."""
        out = np.empty((2, self.size))
        cohesive_law.tractions(u, self.profile, active, self.law, self.work, out, self.size)
        return out

    def pressure(self, traction):
        """Mean of T_z over the cell, GPa, of T (2, size) GPa."""
        return float(traction[1].sum()) / (1 if self.uniform else self.nodes)

    def tangents(self, u, active):
        """dT/du of every node, rows as in `cohesive_law.tangents`, (4, size) GPa/nm; a new array."""
        tangents = np.empty((4, self.size))
        cohesive_law.tangents(u, self.profile, active, self.law, self.work, tangents)
        return tangents

    def product(self, tangents, w):
        """(C dT/du w nm, dT/du w GPa), (2, size) each, buffers; counts as a force evaluation, without exponentials."""
        self.count()
        _tangent_product(tangents, w, self._layer.field)
        self._layer.apply()
        return self._layer.product, self._layer.field

    def shifted(self, sigma):
        """The Convolution with (I + sigma C)^-1 on the patch; sigma: GPa/nm."""
        return Convolution(self.modes.shifted(sigma), self.nodes, self.size)

    def within_window(self, u):
        """Nodes whose gap lies within the interaction window, bool (size,)."""
        return self.profile + u[1] <= self.window

    def admitted(self, u, active, settled=None):
        """`active` itself, or a new set if nodes lie on the other side of the window's edge by more than MARGIN.

        settled (bool (size,), optional): nodes that stay as they are.
        """
        margin = MARGIN * self.scene.delta_n
        if not _crossed(u, self.profile, active, self.window, margin):
            return active
        edge = self.profile + u[1] - self.window
        changed = np.where(active, edge > margin, edge < -margin)
        if settled is not None:
            changed &= ~settled
        return active ^ changed if changed.any() else active

    def crowded(self, active):
        """Whether an active node stands at an end of the patch, so that its neighbours outside may interact as well."""
        return not self.covers_cell and bool(active[:EDGE].any() or active[-EDGE:].any())

    def overlooked(self, u, active, height):
        """Whether a node outside the patch has come within the window; looked at only where summits stand outside.

        u: (2, size) nm in equilibrium with the top at U_z = height, nm.
        """
        if not self._summits_outside:
            return False
        part = slice(self.first, self.first + self.size)
        gap = self.scene.profile + height + self.whole(self.traction(u, active))[1]
        gap[part] = np.inf
        return bool(gap.min() <= self.window)

    def whole(self, traction):
        """C T on every node of the cell, (2, nodes) nm, for T (2, size) GPa; a buffer."""
        if self._whole is None:
            self._whole = Convolution(self.modes.compliance, self.nodes, self.nodes)
        self._whole.field[:, self.first : self.first + self.size] = traction
        self._whole.apply()
        return self._whole.product

    def wider(self):
        """The Contact of a patch wider by half or more; of the whole cell if that reaches its ends, or if `uniform`."""
        more = max(16, self.size // 4)
        low, high = self.first - more, self.first + self.size + more
        whole = self.uniform or low < 0 or high > self.nodes
        first, size = (0, self.nodes) if whole else (low, high - low)
        wide = Contact(self.scene, first, size, normal_only=self.normal_only)
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


def _summits_outside(profile, first, size):
    """Whether the gap has minima outside a patch, where nodes may touch before those at its ends do."""
    before, after = profile[: first + 1], profile[first + size - 1 :]
    return bool((np.diff(before) > 0.0).any() or (np.diff(after) < 0.0).any())


@njit(cache=True, nogil=True)
def _crossed(u, profile, active, window, margin):
    for i in range(profile.size):
        edge = profile[i] + u[1, i] - window
        if edge > margin if active[i] else edge < -margin:
            return True
    return False


@njit(cache=True, nogil=True)
def _tangent_product(tangents, w, out):
    """out = dT/du w, (2, size)."""
    for i in range(w.shape[1]):
        out[0, i] = tangents[0, i] * w[0, i] + tangents[1, i] * w[1, i]
        out[1, i] = tangents[2, i] * w[0, i] + tangents[3, i] * w[1, i]
