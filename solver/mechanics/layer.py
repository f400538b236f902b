"""Elasticity of the bonded layer: its Green's function in Fourier space, and products with it by FFT.

The tractions K (u - U) displace the lower surface by u against the stage's U, for each mode exp(i q x). The coupling
has K_xz = -i K_c and K_zx = +i K_c; the compliance C has the opposite signs.
"""

from functools import cached_property, lru_cache
from math import factorial

import numpy as np
import pyfftw

from .fftw import planning, plans
from .kernels import multiply

# Powers in the series of sinh y - y: for y <= 1, the next one is below round-off
ODD = range(3, 22, 2)


def stiffness(q, height, E, nu) -> np.ndarray:
    """(K_xx, K_zz, K_c), (3, *q's shape) GPa/nm, at wavenumbers q >= 0 (1/nm) of a layer of that height (nm).

    A plane-strain layer clamped at z = h; q = 0 is the uniform mode, q h -> infinity the half-plane. With y = q h,
    sinh y, cosh y and y all carry the factor 2 exp(-y), so that nothing overflows; no difference cancels.
    """
    y, G, kappa = np.asarray(q, float) * height, E / (2.0 * (1.0 + nu)), 3.0 - 4.0 * nu
    t = np.exp(-y)
    s, c, x = -np.expm1(-2.0 * y), 1.0 + t * t, 2.0 * t * y
    series = sum(np.minimum(y, 1.0) ** n / factorial(n) for n in ODD)
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


def compliance(q, height, E, nu) -> np.ndarray:
    """(C_xx, C_zz, C_c), nm/GPa, the inverse of `stiffness`, with C_xz = +i C_c and C_zx = -i C_c."""
    return _inverse(stiffness(q, height, E, nu))


def _inverse(blocks):
    """The inverse of blocks [[xx, -i c], [i c, zz]] with rows xx, zz, c; its own c has the opposite sign."""
    xx, zz, c = blocks
    return np.array([zz, xx, c]) / (xx * zz - c * c)


class Modes:
    """The layer at every wavenumber of a periodic cell of `nodes`; the coupling of the Nyquist mode is dropped.

    The springs of a drive, between the top and the stage, add their compliance to that of the uniform mode q = 0.

    Attributes, shared between runs and not to be written to: stiffness (GPa/nm) and compliance (nm/GPa), each
    (3, nodes//2 + 1) with rows xx, zz, c; drawn (2,), the drive's share of the compliance at q = 0 along x and z. A
    read-only flag would be another type, for which kernels compile again.
    """

    def __init__(self, nodes, width, height, E, nu, drive=(0.0, 0.0)):
        """width, height: nm; E: GPa; drive: compliance of its springs along x and z, nm/GPa."""
        self.nodes = nodes
        self.stiffness = stiffness(2.0 * np.pi * np.arange(nodes // 2 + 1) / width, height, E, nu)
        if nodes % 2 == 0:
            self.stiffness[2, -1] = 0.0
        of_drive = self.stiffness[:2, 0] * drive  # compliance over that of the layer
        self.stiffness[:2, 0] /= 1.0 + of_drive
        self.drawn = of_drive / (1.0 + of_drive)
        self.compliance = _inverse(self.stiffness)

    @cached_property
    def critical(self) -> float:
        """2 k_min^1/2, the damping constant, 1/time at unit mass, that is critical for the slowest mode."""
        k_xx, k_zz, k_c = self.stiffness
        least = 0.5 * (k_xx + k_zz) - np.hypot(0.5 * (k_xx - k_zz), k_c)
        return 2.0 * float(np.sqrt(least.min()))

    @staticmethod
    def of(scene) -> "Modes":
        """The Modes of a scene, cached for the last scenes."""
        return _modes(scene.nodes, scene.width, scene.height * scene.width, scene.E, scene.nu, scene.drive_compliance)

    @cached_property
    def kernels(self) -> np.ndarray:
        """C_xx, C_zz, C_xz = -C_zx between two nodes by their distance round the cell, (3, nodes) nm/GPa."""
        xx, zz, c = self.compliance
        return np.fft.irfft([xx, zz, 1j * c], self.nodes)


# at 1,024 nodes, 16 layers take 1.2 MB with their kernels
_modes = lru_cache(maxsize=16)(Modes)


class Transform:
    """Real rows `field` (2, length) to `spectrum` (2, length//2 + 1) and back to `product`; owns these buffers.

    forward() fills spectrum from field. backward() fills product, times length, and destroys spectrum. FFTW plans by
    its estimate: what measured plans save is within the noise of a run's time.

    Attributes: plans, those by address for compiled loops; None where only pyFFTW can execute them.
    """

    def __init__(self, length):
        with planning:
            self.field, self.product = pyfftw.zeros_aligned((2, length)), pyfftw.zeros_aligned((2, length))
            self.spectrum = pyfftw.zeros_aligned((2, length // 2 + 1), dtype=complex)
            self.plans = plans(self.field, self.spectrum, self.product)
            if self.plans:
                self.forward, self.backward = self.plans.forward, self.plans.backward
            else:
                self.forward = _plan(self.field, self.spectrum, "FFTW_FORWARD")
                self.backward = _plan(self.spectrum, self.product, "FFTW_BACKWARD", "FFTW_DESTROY_INPUT")
            self.field[:] = 0.0  # planning may overwrite it

    def apply(self, blocks) -> None:
        """Fill product from field, with its spectrum times blocks, as of `kernels.multiply`."""
        if self.plans:
            self.plans.respond(self.spectrum, blocks)
            return
        self.forward()
        multiply(self.spectrum, blocks)
        self.backward()


def _plan(source, target, direction, *flags):
    return pyfftw.FFTW(source, target, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE", *flags)).execute


class Convolution:
    """The layer's response to tractions on `size` neighbouring nodes, on these nodes; the others carry no traction.

    Owns its buffers: two threads need two objects.

    Attributes: field, tractions (2, size) GPa, to be filled; product, displacements (2, size) nm, after `apply`; fft,
    blocks (3, modes), nm/GPa over the count of nodes: the Transform and the compliance that give it.
    """

    def __init__(self, modes, size):
        self.blocks, self.fft = modes.compliance / modes.nodes, Transform(modes.nodes)
        self.field, self.product = self.fft.field[:, :size], self.fft.product[:, :size]

    def apply(self) -> None:
        """Fill product with C field."""
        self.fft.apply(self.blocks)
