"""The Gaussian profile filter: heights without wavelengths below a cut-off.

Its weight at a distance x is exp(-pi (x / (alpha c))^2), with alpha^2 = ln 2 / pi and the cut-off c: a wave of that
length keeps half of its amplitude. At the ends of a profile the weights within it are normalised.
Source: ISO 16610-21:2011, Geometrical product specifications, Filtration, Linear profile filters: Gaussian filters.
"""

import numpy as np
from numpy.typing import NDArray

ALPHA = (np.log(2.0) / np.pi) ** 0.5


def smoothed(z: NDArray[np.float64], spacing: float, cut_off: float, periodic: bool = False) -> NDArray[np.float64]:
    """Heights z (n,) at distances of `spacing`, filtered; cut_off and spacing in one unit."""
    from scipy.ndimage import gaussian_filter1d  # a tenth of the time that importing `solver` takes

    sigma = ALPHA * cut_off / (2.0 * np.pi) ** 0.5 / spacing
    if periodic:
        return gaussian_filter1d(z, sigma, mode="wrap", truncate=6.0)
    weights = gaussian_filter1d(np.ones_like(z), sigma, mode="constant", truncate=6.0)
    return gaussian_filter1d(z, sigma, mode="constant", truncate=6.0) / weights


def least_cut_off(z: NDArray[np.float64], spacing: float, steepest: float, periodic: bool = False) -> float | None:
    """The cut-off, to a tenth of it, from which no slope of the heights z (n,) exceeds `steepest`; None: at none.

    Cut-offs up to half of the length are tried.
    """
    cut_off = 2.0 * spacing
    while cut_off < 0.5 * z.size * spacing:
        if np.abs(np.diff(smoothed(z, spacing, cut_off, periodic))).max() <= steepest * spacing:
            return float(cut_off)
        cut_off *= 1.1
    return None
