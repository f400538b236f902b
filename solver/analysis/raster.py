"""Pictures of the layer: one stress at the resolution of the screen, photoelastic fringes, and a mesh that deforms.

A row at depth z needs the modes up to q z = 17 only. They are summed by a transform on a grid of at least four points
to the shortest wave, and a Gaussian carries the sum to the pixels (Greengard & Lee 2004,
doi:10.1137/S003614450343200X). The sum itself, in the tests, takes some hundred times as long.
"""

from dataclasses import dataclass
from itertools import groupby
from math import inf, pi, sqrt

import numpy as np
from numba import njit

from ..mechanics.layer import fft_size
from .interior import displacement, lateral, normal, shape_of, shear, surface_modes, wavenumbers

QUANTITIES = ("normal", "shear", "mean", "difference")  # sigma_zz, sigma_xz, mean stress, sigma_1 - sigma_2
ACCURACY = 1e-5  # largest error of a picture, of the largest traction (or displacement below the top)
NORMAL, SHEAR, MEAN, DIFFERENCE, DISPLACEMENT = range(5)

DEEPEST = 17.0  # q z: beyond it a mode has decayed to (1 + q z) exp(-q z) < 1e-6
TAPS = 12  # points of the grid that a pixel is summed from
# of the Gaussian, in grid steps: what it leaves out, exp(-(TAPS/2)^2/2 s^2), equals what aliases, exp(-pi^2 s^2)
VARIANCE = TAPS / (2.0 * sqrt(2.0) * pi)
ROUND_OFF = 1e-14  # of a transform: modes below are none
SMALLEST = 32  # points of a grid: more than TAPS
BATCH = 1 << 16  # points transformed at a time: they stay in the cache


@dataclass(frozen=True)
class Mesh:
    """Displacement u (2, nz, nx) in nm at the points x (nx,) by z (nz,); every `stride`-th row and column is a line.

    Drawn at (x + factor (u_x - U_x), z + factor (u_z - U_z)), with the factor stated, they show the deformation.
    """

    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    stride: int


def picture(scene, first, traction, quantity, window, size):
    """One of QUANTITIES in GPa at the pixels' middles, (rows, columns) float32, to ACCURACY; row 0 is at the surface.

    traction (2, m), GPa, on the nodes from `first` on; window (x_low, x_high, depth) in nm, x as in scene.x;
    size (columns, rows). sigma_zz, sigma_xz, (sigma_xx + sigma_yy + sigma_zz)/3: tension > 0; sigma_1 - sigma_2 >= 0.
    Raises ValueError for another quantity, no pixels, and a window that is empty, infinite or deeper than the layer.
    """
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity = {quantity!r}; allowed: {', '.join(QUANTITIES)}; choose one of them")
    (x_low, x_high, depth), (columns, rows) = _checked(scene, window), size
    if not all(count >= 1 and count % 1 == 0 for count in size):
        raise ValueError(f"size = {size}: allowed: whole numbers (columns, rows) from 1 on; give one pixel or more")
    x = x_low + (np.arange(columns) + 0.5) * ((x_high - x_low) / columns)
    z = (np.arange(rows) + 0.5) * (depth / rows)
    fields = _summed(scene, surface_modes(scene, first, traction), QUANTITIES.index(quantity), x, z)
    return np.hypot(fields[0], fields[1]) if quantity == "difference" else fields[0]


def mesh(scene, first, traction, load, window, lines=(20, 8), stride=4):
    """Mesh of lines (across, deep) over the same window as the picture's, its border included.

    load (U_x, U_z) of the top, nm: a Frame's (U_x, -delta). Raises ValueError for a window as `picture` does.
    """
    x_low, x_high, depth = _checked(scene, window)
    x = np.linspace(x_low, x_high, (lines[0] - 1) * stride + 1)
    z = np.linspace(0.0, depth, (lines[1] - 1) * stride + 1)
    u = _summed(scene, surface_modes(scene, first, traction), DISPLACEMENT, x, z)
    return Mesh(x, z, u + np.asarray(load, float)[:, None, None], stride)


def fringes(difference, per_fringe):
    """Brightness sin^2(pi N), 0..1, of isochromatics in a dark field, fringe order N = (sigma_1 - sigma_2)/per_fringe.

    difference (...) and per_fringe in GPa, the latter the material's fringe value over the thickness looked through.
    Raises ValueError unless per_fringe > 0. Source: Frocht, Photoelasticity I (1941).
    """
    if not per_fringe > 0.0:
        raise ValueError(f"per_fringe = {per_fringe!r}: allowed: above 0 GPa; give the stress of one fringe")
    return np.sin(np.asarray(difference) * float(pi / per_fringe)) ** 2


