"""The contact as a problem R(v; s) = 0 at a given height of the top, under the contract of `continuation.problem`.

Unknowns: the displacement of the patch, v = (u_x, u_z), nm. Residual: R = U(s) + C T(u) - u, nm. `load_control` adds
an unknown: the height of the top under a held load.
"""

import numpy as np
from numba import njit

from .dense import MOST, DenseInverse
from .linearised import Linearised
from .surface import Surface

# stiffness of springs over that of the layer against one node, from which single nodes may rest in several places
LOOSE = 2.0


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
    def evaluations(self) -> int:
        """Force evaluations so far, of the contact."""
        return self.contact.evaluations

    @property
    def uniform(self) -> bool:
        """Whether one node stands for all."""
        return self.contact.uniform

    def on(self, contact) -> "Equilibrium":
        """The same problem on another patch."""
        return Equilibrium(contact, self.loading)

    def surface(self, v) -> np.ndarray:
        """u (2, m) nm, a view of v."""
        return v[: 2 * self.nodes].reshape(2, self.nodes)

    def top(self, v, s) -> tuple[float, float]:
        """(U_x, U_z) of the top at load s, nm."""
        return self.loading.at(s)

    def undeformed(self, s) -> np.ndarray:
        """The unknowns (size,), nm, of a layer without tractions at load s, nm."""
        return np.repeat(np.array(self.loading.at(s)), self.nodes)

    def residual(self, v, active, s, out) -> float:
        """Fill out (size,) with R, nm; returns its largest magnitude. One force evaluation."""
        displaced_x, displaced_z = self.contact.response(self.surface(v), active)
        return _residual(v, displaced_x, displaced_z, *self.top(v, s), out)

    def traction(self, v, active) -> np.ndarray:
        """T (2, m), GPa; a new array."""
        return self.contact.traction(self.surface(v), active)

    def everywhere(self, v, active, s) -> np.ndarray:
        """Displacement of all nodes of the cell, (2, contact.count) nm; a new array.

        The tractions of the patch displace the nodes outside. Those of the patch stay where v has them: where v is not
        quite an equilibrium, a tenth of the difference may decide which equilibrium a transient reaches.
        """
        out = self.contact.whole(self.traction(v, active)) + np.array(self.top(v, s))[:, None]
        out[:, self.contact.part] = self.surface(v)
        return out

    def active(self, v, s, before=None, settled=None) -> np.ndarray:
        """Nodes within the interaction window, bool (m,); given those `before`, as `Contact.admitted`."""
        u = self.surface(v)
        return self.contact.within_window(u) if before is None else self.contact.admitted(u, before, settled)

    def preconditioner(self, v, active):
        """A function close to the inverse of -dR/dv, (size,) nm each; None if forming it takes too long or fails."""
        if not 0 < active.sum() <= MOST:
            return None
        try:
            return DenseInverse(self.contact, self.surface(v), active)
        except np.linalg.LinAlgError:
            return None

    def grown(self, v, active, s, hidden=False):
        """(the problem on a wider patch, v, active there) where a node outside may interact, else None.

        hidden: grow in any case, as a wave grows that one node for all cannot show.
        """
        contact, more = self.contact, hidden or self.contact.crowded(active)
        if not more and not contact.summits_outside:
            return None
        u = self.everywhere(v, active, s)
        if not more and not contact.overlooked(u[1]):
            return None
        wide, among = contact.wider(), np.zeros(contact.count, bool)
        among[contact.part] = active
        u, among = np.broadcast_to(u, (2, wide.nodes)), np.broadcast_to(among, wide.nodes)
        return self.on(wide), np.append(u[:, wide.part], v[2 * self.nodes :]), among[wide.part].copy()

    def sites(self, v, w) -> float:
        """By how many sites of the lattice the node that moves farthest along it lies elsewhere in w than in v."""
        return float(np.abs((w - v)[: self.nodes]).max()) / self.contact.scene.spacing

    def alike(self, v) -> bool:
        """Whether all nodes are alike in v, to the accuracy of a followed state."""
        flat = self.contact.scene.surface == "flat"
        return flat and bool(np.ptp(self.surface(v), axis=1).max() <= 1e-5 * self.unit)

    def loose(self, v, active) -> bool:
        """Whether the springs of a node are LOOSE times as stiff as the layer against that node alone."""
        stiffest = np.abs(self.contact.tangents(self.surface(v), active)[0]).max()
        return bool(stiffest * self.contact.modes.kernels[0, 0] > LOOSE)

    def linearised(self, v, active) -> Linearised:
        """The Linearised at an equilibrium."""
        return self.disturbed(self.motion(), v, active)

    def motion(self) -> Surface:
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
