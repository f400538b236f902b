"""Small disturbances of the surface at an equilibrium: the Maps of `continuation.problem`, which tell whether it rests.

A disturbance x (2, n) nm, of all n nodes of the cell, flattened, obeys x'' = (J - K) x - gamma x', with J = dT/du, zero
outside the patch. By Parseval's theorem its Euclidean inner product is that of Fourier modes of unit mass.
"""

import numpy as np
from numba import njit

from .layer import multiply, transforms

SIGNS = np.array([[1.0], [1.0], [-1.0]])  # K_xz = -i K_c, but C_xz = +i C_c
WIDER = 1.5  # growth of the variance of the average from level to level of `_flutter_friction`
MARGIN = 1.1  # on what `_flutter_friction` finds: at a damping of 0.06, 8 % too little has been seen


ALIKE = 1e-7  # difference of J between nodes, over its largest, below which they count as alike


class Disturbances:
    """Buffers and transforms for disturbances of one `equilibrium.Surface`; `at` gives the maps at an equilibrium."""

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
    """The Maps at one equilibrium; `size`: of a disturbance x, `tangents` (4, m): J on the patch, GPa/nm."""

    def __init__(self, shared, v, active):
        self._shared, self.size = shared, shared.size
        self.stiffness, self.stiffest, self.patch_size = shared.stiffness, shared.stiffest, 2 * shared.m
        self.tangents = t = shared.contact.tangents(shared.problem.surface(v), active)
        self.interface = float(np.abs(t).max())
        self.asymmetry = 0.5 * float(np.abs(t[1] - t[2]).max())

    def flutter(self, critical):
        """The damping, over `critical`, above which waves of the contact cannot flutter; 0.0 where none can at all.

        Estimated at every place for a wave q as if alone: from the 2 x 2 block of J - K, with J averaged over a length
        of 0.6/q by a Gaussian. Not a proof, but no exception in 6237 frames.
        """
        if self.asymmetry == 0.0:
            return 0.0
        shared = self._shared
        return MARGIN * _flutter_friction(self.tangents, shared.stiffness, shared.n, shared.cell) / critical

    def alike(self):
        """Whether J is the same at every node of the cell, so that every mode is a wave."""
        return self._shared.cell and bool(np.ptp(self.tangents, axis=1).max() <= ALIKE * self.interface)

    def waves(self):
        """mu (waves, 2) and amplitudes (waves, 2, 2), in columns, of all modes where nodes are alike."""
        t, k = self.tangents.mean(axis=1), self.stiffness
        blocks = np.array([[t[0] - k[0], t[1] + 1j * k[2]], [t[2] - 1j * k[2], t[3] - k[1]]])
        return np.linalg.eig(np.moveaxis(blocks, 2, 0))

    def wave(self, q, amplitude):
        """The disturbance, complex, that is wave number q times an amplitude (2,)."""
        return np.outer(amplitude, np.exp(2j * np.pi * q * np.arange(self._shared.n) / self._shared.n)).reshape(-1)

    def product(self, x):
        """(J - K) x, a new array; counts as a force evaluation."""
        shared = self._shared
        shared.contact.count()
        field = x.reshape(2, shared.n)
        shared._before[:] = field
        shared.through(shared._stiffness)
        out = np.empty((2, shared.n))
        _tangent_less_layer(self.tangents, field, shared._after, shared.first, out)
        return out.reshape(-1)

    def filtered(self, x, blocks):
        """x, each Fourier mode times its 2 x 2 block, rows xx, zz, c as of the stiffness; a new array."""
        shared = self._shared
        shared._before[:] = x.reshape(2, shared.n)
        shared.through(blocks * (SIGNS / shared.n))
        return shared._after.reshape(-1).copy()

    def of_patch(self):
        """(mu (2 m,), modes (2 m, 2 m), in columns) of the patch alone, the surface beyond held still."""
        shared, t = self._shared, self.tangents
        i = np.arange(shared.m)
        columns = np.fft.irfft(self.stiffness * np.array([[1.0], [1.0], [-1j]]), shared.n, axis=1)
        xx, zz, xz = -columns[:, (i[:, None] - i) % shared.n]
        xz, zx = xz, xz.T.copy()
        xx[i, i] += t[0]
        xz[i, i] += t[1]
        zx[i, i] += t[2]
        zz[i, i] += t[3]
        return np.linalg.eig(np.block([[xx, xz], [zx, zz]]))

    def embedded(self, mode):
        """A mode (2 m,) of the patch as a disturbance of the whole surface."""
        out = np.zeros((2, self._shared.n), mode.dtype)
        out[:, self._shared.patch] = mode.reshape(2, -1)
        return out.reshape(-1)

    def shifted(self, mu):
        """The function f -> x with (J - K - mu) x = f, complex (N,), for mu off the real axis.

        There K + mu is regular, and as J vanishes outside the patch, all that is left to invert is 1 - (K + mu)^-1 J.
        """
        n, m, t, patch = self._shared.n, self._shared.m, self.tangents, self._shared.patch
        k = np.concatenate(
            [self.stiffness, self.stiffness[:, 1 : (n + 1) // 2][:, ::-1] * [[1.0], [1.0], [-1.0]]], axis=1
        )
        k[2, n // 2] *= n % 2  # the wave of the shortest length is real
        xx, zz, c = k[0] + mu, k[1] + mu, k[2]
        inverse = np.array([[zz, 1j * c], [-1j * c, xx]]) / (xx * zz - c**2)
        i = np.arange(m)
        kernels = np.fft.ifft(inverse, axis=2)[:, :, (i[:, None] - i) % n]
        tangent = t.reshape(2, 2, m)
        within = np.linalg.inv(np.eye(2 * m) - np.einsum("acij,cbj->aibj", kernels, tangent).reshape(2 * m, 2 * m))

        def layer(f):
            return np.fft.ifft((inverse * np.fft.fft(f, axis=1)).sum(axis=1), axis=1)

        def solved(f):
            x = -layer(f.reshape(2, n))
            y = (within @ x[:, patch].reshape(-1)).reshape(2, m)
            force = np.zeros((2, n), complex)
            force[:, patch] = (tangent * y).sum(axis=1)
            return (x + layer(force)).reshape(-1)

        return solved

    def load(self, f):
        """What a force f (size of x) on the surface adds to the residual R of the unknowns, a new array."""
        shared, field = self._shared, f.reshape(2, -1)
        shared._before[:] = field
        shared.through(shared._compliance)
        out = np.empty(shared.problem.size)
        out[: 2 * shared.m] = shared._after[:, shared.patch].reshape(-1)
        if shared.held:
            out[-1] = shared.problem.top_compliance * field[1].sum() / shared.n
        return out

    def spread(self, w, f=None):
        """The whole surface x that rests with unknowns w (problem size) under an additional force f, a new array."""
        shared = self._shared
        shared._before[:] = 0.0 if f is None else f.reshape(2, shared.n)
        _add_tangent_product(self.tangents, w[: 2 * shared.m].reshape(2, -1), shared.first, shared._before)
        shared.through(shared._compliance)
        out = shared._after.copy()
        if shared.held:
            out[1] += w[-1]
        return out.reshape(-1)

    def seen(self, x):
        """The unknowns of a disturbance x, a new array (problem size)."""
        shared, field = self._shared, x.reshape(2, -1)
        w = field[:, shared.patch].reshape(-1)
        return np.append(w, field[1].mean()) if shared.held else w.copy()


class UniformDisturbance:
    """The Maps of one node that stands for all: x (2,), the uniform mode; no others are needed for one so small."""

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
    """(growth of the uniform disturbance, largest growth of those with q > 0) of a surface whose nodes are all alike.

    damping: over critical; inf: growths of the overdamped limit.
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
        for mu in _block_eigenvalues(t, k[0, q], k[1, q], k[2, q]):
            if np.isinf(friction):
                fastest = max(fastest, mu.real)
            else:
                fastest = max(fastest, np.sqrt(0.25 * friction**2 + mu).real - 0.5 * friction)
    return fastest


@njit(cache=True, nogil=True)
def _block_eigenvalues(t, k_xx, k_zz, k_c):
    """Both eigenvalues mu of the 2 x 2 block J - K of one mode, J = t (4,)."""
    mean, half = 0.5 * (t[0] - k_xx + t[3] - k_zz), 0.5 * (t[0] - k_xx - t[3] + k_zz)
    root = np.sqrt(complex(half * half) + complex(t[1], k_c) * complex(t[2], -k_c))
    return mean + root, mean - root


@njit(cache=True, nogil=True)
def _tangent_less_layer(t, x, layer, first, out):
    """out = J x - layer, with J on the patch that begins at node `first`."""
    for i in range(x.shape[1]):
        out[0, i], out[1, i] = -layer[0, i], -layer[1, i]
    for i in range(t.shape[1]):
        j = first + i
        out[0, j] += t[0, i] * x[0, j] + t[1, i] * x[1, j]
        out[1, j] += t[2, i] * x[0, j] + t[3, i] * x[1, j]


@njit(cache=True, nogil=True)
def _add_tangent_product(t, w, first, out):
    """out += J w, with w on the patch that begins at node `first`."""
    for i in range(t.shape[1]):
        out[0, first + i] += t[0, i] * w[0, i] + t[1, i] * w[1, i]
        out[1, first + i] += t[2, i] * w[0, i] + t[3, i] * w[1, i]


@njit(cache=True, nogil=True)
def _flutter_friction(tangents, k, n, cell):
    """The friction gamma below which a wave may grow: the largest |Im mu|/|Re mu|^1/2 over waves and places.

    J is averaged more and more widely, the variance of the Gaussian growing by WIDER from level to level; each level
    serves the waves whose 0.6/q lies between its width and the next. Places are thinned out once the average is twice
    as wide as they are apart. cell: the patch is the whole cell of n nodes, so that averages go round its ends.
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
            worst = max(worst, _largest_friction(field, k[0, p], k[1, p], k[2, p]))
            p = min(p - 1, int(p / 1.19))  # four wavenumbers to an octave
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
    """Every place averaged with that share of each of its two neighbours; the last neighbours the first."""
    count = field.shape[1]
    out = np.empty((4, count))
    for c in range(4):
        for i in range(count):
            j, h = i + 1 if i + 1 < count else 0, i - 1 if i else count - 1
            out[c, i] = (1.0 - 2.0 * share) * field[c, i] + share * (field[c, j] + field[c, h])
    return out


@njit(cache=True, nogil=True)
def _largest_friction(field, k_xx, k_zz, k_c):
    """Of the wave with that stiffness, over the places of field (4, places): see `_flutter_friction`."""
    worst = 0.0
    for i in range(field.shape[1]):
        for mu in _block_eigenvalues(field[:, i], k_xx, k_zz, k_c):
            if mu.real < 0.0:
                worst = max(worst, abs(mu.imag) / np.sqrt(-mu.real))
    return worst
