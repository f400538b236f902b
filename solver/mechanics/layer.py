"""Elasticity of the bonded layer: its Green's function in Fourier space, and the products with it by FFT.

To displace the lower surface by u against the top's U takes tractions K (u - U) for the mode exp(i q x), with
K_xz = -i K_c, K_zx = +i K_c.
"""

from functools import cached_property, lru_cache
from math import ceil, log2
from threading import Lock

import numpy as np
import pyfftw
from numba import njit

_planning = Lock()  # FFTW's planner is not thread-safe


def stiffness(q, height, E, nu):
    """(K_xx, K_zz, K_c) in GPa/nm at wavenumbers q >= 0 (1/nm) of a layer of that height (nm), each of q's shape.

    A plane-strain layer clamped at z = h; q = 0 is the uniform mode, q h -> infinity the half-plane.
    """
    y, sc_plus, sc_minus, s2, y2, _ = _hyperbolic(q, height, nu)
    G, kappa = E / (2.0 * (1.0 + nu)), 3.0 - 4.0 * nu
    d = _determinant(y, kappa)
    with np.errstate(invalid="ignore", divide="ignore"):
        k_xx = 4.0 * G * (1.0 - nu) * q * sc_minus / d
        k_zz = 4.0 * G * (1.0 - nu) * q * sc_plus / d
        k_c = 2.0 * G * q * (kappa * (1.0 - 2.0 * nu) * s2 - y2) / d
    zero = y == 0.0
    k_xx[zero], k_c[zero] = G / height, 0.0
    k_zz[zero] = 2.0 * G * (1.0 - nu) / ((1.0 - 2.0 * nu) * height)
    return k_xx, k_zz, k_c


def compliance(q, height, E, nu):
    """(C_xx, C_zz, C_c) in nm/GPa, the inverse of `stiffness`, arguments as there: C_xz = +i C_c, C_zx = -i C_c."""
    y, sc_plus, sc_minus, s2, y2, b = _hyperbolic(q, height, nu)
    G, kappa = E / (2.0 * (1.0 + nu)), 3.0 - 4.0 * nu
    with np.errstate(invalid="ignore", divide="ignore"):
        c_xx = (1.0 - nu) / (G * q) * sc_plus / b
        c_zz = (1.0 - nu) / (G * q) * sc_minus / b
        c_c = 0.5 / (G * q) * (kappa * (1.0 - 2.0 * nu) * s2 - y2) / b
    zero = y == 0.0
    c_xx[zero], c_c[zero] = height / G, 0.0
    c_zz[zero] = (1.0 - 2.0 * nu) * height / (2.0 * G * (1.0 - nu))
    return c_xx, c_zz, c_c


def _excess(y):
    """sinh y - y without cancellation, for 0 <= y <= 2."""
    term, total = y**3 / 6.0, np.zeros_like(y)
    for k in range(2, 16):
        total += term
        term = term * y * y / ((2 * k) * (2 * k + 1))
    return total


def _hyperbolic(q, height, nu):
    """y = q h; then kappa s c +- y, s^2, y^2, kappa c^2 + y^2 + (1-2nu)^2, times 4 exp(-2y); s = sinh y, c = cosh y."""
    y, kappa = np.asarray(q, float) * height, 3.0 - 4.0 * nu
    t = np.exp(-2.0 * y)
    scale, sc, s2, c2 = 4.0 * t, (1.0 - t) * (1.0 + t), (1.0 - t) ** 2, (1.0 + t) ** 2
    small = np.minimum(y, 1.0)
    s2 = np.where(y < 1.0, scale * np.sinh(small) ** 2, s2)
    sc = np.where(y < 1.0, scale * np.sinh(small) * np.cosh(small), sc)
    sc_less_y = np.where(y < 1.0, scale * _excess(2.0 * small) / 2.0, sc - scale * y)
    plus = kappa * sc + scale * y
    minus = (kappa - 1.0) * sc + sc_less_y
    y2 = scale * y * y
    return y, plus, minus, s2, y2, kappa * c2 + y2 + scale * (1.0 - 2.0 * nu) ** 2


def _determinant(y, kappa):
    """4 exp(-2y) (kappa^2 sinh^2 y - y^2), as a product of two sums, so that nothing cancels at nu -> 1/2, small y."""
    small, half = np.minimum(y, 1.0), np.exp(-y)
    two_s = np.where(y < 1.0, 2.0 * half * np.sinh(small), 1.0 - half * half)
    less = np.where(y < 1.0, 2.0 * half * _excess(small), two_s - 2.0 * half * y)
    return ((kappa - 1.0) * two_s + less) * (kappa * two_s + 2.0 * half * y)


