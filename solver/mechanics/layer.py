"""Elasticity of the bonded layer: its Green's function in Fourier space, and the products with it by FFT.

To displace the lower surface by u against the top's U takes tractions K (u - U) for the mode exp(i q x), with
K_xz = -i K_c, K_zx = +i K_c.
"""

from functools import cached_property, lru_cache
from math import ceil, factorial, log2
from threading import Lock

import numpy as np
import pyfftw
from numba import njit

_planning = Lock()  # FFTW's planner is not thread-safe


def stiffness(q, height, E, nu):
    """(K_xx, K_zz, K_c) in GPa/nm at wavenumbers q >= 0 (1/nm) of a layer of that height (nm), (3, *q's shape).

    A plane-strain layer clamped at z = h; q = 0 is the uniform mode, q h -> infinity the half-plane. With y = q h, all
    of sinh y, cosh y and y is taken 2 exp(-y) times, and differences in forms in which nothing cancels.
    """
    y, G, kappa = np.asarray(q, float) * height, E / (2.0 * (1.0 + nu)), 3.0 - 4.0 * nu
    t = np.exp(-y)
    s, c, x = -np.expm1(-2.0 * y), 1.0 + t * t, 2.0 * t * y
    series = sum(np.minimum(y, 1.0) ** n / factorial(n) for n in range(3, 22, 2))
    s_less_x = np.where(y < 1.0, 2.0 * t * series, s - x)
    sc_less_x = 2.0 * t * s_less_x + s * np.expm1(-y) ** 2
    d = ((kappa - 1.0) * s + s_less_x) * (kappa * s + x)
    with np.errstate(invalid="ignore"):
        k_xx = 4.0 * G * (1.0 - nu) * q * ((kappa - 1.0) * s * c + sc_less_x) / d
        k_zz = 4.0 * G * (1.0 - nu) * q * (kappa * s * c + 2.0 * t * x) / d
        k_c = 2.0 * G * q * (kappa * (1.0 - 2.0 * nu) * s * s - x * x) / d
    zero = y == 0.0
    k_xx[zero], k_c[zero] = G / height, 0.0
    k_zz[zero] = 2.0 * G * (1.0 - nu) / ((1.0 - 2.0 * nu) * height)
    return np.array([k_xx, k_zz, k_c])


def compliance(q, height, E, nu):
    """(C_xx, C_zz, C_c) in nm/GPa, the inverse of `stiffness`, arguments as there: C_xz = +i C_c, C_zx = -i C_c."""
    return _inverse(stiffness(q, height, E, nu))


def _inverse(blocks):
    """Of the blocks [[xx, -i c], [i c, zz]], rows xx, zz, c; those of the inverse have +i c above."""
    xx, zz, c = blocks
    return np.array([zz, xx, c]) / (xx * zz - c * c)


