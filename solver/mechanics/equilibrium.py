"""The contact as a problem R(v; s) = 0 at given height of the top, under the contract of `continuation.problem`.

Unknowns: the displacement of the patch, v = (u_x, u_z), nm. Residual: R = U(s) + C T(u) - u, nm. Under a held load
`load_control` wraps this problem.
"""

from functools import lru_cache
from math import ceil, log2

import numpy as np
from numba import njit

from .dense import MOST, DenseInverse
from .linearised import Linearised
from .surface import Surface

STIFF = 50.0  # interface stiffness over that of the softest wave on the patch, from which on residuals are smoothed


class Equilibrium:
    """The Contact driven along a Loading; attributes as of `continuation.problem.Problem`."""

    def __init__(self, contact, loading):
        scene = contact.scene
        self.contact, self.loading = contact, loading
        self.unit, self.tolerance = min(scene.delta_n, scene.delta_t), scene.tolerance
        self.nodes = contact.size  # m
        self.size = 2 * self.nodes
        self.direction = np.repeat(np.array(loading.direction, float), self.nodes)
        mode = min(max(1, round(scene.nodes / self.nodes)), scene.nodes // 2)
        self._stiff = STIFF / float(contact.modes.compliance[1, mode])
        self._smoother = lru_cache(maxsize=8)(self._new_smoother)
        self._surface = None

    @property
    def evaluations(self):
        """Force evaluations so far, of the contact."""
        return self.contact.evaluations

    def surface(self, v):
        """u (2, m) nm, a view of v."""
        return v.reshape(2, self.nodes)

    def top(self, v, s):
        """(U_x, U_z) of the top at load s, nm."""
        return self.loading.at(s)

    def undeformed(self, s):
        """The unknowns (size,), nm, of a layer that nothing acts on at load s, nm."""
        return np.repeat(np.array(self.loading.at(s)), self.nodes)

    def residual(self, v, active, s, out):
        """Fill out (size,) with R, nm; returns its largest magnitude. One force evaluation."""
        return self.residual_under(v, active, self.loading.at(s), out)

    def residual_under(self, v, active, top, out):
        """The same under a top displaced by (U_x, U_z), nm."""
        u = self.surface(v)
        return _residual(u, self.contact.response(u, active), *top, out)

    def traction(self, v, active):
        """T (2, m), GPa; a new array."""
        return self.contact.traction(self.surface(v), active)

    def active(self, v, s, before=None, settled=None):
        """Nodes within the interaction window, bool (m,); given those `before`, as `Contact.admitted`."""
        u = self.surface(v)
        return self.contact.within_window(u) if before is None else self.contact.admitted(u, before, settled)

    def preconditioner(self, v, active, sharp=False):
        """A function close to the inverse of -dR/dv, (size,) nm each, or None where it would not pay.

        r -> (I + sigma C)^-1 r, sigma the interface's stiffness, weakens long waves, which a stiff interface pins;
        sharp: the DenseInverse, unless it is singular or takes longer than iterations.
        """
        if sharp:
            return self._inverse(v, active)
        tangents = self.contact.tangents(self.surface(v), active)
        stiffness = max(0.0, -float(tangents[0].min()), -float(tangents[3].min()))
        return self._smoother(ceil(log2(0.5 * stiffness))) if stiffness > self._stiff else None

    def _new_smoother(self, power):
        shifted = self.contact.shifted(2.0**power)

        def smooth(r):
            shifted.field[:] = r.reshape(2, -1)
            shifted.apply()
            return shifted.product.reshape(-1).copy()

        return smooth

    def _inverse(self, v, active):
        if self.contact.uniform or not 0 < active.sum() <= MOST:
            return None
        try:
            return DenseInverse(self.contact, self.surface(v), active)
        except np.linalg.LinAlgError:
            return None

    def grown(self, v, active, s, hidden=False):
        """(the problem on a wider patch, v, active there) where a node outside may interact, else None.

        New nodes are displaced by the tractions of the old ones. hidden: a wave grows that one node for all cannot
        show, so that all nodes are needed.
        """
        return self.grown_under(v, active, self.loading.at(s), hidden)

    def grown_under(self, v, active, top, hidden=False):
        """The same under a top displaced by (U_x, U_z), nm."""
        contact = self.contact
        if not (hidden or contact.crowded(active) or contact.overlooked(self.surface(v), active, top[1])):
            return None
        wide = Equilibrium(contact.wider(), self.loading)
        if contact.uniform:
            return wide, np.repeat(v, wide.nodes), np.repeat(active, wide.nodes)
        u = contact.whole(self.traction(v, active)) + np.array(top)[:, None]
        part = slice(wide.contact.first, wide.contact.first + wide.nodes)
        inner = slice(contact.first - wide.contact.first, contact.first - wide.contact.first + self.nodes)
        u = u[:, part].copy()
        u[:, inner] = self.surface(v)
        wide_active = np.zeros(wide.nodes, bool)
        wide_active[inner] = active
        return wide, u.reshape(-1), wide_active

    def linearised(self, v, active):
        """The Linearised at an equilibrium."""
        return Linearised(self.motion(), v, active)

    def motion(self):
        """The Surface, whose rests are the equilibria of this problem."""
        if self._surface is None:
            self._surface = Surface(self)
        return self._surface


@njit(cache=True, nogil=True)
def _residual(u, g, load_x, load_z, out):
    largest, total, m = 0.0, 0.0, u.shape[1]
    for i in range(m):
        out[i] = load_x + g[0, i] - u[0, i]
        out[m + i] = load_z + g[1, i] - u[1, i]
        largest = max(largest, abs(out[i]), abs(out[m + i]))
        total += out[i] + out[m + i]
    return largest if np.isfinite(total) else np.inf  # a maximum passes over nan
