"""Slips of large parts of a soft layer, which jumps into contact and zips shut node by node over thousands of nodes.

There the flow is too stiff to follow: modes held by closed springs decay C dT/du ~ 1e4 .. 1e7 times faster than the
free surface moves. Instead every spring is replaced by a linear one that pulls as hard now and is closed at the same
place (in overclosure by its tangent),

    T(u + du) ~ T(u) - S du,  S_z = phi_n/delta_n^2 sum exp(-dn/delta_n - dt^2/delta_t^2),  S_x with 2 phi_t/delta_t^2,

and the layer with these springs is solved for: (I + C S) du = U + C T(u) - u. As the law softens with the square of
the opening, the linear springs' energy lies above that of the real ones: no step passes over a barrier that the flow
would not pass (half-quadratic majorization, Geman & Reynolds 1992, doi:10.1109/34.120331). That is strict for
phi_t = 0 and open springs; elsewhere it is a guide, as NP1 has no potential, and tests compare with the flow.
A surface of every r-th node first zips r times as fast; it is followed for r = 2^k, .. 2, 1.
"""

from math import ceil

import numpy as np
from numba import njit

from .contact import Contact
from .layer import Convolution, Modes
from .np1 import WORK, tangent

COARSEST = 64  # nodes of a patch, at least
SETTLED = 0.1  # of min(delta_n, delta_t): residual at which a coarse surface is handed on to the next finer one
MOST_STEPS = 3000  # of one coarse level, after which it is handed on as it is
ACCURACY, MOST_PRODUCTS = 0.03, 300  # of one step: of min(delta_n, delta_t) where springs are closed, iterations
QUIET = 60  # steps without a change of the active set, after which a coarse surface is handed on all the same
FINER, FINEST = 0.8, 1e-6  # times that accuracy for each of these steps, down to a millionth
FULL = 0.85  # of a patch within the window: by then finer surfaces will need a wider one
DEEPEST = 0.2  # delta_n, by which one step may press a node into overclosure
MOST_CHANGES = 10  # of a node that comes into the window and leaves it


class CoarseContact(Contact):
    """The contact of `fine` on about every ratio-th node, each of which stands for its surroundings.

    The law is that of the fine lattice: u_x = 0 is in registry. Attribute: at, the nodes' places in fine nodes.
    """

    def __init__(self, fine, ratio):
        scene = fine.scene
        self.scene, self.nodes = scene, ceil(scene.nodes / ratio)
        places = np.arange(self.nodes) * (scene.nodes / self.nodes)
        self.at = places[(places >= fine.first) & (places <= fine.first + fine.size - 1)] - fine.first
        self.first, self.size = 0, self.at.size
        self.profile = np.interp(self.at, np.arange(fine.size), fine.profile)
        self.window, self.lowest, self.law = fine.window, fine.lowest, fine.law
        self.modes = Modes(self.nodes, scene.width, scene.height * scene.width, scene.E, scene.nu)
        self.compliance = Convolution(self.modes.compliance, self.nodes, self.size, fine.normal_only)
        self.normal_only, self.alone, self.mirror = fine.normal_only, fine.alone, False
        self.work, self.evaluations = np.empty((WORK, self.size)), 0


class Closing:
    """A surface on its way to equilibrium at fixed load, by steps as above; the interface of `flow.Flow`."""

    def __init__(self, contact, u, load):
        self.contact, self.load, self.u = contact, load, np.array(u)
        contact.mirror = False
        self.active, self.r = contact.within_window(u), np.empty_like(self.u)
        self._changes = np.zeros(contact.size, int)
        self.quiet = 0  # steps since a node last came into the window or left it
        self.idle = 0  # steps since more of them were within it than ever before
        self._most = int(self.active.sum())
        self._closed = closed_stiffness(contact.scene)
        self._unit = min(contact.scene.delta_n, contact.scene.delta_t)
        self._moved = self._unit
        self._root = float(np.sqrt(self._closed.max()))
        compliance = contact.modes.compliance[:2]
        self._longest, self._shortest = compliance.max(axis=1, keepdims=True), compliance.min(axis=1, keepdims=True)
        self._near = Convolution(_inverse(contact.modes.compliance, self._closed), contact.nodes, contact.size)
        self.residual = contact.residual(self.u, self.active, load, self.r)

    def advance(self):
        """One step; the largest residual after it, nm, is `residual`."""
        contact = self.contact
        stiffness = _stiffness(contact, self.active, self._closed)
        held = stiffness * self._longest > 1.0
        move = self._solved(stiffness, held)
        gap = contact.profile + self.u[1]
        np.maximum(move[1], -np.maximum(gap, 0.0) - DEEPEST * contact.scene.delta_n, out=move[1])
        self.u = self.u + move
        self._moved = np.abs(move[held]).max() if held.any() else self._unit
        self._choose_active()
        self.residual = contact.residual(self.u, self.active, self.load, self.r)

    def nudge(self, distance):
        """Move every node by a random distance of that order (nm): off a saddle."""
        self.u = self.u + distance * np.random.default_rng(0).normal(size=self.u.shape)
        self.residual = self.contact.residual(self.u, self.active, self.load, self.r)

    def _solved(self, stiffness, held):
        """(I + C S)^-1 r by conjugate gradients on (I + root C root) y = root r, root = S^1/2, preconditioned.

        By the inverse for a layer with closed springs everywhere, where held, scaled so that it holds for short waves.
        """
        layer, near, root = self.contact.compliance, self._near, np.sqrt(stiffness)
        scale = np.sqrt((1.0 + self._closed * self._shortest) / (1.0 + stiffness * self._shortest)) * held
        y, rest, direction = np.zeros_like(self.r), root * self.r, np.zeros_like(self.r)
        least = ACCURACY * max(FINER**self.quiet, FINEST) * self._root * min(self._moved, self._unit)
        before = np.inf
        for _ in range(MOST_PRODUCTS):
            _scale(scale, rest, near.field)
            near.apply()
            product = _turn(rest, scale, near.product, before, direction)
            if product == 0.0:
                break
            _scale(root, direction, layer.field)
            layer.apply()
            self.contact.evaluations += 2  # two products, which need no exponentials
            before = product
            if _step(root, direction, layer.product, product, y, rest) <= least:
                break
        _scale(root, y, layer.field)
        layer.apply()
        return self.r - layer.product

    def _choose_active(self):
        # nodes that often came and went are let out later than they are let in
        late = self.contact.scene.delta_n * (self.active & (self._changes >= MOST_CHANGES))
        active = self.contact.profile + self.u[1] <= self.contact.window + late
        changed = active != self.active
        self._changes += changed
        self.active = active
        self.quiet = 0 if changed.any() else self.quiet + 1
        inside = int(active.sum())
        self.idle = 0 if inside > self._most else self.idle + 1
        self._most = max(self._most, inside)


