"""The contact as a problem R(v; s) = 0 at given height of the top, under the contract of `continuation.problem`.

Unknowns: the displacement of the patch, v = (u_x, u_z), nm. Residual: R = U(s) + C T(u) - u, nm. `load_control` adds
an unknown: the height of the top under a held load.
"""

import numpy as np
from numba import njit

from .dense import MOST, DenseInverse
from .linearised import Linearised
from .surface import Surface


class Equilibrium:
    """The Contact driven along a Loading; attributes as of `continuation.problem.Problem`."""

    dynamics, disturbed = Surface, Linearised  # the kinds of `motion` and `linearised`

    def __init__(self, contact, loading):
        scene = contact.scene
        self.contact, self.loading = contact, loading
        self.unit, self.tolerance = min(scene.delta_n, scene.delta_t), scene.tolerance
        self.nodes = contact.size  # m
        self.size = 2 * self.nodes
        self.direction = np.repeat(np.array(loading.direction, float), self.nodes)
        self._motion = None

    @property
    def evaluations(self):
        """Force evaluations so far, of the contact."""
        return self.contact.evaluations

    def on(self, contact):
        """The same problem on another patch."""
        return Equilibrium(contact, self.loading)

    def surface(self, v):
        """u (2, m) nm, a view of v."""
        return v[: 2 * self.nodes].reshape(2, self.nodes)

    def top(self, v, s):
        """(U_x, U_z) of the top at load s, nm."""
        return self.loading.at(s)

    def undeformed(self, s):
        """The unknowns (size,), nm, of a layer that nothing acts on at load s, nm."""
        return np.repeat(np.array(self.loading.at(s)), self.nodes)

    def residual(self, v, active, s, out):
        """Fill out (size,) with R, nm; returns its largest magnitude. One force evaluation."""
        displaced_x, displaced_z = self.contact.response(self.surface(v), active)
        return _residual(v, displaced_x, displaced_z, *self.top(v, s), out)

    def traction(self, v, active):
        """T (2, m), GPa; a new array."""
        return self.contact.traction(self.surface(v), active)

    def active(self, v, s, before=None, settled=None):
        """Nodes within the interaction window, bool (m,); given those `before`, as `Contact.admitted`."""
        u = self.surface(v)
        return self.contact.within_window(u) if before is None else self.contact.admitted(u, before, settled)

    def preconditioner(self, v, active):
        """A function close to the inverse of -dR/dv, (size,) nm each; None where a DenseInverse takes too long.

        Or where that is singular.
        """
        if not 0 < active.sum() <= MOST:
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
        contact, u, top = self.contact, self.surface(v), self.top(v, s)
        if not (hidden or contact.crowded(active) or contact.overlooked(u, active, top[1])):
            return None
        wide = contact.wider()
        if contact.uniform:
            u, active = np.repeat(u, wide.size, axis=1), np.repeat(active, wide.size)
        else:
            spread, among = (
                contact.whole(contact.traction(u, active)) + np.array(top)[:, None],
                np.zeros(wide.nodes, bool),
            )
            spread[:, contact.part], among[contact.part] = u, active
            u, active = spread[:, wide.part], among[wide.part]
        return self.on(wide), np.append(u, v[2 * self.nodes :]), active

    def linearised(self, v, active):
        """The Linearised at an equilibrium."""
        return self.disturbed(self.motion(), v, active)

    def motion(self):
        """The Surface, whose rests are the equilibria of this problem."""
        if self._motion is None:
            self._motion = self.dynamics(self)
        return self._motion


@njit(cache=True, nogil=True)
def _residual(v, displaced_x, displaced_z, top_x, top_z, out):
    largest, total, m = 0.0, 0.0, displaced_x.size
    for i in range(m):
        out[i] = top_x + displaced_x[i] - v[i]
        out[m + i] = top_z + displaced_z[i] - v[m + i]
        largest = max(largest, abs(out[i]), abs(out[m + i]))
        total += out[i] + out[m + i]
    return largest if np.isfinite(total) else np.inf  # a maximum passes over nan