class Modes:
    """The layer's stiffness and compliance at every wavenumber of the periodic cell, coupling dropped at Nyquist.

    From width and height, nm, and E, GPa. Attributes, not to be written to: stiffness (GPa/nm) and compliance (nm/GPa),
    (3, nodes//2 + 1) in rows xx, zz, c. (Flagged read-only they would be another type, for which kernels compile anew.)
    """

    def __init__(self, nodes, width, height, E, nu):
        self.nodes = nodes
        self.stiffness = stiffness(2.0 * np.pi * np.arange(nodes // 2 + 1) / width, height, E, nu)
        if nodes % 2 == 0:
            self.stiffness[2, -1] = 0.0
        self.compliance = _inverse(self.stiffness)

    @cached_property
    def critical(self):
        """2 k_min^1/2, the friction, 1/time at unit mass, that is critical for the slowest mode of the layer."""
        k_xx, k_zz, k_c = self.stiffness
        least = 0.5 * (k_xx + k_zz) - np.hypot(0.5 * (k_xx - k_zz), k_c)
        return 2.0 * float(np.sqrt(least.min()))

    @staticmethod
    def of(scene, nodes=None):
        """The Modes of a scene, kept for the scenes used last; nodes: so many instead, 1 for the uniform mode alone."""
        return _modes(nodes or scene.nodes, scene.width, scene.height * scene.width, scene.E, scene.nu)

    @cached_property
    def kernels(self):
        """C_xx, C_zz, C_xz = -C_zx between two nodes by their distance round the cell, (3, nodes) nm/GPa."""
        xx, zz, c = self.compliance
        return np.fft.irfft([xx, zz, 1j * c], self.nodes)


@lru_cache(maxsize=16)
def _modes(nodes, width, height, E, nu):
    return Modes(nodes, width, height, E, nu)


def fft_size(least):
    """The smallest length >= least of the form 4, 5 or 6 times a power of two: fast, even, and few to plan for."""
    power = 2 ** max(0, ceil(log2(max(least, 4) / 8.0)))
    return next(k * power for k in (4, 5, 6, 8) if k * power >= least)


class Convolution:
    """The layer's response to tractions on `size` neighbouring nodes, seen there; the others carry none.

    Therefore a transform of 2 size - 1 points (rounded up to a fast length) does in place of one of all nodes. Exact to
    round-off. Buffers belong to this object; not for use by two threads.

    Attributes: field, tractions (2, size), GPa, to be filled; product, displacements (2, size), nm, after `apply`.
    """

    def __init__(self, modes, size):
        length, compliance = fft_size(2 * size - 1), modes.compliance
        if length < modes.nodes:
            compliance = _cut(modes, size, length)
        length = min(length, modes.nodes)
        self._multipliers = np.ascontiguousarray(compliance / length)
        before, after, self._spectrum, self._forward, self._backward = transforms(length)
        self.field, self.product = before[:, :size], after[:, :size]

    def apply(self):
        """product = C field."""
        self._forward()
        multiply(self._spectrum, self._multipliers)
        self._backward()


def _cut(modes, size, length):
    """Compliance (3, length//2 + 1) of a cell of `length` nodes with the same kernels up to `size` nodes apart."""
    reach = np.arange(length)
    reach = np.where(reach < size, reach, reach - length)
    xx, zz, xz = np.fft.rfft(np.where(np.abs(reach) < size, modes.kernels[:, reach % modes.nodes], 0.0))
    return np.array([xx.real, zz.real, xz.imag])


def transforms(length):
    """(before, after, spectrum, forward, backward): real rows (2, length), their spectrum, and two calls.

    forward() fills spectrum from before; backward() fills after, times length, and destroys spectrum. By FFTW's
    estimate: what plans that it has measured save of a run is about its noise.
    """
    with _planning:
        before, after = pyfftw.zeros_aligned((2, length)), pyfftw.zeros_aligned((2, length))
        spectrum = pyfftw.zeros_aligned((2, length // 2 + 1), dtype=complex)
        forward = _plan(before, spectrum, "FFTW_FORWARD")
        backward = _plan(spectrum, after, "FFTW_BACKWARD", "FFTW_DESTROY_INPUT")
        before[:] = 0.0  # planning may overwrite
    return before, after, spectrum, forward.execute, backward.execute


def _plan(source, target, direction, *flags):
    return pyfftw.FFTW(source, target, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE", *flags))


@njit(cache=True, nogil=True)
def multiply(spectrum, c):
    """spectrum (2, modes) times the blocks [[xx, i c], [-i c, zz]], rows of c, in place (stiffnesses have -c)."""
    for k in range(spectrum.shape[1]):
        x, z = spectrum[0, k], spectrum[1, k]
        spectrum[0, k] = complex(c[0, k] * x.real - c[2, k] * z.imag, c[0, k] * x.imag + c[2, k] * z.real)
        spectrum[1, k] = complex(c[1, k] * z.real + c[2, k] * x.imag, c[1, k] * z.imag - c[2, k] * x.real)
