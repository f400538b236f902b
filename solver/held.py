"""Contact under a held normal load: the height of the top is one more unknown, one more column of u.

u (2, m + 1): the surface, then the top, u[:, m] = (U_x, U_z). With p the mean of T_z over the cell and p_0 the one to
hold, the residual is U + C T(u) - u for the surface, with U_z = u[1, m], and mobility (p - p_0) for the top. Branches,
their folds and slips are then found as ever; a soft machine has folds where a stiff one has none.

Any positive mobility gives the same equilibria, as the top's residual vanishes at p = p_0 alone; it says how fast the
top moves compared with the surface, and so which branch a slip reaches. The compliance of the uniform mode, C_zz(0),
makes the top as quick as the layer below it (a heavier one would slip at fixed delta and sink afterwards). It is at
least delta_n^2/phi_n, so that in every converged frame p is within tolerance/delta_n phi_n/delta_n of p_0.
"""

from dataclasses import replace

import numpy as np

from . import np1
from .contact import Contact
from .layer import Convolution
from .secants import Secants
from .state import PulledOff

BEYOND = 1e9  # nm: the top's gap, far outside any window


class Held(Contact):
    """As `Contact`, with the top as the last of `size` + 1 columns, at the mean normal traction `pressure` (GPa)."""

    def __init__(self, scene, first, size, pressure, uniform=False, normal_only=False):
        super().__init__(scene, first, size, uniform, normal_only)
        self.pressure, self.free = pressure, size
        self.size, self.held = size + 1, True
        self.profile = np.append(self.profile, BEYOND)
        self.work = np.empty((np1.WORK, self.size))
        compliance = float(self.modes.compliance[1, 0])
        self.mobility = max(compliance, scene.delta_n**2 / scene.phi_n)
        share = self.mobility * (1.0 if uniform else 1.0 / scene.nodes)
        self.compliance = WithTop(self.compliance, size, share)

    def response(self, u, active):
        """C T(u) and the height of the top, less what the held load takes off it; (2, size) nm, a buffer."""
        self.evaluations += 1
        field = self.compliance.field
        np1.tractions(u, self.profile, active, self.law, self.work, field, self.size)
        field[1, -1] = u[1, -1]
        self.compliance.apply()
        self.compliance.product[1, -1] -= self.mobility * self.pressure
        return self.compliance.product

    def tangents(self, u, active):
        """As in `Contact`; the top's own tangent is 1: see `WithTop`."""
        tangents = super().tangents(u, active)
        tangents[3, -1] = 1.0
        return tangents

    def shifted(self, sigma):
        """(I + sigma C)^-1 on the surface; the top's residual stays as it is."""
        return WithTop(Convolution(self.modes.shifted(sigma), self.nodes, self.free), self.free, 0.0, carried=False)

    def within_window(self, u):
        """As in `Contact`; raises PulledOff once nothing holds the top."""
        active = super().within_window(u)
        if self.pressure < 0.0 and not active.any():
            raise PulledOff(
                f"The contact has pulled off at U_x = {round(u[0, -1], 6) + 0.0:g} nm: under L_bar ="
                f" {self.pressure / self.scene.E:.4g} nothing holds the punch; hold delta instead, or press harder"
            )
        return active

    def crowded(self, active):
        """As in `Contact`."""
        return super().crowded(active[:-1])

    def overlooked(self, traction, height):
        """As in `Contact`."""
        return super().overlooked(traction[:, :-1], height)


def contact_of(scene, first, size, pressure=None, leave_out=frozenset(), normal_only=False):
    """The Contact of a scene on a patch, or the Held one of that mean normal traction (GPa)."""
    if pressure is None:
        return Contact(scene, first, size, normal_only=normal_only)
    if scene.surface == "flat" and "uniform" in leave_out:
        return Held(scene, 0, 1, pressure, uniform=True)
    return Held(scene, first, size, pressure, normal_only=normal_only)


class WithTop:
    """A product on the surface, `layer`, extended by the top: its field is its own height, which every node follows.

    The top's product is its height plus `share` times the sum of the normal field. Not carried: the top's field stays.
    """

    def __init__(self, layer, size, share, carried=True):
        self.layer, self.share, self.carried = layer, share, carried
        self.field, self.product = np.zeros((2, size + 1)), np.zeros((2, size + 1))

    def apply(self):
        """Fill product from field."""
        self.layer.field[:] = self.field[:, :-1]
        self.layer.apply()
        self.product[:, :-1] = self.layer.product
        if self.carried:
            height = self.field[1, -1]
            self.product[1, :-1] += height
            self.product[0, -1], self.product[1, -1] = 0.0, height + self.share * self.field[1, :-1].sum()
        else:
            self.product[:, -1] = self.field[:, -1]


def joined(state, top):
    """The State with the top at (U_x, U_z), nm, as one more column of u."""
    u = np.column_stack((state.u, top))
    return _with(state, u, np.append(state.active, False))


def parted(state):
    """The State without the top's column."""
    return _with(state, np.ascontiguousarray(state.u[:, :-1]), state.active[:-1])


def _with(state, u, active):
    secants = state.secants and Secants(state.secants.memory, u.size)
    return replace(state, u=u, active=active, past=[(state.load, u)], secants=secants, record=None, sites=0)