class Modes:
    """The layer's stiffness and compliance at every wavenumber of the periodic cell, coupling dropped at Nyquist.

    From width and height, nm, and E, GPa. Attributes: stiffness (GPa/nm) and compliance (nm/GPa), (3, nodes//2 + 1) in
    rows xx, zz, c.
    """

    def __init__(self, nodes, width, height, E, nu):
        self.nodes = nodes
        q = 2.0 * np.pi * np.arange(nodes // 2 + 1) / width
        self.stiffness = np.array(stiffness(q, height, E, nu))
        self.compliance = np.array(compliance(q, height, E, nu))
        if nodes % 2 == 0:
            self.stiffness[2, -1] = self.compliance[2, -1] = 0.0
            # without coupling each component is its own inverse
            self.compliance[:2, -1] = 1.0 / self.stiffness[:2, -1]
        self.stiffness.flags.writeable = self.compliance.flags.writeable = False

    @staticmethod
    def of(scene):
        """The Modes of a scene, kept for the scenes used last."""
        return _modes(scene.nodes, scene.width, scene.height * scene.width, scene.E, scene.nu)

    def shifted(self, sigma):
        """(I + sigma C)^-1, (3, nodes//2 + 1) in rows xx, zz, c; sigma: stiffness at every node, GPa/nm."""
        c_xx, c_zz, c_c = sigma * self.compliance
        det = (1.0 + c_xx) * (1.0 + c_zz) - c_c**2
        return np.array([(1.0 + c_zz) / det, (1.0 + c_xx) / det, -c_c / det])

    @cached_property
    def kernels(self):
        """C_xx, C_zz, C_xz = -C_zx between two nodes by their distance round the cell, (3, nodes) nm/GPa."""
        return _kernels(self.compliance, self.nodes)

    def displacement(self, traction_q):
        """C T, nm, for Fourier tractions, GPa, complex (2, nodes//2 + 1); a new array."""
        out = traction_q.copy()
        multiply(out, self.compliance)
        return out


def _kernels(modes, nodes):
    """Rows xx, zz, xz in real space, by the distance between two nodes round the cell, (3, nodes)."""
    return np.array([np.fft.irfft(c, nodes) for c in (modes[0], modes[1], 1j * modes[2])])


@lru_cache(maxsize=16)
def _modes(nodes, width, height, E, nu):
    return Modes(nodes, width, height, E, nu)


def fft_size(least):
    """The smallest length >= least of the form 4, 5 or 6 times a power of two: fast, even, and few to plan for."""
    power = 2 ** max(0, ceil(log2(max(least, 4) / 8.0)))
    return next(k * power for k in (4, 5, 6, 8) if k * power >= least)


class Convolution:
    """The product of modes (3, nodes//2 + 1), rows xx, zz, c, with a field on `size` neighbouring nodes, seen there.

    The field is zero elsewhere, so a transform of 2 size - 1 points (rounded up to a fast length) does in place of one
    of all nodes. Exact to round-off. Buffers belong to this object; not for use by two threads. normal_only: the first
    row of the field is zero throughout and not transformed.

    Attributes: field (2, size), to be filled; product (2, size), valid after `apply`.
    """

    def __init__(self, modes, nodes, size, normal_only=False):
        length = fft_size(2 * size - 1)
        if length >= nodes:
            length = nodes
        else:
            modes = _cut(modes, nodes, size, length)
        self._multipliers = np.ascontiguousarray(modes / length)
        self._before, self._after, self._spectrum, self._forward, self._backward = transforms(length, normal_only)
        self.field, self.product, self._idle = self._before[:, :size], self._after[:, :size], normal_only

    def apply(self):
        """product = modes * field."""
        if self._idle:  # the transform back has overwritten it
            self._spectrum[0] = 0.0
        self._forward()
        multiply(self._spectrum, self._multipliers)
        self._backward()


class UniformMode:
    """The same product where all nodes carry the same traction: field and product (2, 1)."""

    def __init__(self, modes):
        self.modes = modes[0, 0], modes[1, 0]
        self.field, self.product = np.zeros((2, 1)), np.zeros((2, 1))

    def apply(self):
        """product = modes * field."""
        self.product[0, 0], self.product[1, 0] = self.modes[0] * self.field[0, 0], self.modes[1] * self.field[1, 0]


def _cut(modes, nodes, size, length):
    """Modes (3, length//2 + 1) of a cell of `length` nodes with the same kernels up to `size` nodes apart, 0 beyond."""
    reach = np.arange(length)
    reach = np.where(reach < size, reach, reach - length)
    inside = np.abs(reach) < size
    spectra = [np.fft.rfft(np.where(inside, k[reach % nodes], 0.0)) for k in _kernels(modes, nodes)]
    return np.array([spectra[0].real, spectra[1].real, spectra[2].imag])


def transforms(length, normal_only=False, measure=False):
    """(before, after, spectrum, forward, backward): real rows (2, length), their spectrum, and two calls.

    forward() fills spectrum from before; backward() fills after, times length, and destroys spectrum.
    normal_only: forward() leaves out the first row. measure: FFTW tries plans for some 0.3 s and remembers the fastest
    for this process; without, a remembered plan is used, else FFTW's estimate, which takes up to a third longer.
    """
    with _planning:
        before, after = pyfftw.zeros_aligned((2, length)), pyfftw.zeros_aligned((2, length))
        spectrum = pyfftw.zeros_aligned((2, length // 2 + 1), dtype=complex)
        rows = slice(1, 2) if normal_only else slice(0, 2)
        forward = _plan(before[rows], spectrum[rows], "FFTW_FORWARD", (), measure)
        backward = _plan(spectrum, after, "FFTW_BACKWARD", ("FFTW_DESTROY_INPUT",), measure)
        before[:] = 0.0  # planning may overwrite
    return before, after, spectrum, forward.execute, backward.execute


def _plan(source, target, direction, flags, measure):
    try:
        effort = ("FFTW_MEASURE",) if measure else ("FFTW_MEASURE", "FFTW_WISDOM_ONLY")
        return pyfftw.FFTW(source, target, axes=(1,), direction=direction, flags=(*effort, *flags))
    except RuntimeError:  # nothing remembered of this length
        return pyfftw.FFTW(source, target, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE", *flags))


@njit(cache=True, nogil=True)
def multiply(spectrum, c):
    """spectrum (2, modes) times the blocks [[xx, i c], [-i c, zz]], rows of c, in place (stiffnesses have -c)."""
    for k in range(spectrum.shape[1]):
        x, z = spectrum[0, k], spectrum[1, k]
        spectrum[0, k] = complex(c[0, k] * x.real - c[2, k] * z.imag, c[0, k] * x.imag + c[2, k] * z.real)
        spectrum[1, k] = complex(c[1, k] * z.real + c[2, k] * x.imag, c[1, k] * z.imag - c[2, k] * x.real)
