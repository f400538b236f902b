"""The noise of a measured curve, and the drops of it that are slips."""

import numpy as np
from numpy.typing import NDArray

from ..continuation.state import TINY

FEWEST = 8  # points of a segment; third differences of fewer leave no estimate of the noise
JUMP = 5.0 * 2.0**0.5  # least drop of a slip over the noise of a point; noise alone makes one in 3 million points
# least drop of a slip over the median step of a finely sampled curve: about JUMP, as the median step of pure noise is
# 0.95 standard deviations
SUDDEN = 8.0
# Least drop of a slip over the steps beside it and over the 90 % quantile of rises, on a sparse curve. 24 scenes at 5
# to 8 points a period with 1.2 % noise (tests/bench/fit.py, BASE): 1.7 took smooth sliding for slips, 2.5 missed 6 %.
ALONE = 2.0
DIFFERENCES = {3: 20.0, 2: 6.0}  # order: variance of such a difference over that of a point


def noise_of(y: NDArray[np.float64], drops: NDArray[np.int_] | tuple[int, ...] = ()) -> float:
    """Standard deviation of the noise of a curve y (k,), from differences of third order, of second where too few.

    Differences across `drops` (the index before each) and those beyond four deviations are left out as slips.
    """
    differences = np.zeros(0)
    for order, variance in DIFFERENCES.items():
        across = np.isin(np.arange(len(y) - 1), drops)
        usable = ~np.lib.stride_tricks.sliding_window_view(across, order).any(axis=1)
        differences = np.abs(np.diff(y, order)[usable]) / variance**0.5
        if differences.size >= FEWEST:
            break
    # a normal distribution has the median 0.6745 of |x| in deviations; noise exceeds four once in 16,000 differences
    most = 4.0 / 0.6745 * float(np.median(differences)) if differences.size else 0.0
    calm = differences[differences <= most] if differences.size else [0.0]
    # a curve interpolated between states is right to some 1e-4
    return max(float(np.mean(np.square(calm))) ** 0.5, 2e-4 * float(np.abs(y).max()), TINY)


def drops_of(F: NDArray[np.float64]) -> NDArray[np.int_]:
    """Indices before the drops of F (k,) that look like slips, whatever the noise.

    Either a drop is far larger than usual steps, or it stands alone: larger than the steps beside it and than rises.
    """
    steps = np.diff(F)
    size = np.abs(steps)
    beside = np.maximum(np.append(0.0, size[:-1]), np.append(size[1:], 0.0))
    steep = steps < -SUDDEN * float(np.median(size))
    return np.flatnonzero(steep | (steps < -ALONE * np.maximum(beside, rise_of(steps))))


def slips_of(F: NDArray[np.float64], noise: float) -> tuple[int, ...]:
    """First indices after the slips: those of `drops_of` that exceed the noise (standard deviation of F)."""
    return tuple(int(i) + 1 for i in drops_of(F) if F[i] - F[i + 1] > JUMP * noise)


def rise_of(steps) -> float:
    """The 90 % quantile of rising steps; 0 without any."""
    rises = steps[steps > 0.0]
    # the largest rises may be noise
    return float(np.quantile(rises, 0.9)) if rises.size else 0.0
