"""The contact as a problem R(v; s) = 0, under the contract of `continuation.problem`.

Unknowns: the displacement of the patch, v[:2 m] = (u_x, u_z), nm; under a held load also the height U_z of the top, the
last of 2 m + 1. Residual: R = U(s) + C T(u) - u, nm; for the top, `top_compliance` times (p - p_0), with p the mean of
T_z over the cell and p_0 the one held. That compliance merely turns a pressure into nm: the uniform mode's, or
delta_n^2/phi_n if that is more.

A held load is a dead weight: the top has no mass and bears no other force, so that the layer always carries p_0. In the
motion (`Surface`) the uniform normal mode then has no stiffness, and p_0 acts on it as a force.
"""

from functools import lru_cache
from math import ceil, log2

import numpy as np
from numba import njit

from ..continuation.state import PulledOff
from . import cohesive_law
from .dense import LIMITS as DENSE
from .dense import DenseInverse
from .disturbance import Disturbances, UniformDisturbance, uniform_growth
from .layer import transforms

UNSTABLE = 1e-6  # growth, 1/time, from which on a wave that one node for all cannot show counts as growing
STIFF = 50.0  # interface stiffness over that of the softest wave on the patch, from which on residuals are smoothed


class Equilibrium:
    """The Contact driven along a Loading: at given height of the top, or at the mean normal traction `pressure`."""

    def __init__(self, contact, loading, pressure=None):
        scene = contact.scene
        self.contact, self.loading, self.pressure = contact, loading, pressure
        self.unit, self.tolerance = min(scene.delta_n, scene.delta_t), scene.tolerance
        self.nodes = contact.size  # m
        self.size = 2 * self.nodes + (pressure is not None)
        self.direction = np.zeros(self.size)
        self.direction[: self.nodes] = loading.direction[0]
        if pressure is None:
            self.direction[self.nodes :] = loading.direction[1]
        self._along = np.zeros(self.size)
        self._along[: self.nodes] = loading.direction[0]
        self.top_compliance = max(float(contact.modes.compliance[1, 0]), scene.delta_n**2 / scene.phi_n)
        mode = min(max(1, round(scene.nodes / self.nodes)), scene.nodes // 2)
        self._stiff = STIFF / float(contact.modes.compliance[1, mode])
        self._smoother = lru_cache(maxsize=8)(self._new_smoother)
        self._surface, self._inverse = None, (None, None)
        self.place = contact.first, contact.size

    @property
    def evaluations(self):
        return self.contact.evaluations

    def surface(self, v):
        """u (2, m) nm, a view of v."""
        return v[: 2 * self.nodes].reshape(2, self.nodes)

    def top(self, v, s):
        """(U_x, U_z) of the top at load s, nm."""
        U_x, U_z = self.loading.at(s)
        return (U_x, U_z) if self.pressure is None else (U_x, float(v[-1]))

    def unknowns(self, u, U_z):
        """v of a surface u (2, m) under a top at U_z, nm; a new array."""
        return np.append(u.ravel(), () if self.pressure is None else U_z)

    def undeformed(self, s):
        """The unknowns of a layer that nothing acts on."""
        top = self.loading.at(s)
        return self.unknowns(np.repeat(np.array(top)[:, None], self.nodes, axis=1), top[1])

    def residual(self, v, active, s, out):
        """Fill out (size,) with R, nm; returns its largest magnitude."""
        u, (U_x, U_z) = self.surface(v), self.top(v, s)
        response = self.contact.response(u, active)
        worst = _residual(u, response, U_x, U_z, out)
        if self.pressure is not None:
            out[-1] = self.top_compliance * (self.contact.pressure(self.contact.last_traction) - self.pressure)
            worst = max(worst, abs(out[-1]))
        return worst

    def traction(self, v, active):
        """T (2, m), GPa; a new array."""
        return self.contact.traction(self.surface(v), active)

    def active_of(self, v, s):
        """Nodes within the interaction window; raises PulledOff if there are none and a tensile load is held."""
        active = self.contact.within_window(self.surface(v))
        if self.pressure is not None and self.pressure < 0.0 and not active.any():
            raise PulledOff(
                f"The contact has pulled off at U_x = {round(self.loading.at(s)[0], 6) + 0.0:g} nm: the motion that"
                f" began there under the held load L_bar = {self.pressure / self.contact.scene.E:.4g} led away from the"
                " surface; hold delta instead, or press harder"
            )
        return active

    def admitted(self, v, active, settled=None):
        """As `Contact.admitted`."""
        return self.contact.admitted(self.surface(v), active, settled)

    def smoother(self, v, active):
        """r -> (I + sigma C)^-1 r, sigma the interface's stiffness: weakens long waves, which it pins; None if soft."""
        tangents = self.contact.tangents(self.surface(v), active)
        stiffness = max(0.0, -float(tangents[0].min()), -float(tangents[3].min()))
        return self._smoother(ceil(log2(0.5 * stiffness))) if stiffness > self._stiff else None

    def _new_smoother(self, power):
        shifted, m = self.contact.shifted(2.0**power), 2 * self.nodes

        def smooth(r):
            smoothed = r.copy()
            shifted.field[:] = r[:m].reshape(2, -1)
            shifted.apply()
            smoothed[:m] = shifted.product.reshape(-1)
            return smoothed

        return smooth

    def tangent(self, v, active):
        """The function w -> dR/dv w, (size,) nm each; its products count as force evaluations."""
        contact, m = self.contact, 2 * self.nodes
        tangents = contact.tangents(self.surface(v), active)

        def product(w):
            response, traction = contact.product(tangents, w[:m].reshape(2, -1))
            out = np.append(response, 0.0) if self.pressure is not None else response.reshape(-1).copy()
            out[:m] -= w[:m]
            if self.pressure is not None:
                out[self.nodes : m] += w[-1]
                out[-1] = self.top_compliance * contact.pressure(traction)
            return out

        return product

    def inverse(self, v, active):
        """The DenseInverse, or None where it is singular or takes longer than iterations.

        That at the last v is kept: v must not be changed later.
        """
        if self._inverse[0] is not v:
            self._inverse = v, self._new_inverse(v, active)
        return self._inverse[1]

    def _new_inverse(self, v, active):
        if self.contact.uniform or not 0 < active.sum() <= DENSE.most:
            return None
        try:
            return DenseInverse(self, v, active)
        except np.linalg.LinAlgError:
            return None

    def oriented(self, mode):
        """A mode with the sign in which the surface, on the whole, moves towards the substrate, as on approach."""
        return -mode if self.surface(mode)[1].sum() > 0.0 else mode.copy()

    def translated(self, v, distance):
        """The same state moved on along x by a distance (nm), a whole number of sites; a new array."""
        return v + distance * self._along

    def crowded(self, v, active, s):
        """Whether a node outside the patch may interact."""
        return self.contact.crowded(active) or self.contact.overlooked(self.surface(v), active, self.top(v, s)[1])

    def hides(self, v, active):
        """Whether waves grow that one node for all cannot show (as in the adhesive instability of a flat)."""
        if not self.contact.uniform or not active.any():
            return False
        return uniform_growth(self, v, active, self.contact.scene.damping)[1] > UNSTABLE

    def grown(self, v, active, s):
        """(the problem on a wider patch, v, active there); new nodes are displaced by the tractions of the old ones.

        From one node for all: the problem of all nodes.
        """
        contact, (U_x, U_z) = self.contact, self.top(v, s)
        wide = Equilibrium(contact.wider(), self.loading, self.pressure)
        if contact.uniform:
            u = np.repeat(self.surface(v), wide.nodes, axis=1)
            return wide, wide.unknowns(u, U_z), np.repeat(active, wide.nodes)
        u = contact.whole(self.traction(v, active)) + np.array([[U_x], [U_z]])
        part = slice(wide.contact.first, wide.contact.first + wide.nodes)
        inner = slice(contact.first - wide.contact.first, contact.first - wide.contact.first + self.nodes)
        u = u[:, part].copy()
        u[:, inner] = self.surface(v)
        wide_active = np.zeros(wide.nodes, bool)
        wide_active[inner] = active
        return wide, wide.unknowns(u, U_z), wide_active

    def motion(self):
        """The Surface, whose rests are the equilibria of this problem."""
        if self._surface is None:
            self._surface = Surface(self)
        return self._surface


class Surface:
    """The Dynamics of the whole surface: y (2, modes), the Fourier coefficients of u, of unit mass (paper section 2.1).

    Attributes: stiffness (3, modes) GPa/nm in rows xx, zz, c, as of `layer.Modes`, but zero for the uniform normal mode
    under a held load; critical: 2 sqrt(k_min), the friction that is critical for the slowest mode of the layer.
    """

    def __init__(self, problem):
        self.problem, contact = problem, problem.contact
        modes, self._uniform = contact.modes, contact.uniform
        last = 1 if self._uniform else None
        k_xx, k_zz, k_c = modes.stiffness
        least = 0.5 * (k_xx + k_zz) - np.hypot(0.5 * (k_xx - k_zz), k_c)
        self.critical = 2.0 * float(np.sqrt(least.min()))
        self.stiffness = modes.stiffness[:, :last].copy()
        self.compliance = modes.compliance[:, :last]
        self._count = 1 if self._uniform else contact.nodes
        self.even = self._count % 2 == 0
        self._disturbances = None
        if problem.pressure is not None:
            self.stiffness[1, 0] = 0.0
        if not self._uniform:
            self._traction, self._u, self._spectrum, self._forward, self._backward = transforms(self._count)
            self._patch = slice(contact.first, contact.first + contact.size)

    def top(self, s):
        """U as the uniform mode of y, complex (2,)."""
        return np.array(self.problem.loading.at(s), complex) * self._count

    def disturbance(self, v, active):
        """The Maps of small disturbances at an equilibrium; those given before are no longer valid."""
        if self._uniform:
            return UniformDisturbance(self, v, active)
        if self._disturbances is None:
            self._disturbances = Disturbances(self)
        return self._disturbances.at(v, active)

    def start(self, v, active, s):
        """y of the surface at rest in v, complex (2, modes); outside the patch it follows from the traction inside."""
        problem = self.problem
        T, (U_x, U_z) = problem.traction(v, active), problem.top(v, s)
        if self._uniform:
            return problem.surface(v).astype(complex)
        self._traction[:] = 0.0
        self._traction[:, self._patch] = T
        self._forward()
        y = problem.contact.modes.displacement(self._spectrum)
        y[0, 0] += U_x * self._count
        y[1, 0] += U_z * self._count
        # v is not quite an equilibrium: the patch is put where v has it, not where its traction would
        # put it, as a tenth of that difference may decide which rest the motion reaches
        self._traction[:, self._patch] = problem.surface(v) - self.displacement(y)
        self._forward()
        return y + self._spectrum

    def displacement(self, y):
        """u (2, m) on the patch, nm; a buffer."""
        if self._uniform:
            return np.ascontiguousarray(y.real)
        self._spectrum[:] = y
        self._backward()
        self._u *= 1.0 / self._count
        return self._u[:, self._patch]

    def unknowns(self, y):
        """v of y; under a held load the top is where the layer carries that load."""
        problem = self.problem
        height = float(y[1, 0].real) / self._count
        if problem.pressure is not None:
            height -= float(self.compliance[1, 0]) * problem.pressure
        return problem.unknowns(self.displacement(y), height)

    def force(self, y, active):
        """T in the coordinates y, less a held load; complex (2, modes), a buffer; counts as a force evaluation."""
        contact = self.problem.contact
        contact.count()
        u = self.displacement(y)
        if self._uniform:
            spectrum = contact.traction(u, active).astype(complex)
        else:
            field = self._traction[:, self._patch]
            cohesive_law.tractions(u, contact.profile, active, contact.law, contact.work, field, contact.size)
            self._forward()
            spectrum = self._spectrum
        if self.problem.pressure is not None:
            spectrum[1, 0] -= self.problem.pressure * self._count
        return spectrum

    def interface(self, v, active):
        """The largest stiffness of the interface in v, GPa/nm: a bound on dT/du by row sums."""
        t = np.abs(self.problem.contact.tangents(self.problem.surface(v), active))
        return float(max((t[0] + t[1]).max(), (t[2] + t[3]).max()))


def closed_stiffness(scene):
    """Stiffness of a node in registry and in touch, the larger of both directions, GPa/nm."""
    tangent = cohesive_law.tangent(scene, 0.0, 0.0)
    return float(max(-tangent[0], -tangent[3]))


@njit(cache=True, nogil=True)
def _residual(u, g, load_x, load_z, out):
    largest, total, m = 0.0, 0.0, u.shape[1]
    for i in range(m):
        out[i] = load_x + g[0, i] - u[0, i]
        out[m + i] = load_z + g[1, i] - u[1, i]
        largest = max(largest, abs(out[i]), abs(out[m + i]))
        total += out[i] + out[m + i]
    return largest if np.isfinite(total) else np.inf  # a maximum passes over nan
