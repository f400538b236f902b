"""The discretised contact: the residual U + C T(u) - u on the patch of nodes that can interact."""

import numpy as np
from numba import njit

from . import np1
from .layer import Convolution, Modes, UniformMode

MARGIN = 1e-3  # of delta_n, by which a node must cross the edge of the window to be let in or out
EDGE = 2  # nodes at each end of a patch that must stay inactive


class Contact:
    """One scene on `size` neighbouring nodes from node `first` on; counts its force evaluations.

    uniform: one node that stands for all; normal_only: without tangential traction.

    Nodes outside the patch carry no traction; where they are follows from the patch (`loadpath.whole_surface`).
    Buffers belong to this object: not for use by two threads.
    """

    def __init__(self, scene, first, size, uniform=False, normal_only=False):
        self.scene, self.first, self.size = scene, first, size
        self.profile = np.ascontiguousarray(scene.profile[first : first + size])
        self.window = scene.window_n * scene.delta_n
        self.lowest = float(self.profile.min())
        self.law = np1.law_constants(scene)
        self.modes, self.nodes, self.normal_only = Modes.of(scene), scene.nodes, normal_only
        modes = self.modes.compliance
        self.compliance = UniformMode(modes) if uniform else Convolution(modes, scene.nodes, size, normal_only)
        self.alone = uniform or size == scene.nodes
        self.held = False  # whether the top is one more column of u (`held.Held`)
        self._others = not self.alone and _summits_outside(scene.profile, first, size)
        self._whole = None  # the layer's response over all nodes, once `overlooked` needs it
        self.mirror = False  # whether u is its own mirror image: then half the tractions tell the rest
        self.work = np.empty((np1.WORK, size))
        self.evaluations = 0

    def undeformed(self, load):
        """Displacement (2, size) of a layer that nothing acts on, at load (U_x, U_z), nm."""
        return np.repeat(np.array(load)[:, None], self.size, axis=1)

    def residual(self, u, active, load, out):
        """Fill out (2, size) with U + C T(u) - u, nm, at load (U_x, U_z); returns its largest magnitude."""
        return _residual(u, self.response(u, active), load[0], load[1], out)

    def response(self, u, active):
        """C T(u), (2, size) nm: one force evaluation; a buffer, valid until the next. `mirror` mirrors u."""
        self.evaluations += 1
        known = self.size
        if self.mirror:  # round-off breaks the symmetry of u, and the residual must be that of the u that is kept
            u = u if u.flags.writeable else u.copy()  # a frame's u has been mirrored already
            np1.reflect(u, self.size)
            known -= self.size // 2
        np1.tractions(u, self.profile, active, self.law, self.work, self.compliance.field, known)
        if self.mirror:
            np1.reflect(self.compliance.field, self.size)
        self.compliance.apply()
        return self.compliance.product

    def traction(self):
        """Traction of the last evaluation, GPa, (2, size); a copy."""
        return self.compliance.field.copy()

    def stiffness(self, u, active):
        """The largest restoring stiffness of the interface in u, GPa/nm."""
        tangents = self.tangents(u, active)
        return max(0.0, -float(tangents[0].min()), -float(tangents[3].min()))

    def tangents(self, u, active):
        """dT/du of every node, rows as in `np1.tangents`, (4, size) GPa/nm."""
        tangents = np.empty((4, self.size))
        np1.tangents(u, self.profile, active, self.law, self.work, tangents)
        return tangents

    def shifted(self, sigma):
        """The product with (I + sigma C)^-1 on the patch; sigma: GPa/nm."""
        return Convolution(self.modes.shifted(sigma), self.nodes, self.size)

    def within_window(self, u):
        """Nodes whose gap lies within the interaction window, bool (size,)."""
        return self.profile + u[1] <= self.window

    def admitted(self, u, active, settled=None):
        """`active` itself, or a new set if nodes crossed the edge of the window by more than MARGIN.

        settled (bool (size,), optional): nodes that must stay as they are.
        """
        margin = MARGIN * self.scene.delta_n
        if not _crossed(u, self.profile, active, self.window, margin):
            return active
        edge = self.profile + u[1] - self.window
        changed = np.where(active, edge > margin, edge < -margin)
        if settled is not None:
            changed &= ~settled
        return active ^ changed if changed.any() else active

    def settle(self, solve, u, active):
        """The active set with which solve(active) -> bool leaves u consistent; None if solve fails.

        Nodes that crossed the edge of the window are let in or out and the solve repeated; each node may change once,
        so that this ends (where a node's entry pushes it out again, no set is consistent).
        """
        settled = np.zeros(self.size, bool)
        while True:
            if not solve(active):
                return None
            again = self.admitted(u, active, settled)
            if again is active:
                return active
            settled |= again != active
            active = again

    def crowded(self, active):
        """Whether an active node stands at the end of the patch, so that its neighbours outside may act as well."""
        return not self.alone and bool(active[:EDGE].any() or active[-EDGE:].any())

    def overlooked(self, traction, height):
        """Whether a node outside the patch has come within the window, where other summits stand there.

        traction: (2, size) GPa on the patch, in equilibrium with the top at U_z = height, nm.
        """
        if not self._others:
            return False
        if self._whole is None:
            self._whole = Convolution(self.modes.compliance, self.nodes, self.nodes)
        part = slice(self.first, self.first + self.size)
        self._whole.field[:, part] = traction
        self._whole.apply()
        gap = self.scene.profile + height + self._whole.product[1]
        gap[part] = np.inf
        return bool(gap.min() <= self.window)


def patch(scene, bulge):
    """(first, size): nodes that come within the window at the deepest indentation, plus a gap of `bulge` delta_n.

    One range from the first to the last of them, with all that lies between; the lowest node if there are none.
    """
    profile = scene.profile
    near = np.flatnonzero(profile - scene.delta <= (scene.window_n + bulge) * scene.delta_n)
    if near.size == 0:
        return int(profile.argmin()), 1
    return int(near[0]), int(near[-1] - near[0] + 1)


def _summits_outside(profile, first, size):
    """Whether the gap outside a patch does not just grow away from it, so that the patch's ends cannot tell for it."""
    before, after = profile[: first + 1], profile[first + size - 1 :]
    return bool((np.diff(before) > 0.0).any() or (np.diff(after) < 0.0).any())


def wider(scene, first, size):
    """(first, size) of a patch half as wide again; the whole cell once that is reached."""
    more = max(16, size // 4)
    low, high = first - more, first + size + more
    return (0, scene.nodes) if low < 0 or high > scene.nodes else (low, high - low)


@njit(cache=True, nogil=True)
def _residual(u, g, load_x, load_z, out):
    largest = 0.0
    for i in range(u.shape[1]):
        out[0, i] = load_x + g[0, i] - u[0, i]
        out[1, i] = load_z + g[1, i] - u[1, i]
        largest = max(largest, abs(out[0, i]), abs(out[1, i]))
    return largest


@njit(cache=True, nogil=True)
def _crossed(u, profile, active, window, margin):
    for i in range(profile.size):
        edge = profile[i] + u[1, i] - window
        if edge > margin if active[i] else edge < -margin:
            return True
    return False
