"""Small disturbances of the surface at an equilibrium: the Maps of `continuation.problem`, that tell whether it rests.

A disturbance x (2, n) nm, of every node of the cell, flattened, obeys x'' = (J - K) x - gamma x' with J = dT/du, which
vanishes outside the patch. Parseval: its Euclidean product is that of Fourier modes of unit mass.
"""

import numpy as np
from numba import njit

from .layer import multiply, transforms

SIGNS = np.array([[1.0], [1.0], [-1.0]])  # K_xz = -i K_c, but C_xz = +i C_c
WIDER = 1.5  # growth of the variance of the average from level to level of `_flutter`
MARGIN = 1.1  # on what `_flutter` finds: 8 % too little has been seen, at a damping of 0.06


class Disturbances:
    """Scratch and transforms for one Surface of more than one node; `at` an equilibrium gives the maps there."""

    def __init__(self, surface):
        problem, contact = surface.problem, surface.problem.contact
        self.problem, self.contact = problem, contact
        self.n, self.first, self.m = contact.nodes, contact.first, contact.size
        self.size, self.held = 2 * self.n, problem.pressure is not None
        self._before, self._after, self._spectrum, self._forward, self._backward = transforms(self.n)
        self._compliance = np.ascontiguousarray(surface.compliance / self.n)
        self._stiffness = surface.stiffness * (SIGNS / self.n)
        self.stiffness, self.cell = surface.stiffness, contact.covers_cell
        self.stiffest = float((np.maximum(*surface.stiffness[:2]) + np.abs(surface.stiffness[2])).max())
        self.patch = slice(self.first, self.first + self.m)

    def at(self, v, active):
        """The maps at an equilibrium; they share these buffers."""
        return Disturbance(self, v, active)

    def through(self, modes):
        """`modes` times the field in `_before`, left in `_after`, both (2, n)."""
        self._forward()
        multiply(self._spectrum, modes)
        self._backward()


class Disturbance:
    """At one equilibrium; `size`: of a disturbance x, `tangents` (4, m): J on the patch, GPa/nm."""

    def __init__(self, room, v, active):
        self._room, self.size = room, room.size
        self.stiffness, self.stiffest = room.stiffness, room.stiffest
        self.tangents = t = room.contact.tangents(room.problem.surface(v), active)
        self.interface = float(np.abs(t).max())
        self.asymmetry = 0.5 * float(np.abs(t[1] - t[2]).max())

    def flutter(self, critical):
        """The damping, over `critical`, above which waves of the contact cannot flutter; 0.0 where none can at all.

        For each wave the 2 x 2 block of J - K, J averaged over a length of 0.6/q by a Gaussian, taken at every place.
        Not a proof, but no exception in 6237 frames.
        """
        if self.asymmetry == 0.0:
            return 0.0
        room = self._room
        return MARGIN * _flutter(self.tangents, room.stiffness, room.n, room.cell) / critical

    def product(self, x):
        """(J - K) x, a new array; counts as a force evaluation."""
        room = self._room
        room.contact.count()
        field = x.reshape(2, room.n)
        room._before[:] = field
        room.through(room._stiffness)
        out = np.empty((2, room.n))
        _less(self.tangents, field, room._after, room.first, out)
        return out.reshape(-1)

    def filtered(self, x, blocks):
        """x through the layer's modes times blocks, rows xx, zz, c as of the stiffness; a new array."""
        room = self._room
        room._before[:] = x.reshape(2, room.n)
        room.through(blocks * (SIGNS / room.n))
        return room._after.reshape(-1).copy()

    def load(self, f):
        """What a force f (size of x) on the surface adds to the residual R of the unknowns, a new array."""
        room, field = self._room, f.reshape(2, -1)
        room._before[:] = field
        room.through(room._compliance)
        out = np.empty(room.problem.size)
        out[: 2 * room.m] = room._after[:, room.patch].reshape(-1)
        if room.held:
            out[-1] = room.problem.mobility * field[1].sum() / room.n
        return out

    def spread(self, w, f=None):
        """The surface x at rest with unknowns w (problem size) under a force f besides, a new array."""
        room = self._room
        room._before[:] = 0.0 if f is None else f.reshape(2, room.n)
        _turned_on(self.tangents, w[: 2 * room.m].reshape(2, -1), room.first, room._before)
        room.through(room._compliance)
        out = room._after.copy()
        if room.held:
            out[1] += w[-1]
        return out.reshape(-1)

    def seen(self, x):
        """The unknowns of a disturbance x, a new array (problem size)."""
        room, field = self._room, x.reshape(2, -1)
        w = field[:, room.patch].reshape(-1)
        return np.append(w, field[1].mean()) if room.held else w.copy()


class UniformDisturbance:
    """The same for the one node that stands for all: x (2,), the uniform wave alone; no `tangents`, no `flutter`."""

    size = 2

    def __init__(self, surface, v, active):
        self._held = surface.problem.pressure is not None
        t = surface.problem.contact.tangents(surface.problem.surface(v), active)[:, 0]
        self._matrix = t.reshape(2, 2) - np.diag(surface.stiffness[:2, 0])

    def product(self, x):
        """(J - K) x, a new array."""
        return self._matrix @ x

    def seen(self, x):
        """The unknowns of a disturbance."""
        return np.append(x, x[1]) if self._held else x.copy()