def closed_stiffness(scene):
    """S (2, 1) of a spring at dn = 0, in registry, GPa/nm."""
    rows = tangent(scene, 0.0, 0.0)
    return np.maximum(-np.array([[rows[0]], [rows[3]]]), 0.0)


def _stiffness(contact, active, closed):
    """S (2, size) after a force evaluation, GPa/nm: rows x and z.

    S_x is at most the greatest curvature that the sum over sites has at that gap: on fine lattices, where the sites'
    pulls cancel, next to nothing.
    """
    law, (sums, force, dn) = contact.law, contact.work[[0, 3, 4]]
    force = np.where(active, force, 0.0)
    shear = np.minimum(law[1] / law[3] * sums, closed[0]) * force
    normal = law[0] / law[2] * sums * force * (1.0 - np.minimum(dn, 0.0))
    return np.array([np.zeros_like(shear) if contact.normal_only else shear, normal])


def _inverse(compliance, closed):
    """(I + R C R)^-1 in rows xx, zz, c, for R = diag(closed)^1/2."""
    x, z = closed[:, 0]
    c_xx, c_zz, c_c = x * compliance[0], z * compliance[1], np.sqrt(x * z) * compliance[2]
    det = (1.0 + c_xx) * (1.0 + c_zz) - c_c**2
    return np.array([(1.0 + c_zz) / det, (1.0 + c_xx) / det, -c_c / det])


def closed_up(contact, u, load, unit):
    """u (2, size) carried as far as ever finer surfaces lead, down to every second node; None if it leaves the patch.

    unit: min(delta_n, delta_t), nm. The work is added to the evaluations of `contact`, by share of nodes.
    """
    ratio = 1
    while contact.size / (4 * ratio) >= COARSEST:
        ratio *= 2
    while ratio > 1:
        coarse, here = CoarseContact(contact, ratio), np.arange(contact.size)
        closing = Closing(coarse, [np.interp(coarse.at, here, row) for row in u], load)
        for _ in range(MOST_STEPS):
            if closing.residual <= SETTLED * unit or closing.quiet > QUIET:
                break
            closing.advance()
            if coarse.crowded(closing.active) or not (coarse.alone or closing.active.mean() < FULL):
                return None
        contact.evaluations += ceil(coarse.evaluations * coarse.size / contact.size)
        u = _spread(contact, coarse, closing.u)
        ratio //= 2
    return u


def _spread(fine, coarse, u):
    """The coarse displacement on the fine nodes: what is interpolated is the gap, for it is smooth in contact."""
    here, period = np.arange(fine.size), fine.size if fine.alone else None
    moved = np.interp(here, coarse.at, u[0], period=period)
    gap = np.interp(here, coarse.at, coarse.profile + u[1], period=period)
    return np.array([moved, gap - fine.profile])


@njit(cache=True, nogil=True)
def _scale(root, y, out):
    for c in range(2):
        for i in range(y.shape[1]):
            out[c, i] = root[c, i] * y[c, i]


@njit(cache=True, nogil=True)
def _turn(rest, scale, inverse, before, direction):
    """The next direction of conjugate gradients, in place; returns <rest, preconditioned rest>."""
    product = 0.0
    for c in range(2):
        for i in range(rest.shape[1]):
            product += rest[c, i] * (scale[c, i] * inverse[c, i] if scale[c, i] > 0.0 else rest[c, i])
    for c in range(2):
        for i in range(rest.shape[1]):
            z = scale[c, i] * inverse[c, i] if scale[c, i] > 0.0 else rest[c, i]
            direction[c, i] = z + product / before * direction[c, i]
    return product


@njit(cache=True, nogil=True)
def _step(root, direction, response, product, y, rest):
    """One step of conjugate gradients along direction, y and rest in place; returns the largest |rest|."""
    slope = 0.0
    for c in range(2):
        for i in range(y.shape[1]):
            slope += direction[c, i] * (direction[c, i] + root[c, i] * response[c, i])
    length, largest = product / slope, 0.0
    for c in range(2):
        for i in range(y.shape[1]):
            y[c, i] += length * direction[c, i]
            rest[c, i] -= length * (direction[c, i] + root[c, i] * response[c, i])
            largest = max(largest, abs(rest[c, i]))
    return largest
