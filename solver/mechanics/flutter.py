"""The damping above which waves of the contact cannot flutter, estimated by a local criterion.

NP1 has no potential, so T_x(u_z) and T_z(u_x) can feed a wave more than friction takes from it. For a wave q at a place
the 2 x 2 block of J - K decides, with J averaged around that place by a Gaussian of standard deviation 0.6/q. This is
not a proof: `tests/bench/rests.py` counts exceptions among dense spectra.
"""

import numpy as np

from ..continuation.compiled import kernel
from . import cohesive_law
from .layer import Modes

# `tests/bench/damping.py` shows what other values of the first three change
WIDTH = 0.6  # of the averaging Gaussian, times 1/q: with a narrower one the result rises, with a wider one it falls
WIDER = 1.5  # growth of the variance from one level of averaging to the next
FINER = 1.19  # ratio of one wavenumber to the next, four to an octave
MARGIN = 1.1  # factor of the result, which a few dense spectra exceed (tests/bench/rests.py)


def safe_damping(scene, u, first=0) -> float:
    """The damping, over critical, above which no wave of the contact grows as an oscillation.

    It is 0 where all nodes are alike: there every mode is a wave, and the stability analysis knows them all.
    u (2, m) nm; first: index of the first of these m nodes in the cell.
    """
    m = u.shape[1]
    tangents = cohesive_law.tangent(scene, u[0], scene.profile[first : first + m] + u[1])
    if m == scene.nodes and cohesive_law.alike(tangents):
        return 0.0
    modes = Modes.of(scene)
    return safe_friction(tangents, modes.stiffness, scene.nodes) / modes.critical


def safe_friction(tangents, stiffness, nodes) -> float:
    """The friction gamma, 1/time at unit mass, above which no wave grows as an oscillation; 0.0 where J is symmetric.

    gamma^2 = max (Im mu)^2/|Re mu| over waves and places. tangents: J on the patch, (4, m) GPa/nm, rows as of
    `cohesive_law.tangents`; stiffness: K, (3, modes) GPa/nm, rows xx, zz, c, of a cell of so many `nodes`. Averages go
    round the ends of a patch that is the whole cell.

    Level by level the average widens. Each level serves the waves whose WIDTH/q lies between its width and the next.
    """
    m, highest = tangents.shape[1], nodes // 2
    field = np.zeros((4, m if m == nodes else 2 * m))
    start = (field.shape[1] - m) // 2
    field[:, start : start + m] = tangents
    longest = WIDTH * nodes / (2.0 * np.pi)  # WIDTH/q of the cell's longest wave, in spacings
    worst, variance, wider, apart = 0.0, 0.0, 0.25, 1  # the first average is half a spacing wide
    while True:
        # a pass takes in three places: of fewer than six, averages widen no more
        lowest = int(longest / np.sqrt(wider)) + 1 if field.shape[1] >= 6 else 0
        worst = max(worst, _largest(field, stiffness, lowest, highest, FINER))
        highest = lowest - 1
        if highest < 0:
            return MARGIN * float(np.sqrt(worst))
        while variance > 4.0 * apart**2:  # every second place suffices
            field, apart = np.ascontiguousarray(field[:, ::2]), 2 * apart
        more = (wider - variance) / apart**2
        passes = int(np.ceil(2.0 * more))  # of a variance of 1/2 at most: weights 1/4, 1/2, 1/4
        _average(field, 0.5 * more / passes, passes)
        variance, wider = wider, WIDER * wider


@kernel
def _average(field, share, passes):
    """So many times, in place: every place of field (4, places) gets that share of both neighbours' values.

    The last place is next to the first.
    """
    last = field.shape[1] - 1
    for c in range(4):
        for _ in range(passes):
            first, before = field[c, 0], field[c, last]
            for i in range(last + 1):
                value, after = field[c, i], field[c, i + 1] if i < last else first
                field[c, i] = value + share * (before - 2.0 * value + after)
                before = value


@kernel
def _largest(field, k, lowest, highest, finer):
    """Largest (Im mu)^2/|Re mu| of decaying waves from `highest` to `lowest`, over the places of field (4, places)."""
    worst, p = 0.0, highest
    while p >= lowest:
        for i in range(field.shape[1]):
            xx, xz, zx, zz = field[0, i] - k[0, p], field[1, i], field[2, i], field[3, i] - k[1, p]
            mean, half, k_c = 0.5 * (xx + zz), 0.5 * (xx - zz), k[2, p]
            # mu = mean +- D^1/2 with D = half^2 + (xz + i k_c) (zx - i k_c)
            real, imaginary = half * half + xz * zx + k_c * k_c, k_c * (zx - xz)
            size = np.hypot(real, imaginary)
            turning, root = 0.5 * (size - real), np.sqrt(max(0.5 * (size + real), 0.0))
            decay = root - mean if root > -mean else -mean - root  # of the slower one that decays
            if decay > 0.0 and turning > worst * decay:
                worst = turning / decay
        p = min(p - 1, int(p / finer))
    return worst
