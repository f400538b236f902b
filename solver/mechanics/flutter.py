"""Where waves of the contact may flutter: the damping above which they cannot, by a local criterion.

As NP1 has no potential, T_x(u_z) and T_z(u_x) can feed a wave more than friction takes from it. Estimated at every
place for a wave q as if alone, from the 2 x 2 block of J - K with J averaged over a length of 0.6/q by a Gaussian. Not
a proof; `tests/bench/rests.py` counts exceptions among dense spectra.
"""

import numpy as np
from numba import njit

WIDER = 1.5  # growth of the variance of the average from level to level; at 2 the result changes by 3 %
MARGIN = 1.1  # on what is found: 8 % too little has been seen, among 6237 dense spectra


@njit(cache=True, nogil=True)
def safe_friction(tangents, k, n, covers_cell):
    """The friction gamma (1/time, unit mass) above which no wave grows as an oscillation; 0.0 where J is symmetric.

    That is |Im mu|/|Re mu|^1/2, the largest over waves and places. tangents: J on the patch, (4, m) GPa/nm, rows as of
    `cohesive_law.tangents`; k: K, (3, modes) GPa/nm, rows xx, zz, c; n: nodes of the cell; covers_cell: whether the
    patch is the whole cell, so that averages go round its ends.

    Each level of averaging serves the waves whose 0.6/q lies between its width and the next. Places are thinned out
    once the average is twice as wide as they are apart.
    """
    m = tangents.shape[1]
    field = tangents.copy() if covers_cell else np.zeros((4, 2 * m))
    if not covers_cell:
        field[:, m // 2 : m // 2 + m] = tangents
    highest, worst, variance, wider, apart = n // 2, 0.0, 0.0, 0.25, 1
    while True:
        lowest = int(0.6 * n / (2.0 * np.pi * np.sqrt(wider))) + 1 if field.shape[1] >= 6 else 0
        p = highest
        while p >= lowest:
            worst = max(worst, _largest(field, k[0, p], k[1, p], k[2, p]))
            p = min(p - 1, int(p / 1.19))  # four wavenumbers to an octave
        highest = lowest - 1
        if highest < 0:
            return MARGIN * np.sqrt(worst)
        while variance > 4.0 * apart**2:
            field, apart = np.ascontiguousarray(field[:, ::2]), 2 * apart
        passes = int(np.ceil((wider - variance) / (0.5 * apart**2)))
        for _ in range(passes):
            field = _smoothed(field, 0.5 * (wider - variance) / (passes * apart**2))
        variance, wider = wider, WIDER * wider


@njit(cache=True, nogil=True)
def _smoothed(field, share):
    """Every place averaged with that share of each of its two neighbours; the last neighbours the first."""
    out, count = np.empty_like(field), field.shape[1]
    for c in range(4):
        for i in range(count):
            out[c, i] = (1.0 - 2.0 * share) * field[c, i] + share * (field[c, i + 1 - count] + field[c, i - 1])
    return out


@njit(cache=True, nogil=True)
def _largest(field, k_xx, k_zz, k_c):
    """Largest (Im mu)^2/|Re mu| of decaying waves with that stiffness, over the places of field (4, places)."""
    worst = 0.0
    for i in range(field.shape[1]):
        xx, xz, zx, zz = field[0, i] - k_xx, field[1, i], field[2, i], field[3, i] - k_zz
        mean, half = 0.5 * (xx + zz), 0.5 * (xx - zz)
        # mu = mean +- D^1/2 with D = half^2 + (xz + i k_c) (zx - i k_c)
        real, imaginary = half * half + xz * zx + k_c * k_c, k_c * (zx - xz)
        size = np.hypot(real, imaginary)
        turning, root = 0.5 * (size - real), np.sqrt(max(0.5 * (size + real), 0.0))
        decay = root - mean if root > -mean else -mean - root  # of the slower one that decays
        if decay > 0.0 and turning > worst * decay:
            worst = turning / decay
    return worst