def uniform_growth(problem, v, active, damping):
    """Growth of the uniform disturbance, and the largest of those with q > 0, of a surface whose nodes are all alike.

    damping: over critical; inf: the growths are those of the overdamped limit.
    """
    contact, motion = problem.contact, problem.motion()
    k = contact.modes.stiffness
    t = contact.tangents(problem.surface(v), active)[:, 0]
    friction = damping * motion.critical
    normal = 0.0 if problem.pressure is not None else k[1, 0]
    uniform = _fastest(t, np.array([[k[0, 0]], [normal], [0.0]]), 0, friction)
    return uniform, _fastest(t, k, 1, friction)


@njit(cache=True, nogil=True)
def _fastest(t, k, first, friction):
    """The largest growth over the modes from `first` on, for the same J = t (4,) at every node."""
    fastest = -np.inf
    for q in range(first, k.shape[1]):
        mean, half = 0.5 * (t[0] - k[0, q] + t[3] - k[1, q]), 0.5 * (t[0] - k[0, q] - t[3] + k[1, q])
        root = np.sqrt(complex(half * half) + complex(t[1], k[2, q]) * complex(t[2], -k[2, q]))
        for mu in (mean + root, mean - root):
            if np.isinf(friction):
                fastest = max(fastest, mu.real)
            else:
                fastest = max(fastest, np.sqrt(0.25 * friction**2 + mu).real - 0.5 * friction)
    return fastest


@njit(cache=True, nogil=True)
def _less(t, x, layer, first, out):
    """out = J x - layer; J acts on the patch."""
    for i in range(x.shape[1]):
        out[0, i], out[1, i] = -layer[0, i], -layer[1, i]
    for i in range(t.shape[1]):
        j = first + i
        out[0, j] += t[0, i] * x[0, j] + t[1, i] * x[1, j]
        out[1, j] += t[2, i] * x[0, j] + t[3, i] * x[1, j]


@njit(cache=True, nogil=True)
def _turned_on(t, w, first, out):
    """out += J w, w on the patch."""
    for i in range(t.shape[1]):
        out[0, first + i] += t[0, i] * w[0, i] + t[1, i] * w[1, i]
        out[1, first + i] += t[2, i] * w[0, i] + t[3, i] * w[1, i]


@njit(cache=True, nogil=True)
def _flutter(tangents, k, n, cell):
    """The largest |Im mu|/|Re mu|^1/2 of the local blocks.

    The variance of the average grows by WIDER from level to level; each serves the waves with width <= 0.6/q. Places
    are thinned out once the average is twice as wide as they are apart.
    """
    m = tangents.shape[1]
    field = tangents.copy() if cell else np.zeros((4, 2 * m))
    if not cell:
        for i in range(m):
            field[:, m // 2 + i] = tangents[:, i]
    highest, worst, variance, wider, apart = n // 2, 0.0, 0.0, 0.25, 1
    while True:
        lowest = int(0.6 * n / (2.0 * np.pi * np.sqrt(wider))) + 1 if field.shape[1] >= 6 else 0
        p = highest
        while p >= lowest:
            worst = max(worst, _steepest(field, k[0, p], k[1, p], k[2, p]))
            p = min(p - 1, int(p / 1.19))
        highest = lowest - 1
        if highest < 0:
            return worst
        while variance > 4.0 * apart**2:
            field, apart = np.ascontiguousarray(field[:, ::2]), 2 * apart
        passes = int(np.ceil((wider - variance) / (0.5 * apart**2)))
        for _ in range(passes):
            field = _smoothed(field, 0.5 * (wider - variance) / (passes * apart**2))
        variance, wider = wider, WIDER * wider


@njit(cache=True, nogil=True)
def _smoothed(field, share):
    """Every place averaged with that share of each of its neighbours, round the end."""
    count = field.shape[1]
    out = np.empty((4, count))
    for c in range(4):
        for i in range(count):
            j, h = i + 1 if i + 1 < count else 0, i - 1 if i else count - 1
            out[c, i] = (1.0 - 2.0 * share) * field[c, i] + share * (field[c, j] + field[c, h])
    return out


@njit(cache=True, nogil=True)
def _steepest(j, k_xx, k_zz, k_c):
    worst = 0.0
    for i in range(j.shape[1]):
        mean, half = 0.5 * (j[0, i] - k_xx + j[3, i] - k_zz), 0.5 * (j[0, i] - k_xx - j[3, i] + k_zz)
        root = np.sqrt(complex(half * half) + complex(j[1, i], k_c) * complex(j[2, i], -k_c))
        for mu in (mean + root, mean - root):
            if mu.real < 0.0:
                worst = max(worst, abs(mu.imag) / np.sqrt(-mu.real))
    return worst
