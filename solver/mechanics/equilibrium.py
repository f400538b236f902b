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
    """The Contact driven along a Loading."""

    def __init__(self, contact, loading):
        scene = contact.scene
        self.contact, self.loading = contact, loading
        self.unit, self.tolerance = min(scene.delta_n, scene.delta_t), scene.tolerance
        self.nodes = contact.size  # m
        self.size, self.place = 2 * self.nodes, (contact.first, contact.size)
        self.direction = np.repeat(np.array(loading.direction, float), self.nodes)
        mode = min(max(1, round(scene.nodes / self.nodes)), scene.nodes // 2)
        self._stiff = STIFF / float(contact.modes.compliance[1, mode])
        self._smoother = lru_cache(maxsize=8)(self._new_smoother)
        self._surface = None

    @property
    def evaluations(self):
        return self.contact.evaluations

    def surface(self, v):
        """u (2, m) nm, a view of v."""
        return v.reshape(2, self.nodes)

    def top(self, v, s):
        """(U_x, U_z) of the top at load s, nm."""
        return self.loading.at(s)

    def undeformed(self, s):
        """The unknowns of a layer that nothing acts on."""
        return np.repeat(np.array(self.loading.at(s)), self.nodes)

    def residual(self, v, active, s, out):
        """Fill out (size,) with R, nm; returns its largest magnitude."""
        return self.residual_under(v, active, self.loading.at(s), out)

    def residual_under(self, v, active, top, out):
        """The same under a top displaced by (U_x, U_z), nm."""
        u = self.surface(v)
        return _residual(u, self.contact.response(u, active), *top, out)

    def traction(self, v, active):
        """T (2, m), GPa; a new array."""
        return self.contact.traction(self.surface(v), active)

    def active_of(self, v, s):
        """Nodes within the interaction window, bool (m,)."""
        return self.contact.within_window(self.surface(v))

    def admitted(self, v, active, settled=None):
        """As `Contact.admitted`."""
        return self.contact.admitted(self.surface(v), active, settled)

    def smoother(self, v, active):
        """r -> (I + sigma C)^-1 r, sigma the interface's stiffness: weakens long waves, which it pins; None if soft."""
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

    def inverse(self, v, active):
        """The DenseInverse, or None where it is singular or takes longer than iterations."""
        if self.contact.uniform or not 0 < active.sum() <= MOST:
            return None
        try:
            return DenseInverse(self.contact, self.surface(v), active)
        except np.linalg.LinAlgError:
            return None

    def oriented(self, mode):
        """A mode with the sign in which the surface, on the whole, moves towards the substrate, as on approach."""
        return -mode if self.surface(mode)[1].sum() > 0.0 else mode.copy()

    def translated(self, v, distance):
        """The same state moved on along x by a distance (nm), a whole number of sites; a new array."""
        return v + distance * self.direction

    def crowded(self, v, active, s):
        """Whether a node outside the patch may interact."""
        return self.crowded_under(v, active, self.loading.at(s)[1])

    def crowded_under(self, v, active, height):
        """The same under a top at U_z = height, nm."""
        return self.contact.crowded(active) or self.contact.overlooked(self.surface(v), active, height)

    def grown(self, v, active, s):
        """(the problem on a wider patch, v, active there); new nodes are displaced by the tractions of the old ones.

        From one node for all: the problem of all nodes.
        """
        return self.grown_under(v, active, self.loading.at(s))

    def grown_under(self, v, active, top):
        """The same under a top displaced by (U_x, U_z), nm."""
        contact, wide = self.contact, Equilibrium(self.contact.wider(), self.loading)
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