def _checked(scene, window):
    x_low, x_high, depth = window
    height = scene.height * scene.width
    if not -inf < x_low < x_high < inf:  # nan fails it too
        raise ValueError(f"window = {window}: allowed: finite x_low < x_high; give a window of some width")
    if not 0.0 < depth <= height:
        raise ValueError(f"depth = {depth:g}: allowed: above 0 to {height:g} nm, the layer; take the smaller one")
    return window


def _summed(scene, T_q, quantity, x, z):
    """The fields (1 or 2, nz, nx) float32 of a quantity at x and ascending z, nm."""
    fields = np.empty((2 if quantity >= DIFFERENCE else 1, z.size, x.size), np.float32)
    q = wavenumbers(scene, _needed(T_q))
    layer = scene.height * scene.width, scene.shear_modulus, scene.nu
    with np.errstate(divide="ignore"):
        kept = 1 + np.searchsorted(q[1:], DEEPEST / z, "right")  # modes of each row
    stop = 0
    for points, rows in groupby(fft_size(max(4 * (int(k) - 1), SMALLEST)) for k in kept):
        start, stop = stop, stop + len(list(rows))
        leftmost, weights = _taps(x / scene.width, points)
        blunt = np.exp(2.0 * VARIANCE * (pi / points * np.arange(kept[start])) ** 2) / sqrt(2.0 * pi * VARIANCE)
        batch = max(1, BATCH // points)
        for begin in range(start, stop, batch):
            part = slice(begin, min(stop, begin + batch))
            modes = np.zeros((fields.shape[0], part.stop - begin, points // 2 + 1), complex)
            _fill(T_q, q, z[part], kept[part], layer, quantity, blunt, modes)
            _gather(np.fft.irfft(modes, points, norm="forward"), leftmost, weights, fields[:, part])
    return fields


def _needed(T_q):
    """How many of the modes carry more than round-off: on the flat, one."""
    size = np.abs(T_q).max(axis=0)
    return int(np.flatnonzero(size > ROUND_OFF * size.max())[-1]) + 1 if size.any() else 1


def _taps(turns, points):
    """(leftmost (nx,), weights (nx, TAPS)): what a grid of `points` over the cell gives to x/w = turns."""
    at = turns % 1.0 * points
    leftmost = np.floor(at).astype(np.int64) - TAPS // 2 + 1
    away = at[:, None] - leftmost[:, None] - np.arange(TAPS)
    return leftmost, np.exp(-0.5 / VARIANCE * away**2)


@njit(cache=True, nogil=True)
def _fill(T_q, q, z, kept, layer, quantity, blunt, modes):
    """modes (fields, rows, points//2 + 1): the amplitudes in each row, times what makes up for the Gaussian."""
    for r in range(z.size):
        for k in range(kept[r]):
            one, two = _amplitudes(quantity, q[k], z[r], layer, blunt[k] * T_q[0, k], blunt[k] * T_q[1, k])
            modes[0, r, k] = one
            if modes.shape[0] == 2:
                modes[1, r, k] = two


@njit(cache=True, nogil=True)
def _amplitudes(quantity, q, z, layer, T_x, T_z):
    """The one or two fields of a quantity at depth z in a mode of tractions T_x, T_z."""
    height, G, nu = layer
    if quantity == DISPLACEMENT:
        x_even, x_odd, z_even, z_odd = displacement(q, z, height, G, nu)
        return x_even * T_x + 1j * x_odd * T_z, z_even * T_z + 1j * z_odd * T_x
    shape, none = shape_of(q, z, height, nu), 0j
    even, odd = shear(shape)
    s_xz = even * T_x + 1j * odd * T_z
    if quantity == SHEAR:
        return s_xz, none
    even, odd = normal(shape)
    s_zz = even * T_z + 1j * odd * T_x
    if quantity == NORMAL:
        return s_zz, none
    even, odd = lateral(shape)
    s_xx = even * T_z + 1j * odd * T_x
    if quantity == MEAN:
        return (1.0 + nu) / 3.0 * (s_xx + s_zz), none
    return s_zz - s_xx, 2.0 * s_xz


@njit(cache=True, nogil=True)
def _gather(grid, leftmost, weights, out):
    """out[..., j] = sum over taps of weights[j] * grid[..., leftmost[j] + tap], grid periodic in its last axis."""
    points = grid.shape[2]
    for f in range(grid.shape[0]):
        for r in range(grid.shape[1]):
            row = grid[f, r]
            for j in range(leftmost.size):
                total, i = 0.0, leftmost[j] % points
                for tap in range(TAPS):
                    total += weights[j, tap] * row[i]
                    i = i + 1 if i + 1 < points else 0
                out[f, r, j] = total
