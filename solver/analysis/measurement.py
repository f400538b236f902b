"""A measured friction curve: cut at its slips, its noise estimated."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..continuation.state import TINY
from ..tables import DataError
from .recording import FEWEST, Segment

if TYPE_CHECKING:
    from .comparison import Comparison, Computed

JUMP = 5.0 * 2.0**0.5  # least drop of a slip over the noise of a point; noise alone makes one in 3 million points
# least drop of a slip over the median step of a finely sampled curve: about JUMP, as the median step of pure noise is
# 0.95 standard deviations
SUDDEN = 8.0
# Least drop of a slip over the steps beside it and over the 90 % quantile of rises, on a sparse curve. 24 scenes at 5
# to 8 points a period with 1.2 % noise (tests/bench/fit.py, BASE): 1.7 took smooth sliding for slips, 2.5 missed 6 %.
ALONE = 2.0
DIFFERENCES = {3: 20.0, 2: 6.0}  # order: variance of such a difference over that of a point


@dataclass(frozen=True, eq=False)
class Measurement:
    """A curve measured along U_x (k,), nm, ascending.

    values: {"F_bar", "L_bar", "A_bar"} (k,) each, F_bar at least; noise: their standard deviations. slips: the first
    index after each slip. unit: w E (N/m) that forces in N/m were divided by; None for forces given as F_bar. notes:
    what the file has that was not used. width: w (nm) that areas in nm were divided by; None for areas given as A_bar.
    said: {name: text} that the file says above its columns.
    """

    U_x: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    noise: dict[str, float]
    slips: tuple[int, ...]
    unit: float | None = None
    notes: tuple[str, ...] = ()
    width: float | None = None
    said: dict[str, str] = field(default_factory=dict)

    kind: ClassVar[str] = "friction"
    free: ClassVar[bool] = False

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The curve as one Segment, in `units`."""
        over = {"F": self.unit, "L": self.unit, "A": self.width}
        values = {name.removesuffix("_bar"): y for name, y in self.values.items()}
        return (Segment("forth", self.U_x, {name: y * (over[name] or 1.0) for name, y in values.items()}),)

    @property
    def units(self) -> dict[str, str]:
        """{"U_x", "F", "L", "A": unit} of `segments`."""
        force, area = "N/m" if self.unit else "w E", "nm" if self.width else "w"
        return {"U_x": "nm", "F": force, "L": force, "A": area}

    def residuals(self, result: Computed) -> Comparison:
        """The curves of a Result beside the measured ones; see `comparison.compared`. Raises ValueError."""
        from .comparison import compared

        return compared(self, result)

    @property
    def seen(self) -> float:
        """The least drop of F_bar that the data show as a slip; infinite where they show none."""
        if not self.slips:
            return np.inf
        steps = np.diff(self.values["F_bar"])
        return max(JUMP * self.noise["F_bar"], min(SUDDEN * float(np.median(np.abs(steps))), ALONE * _rise(steps)))

    @staticmethod
    def of(
        U_x: NDArray[np.float64],
        values: dict[str, NDArray[np.float64]],
        noise: dict[str, float] | None = None,
        unit: float | None = None,
        notes: tuple[str, ...] = (),
        width: float | None = None,
        said: dict[str, str] | None = None,
    ) -> Measurement:
        """A Measurement from arrays; estimates the noise {name: standard deviation} of quantities not in `noise`.

        Raises DataError for fewer than FEWEST points and for a constant force.
        """
        F = values["F_bar"]
        if len(U_x) < FEWEST:
            raise DataError(f"points: {len(U_x)}; needed: {FEWEST} or more; measure more densely")
        if not np.ptp(F) > 0.0:
            raise DataError(f"F is {F[0]:g} at every point; needed: a force that changes; check the column F")
        drops = drops_of(F)
        noise = {name: noise_of(y, drops) for name, y in values.items()} | (noise or {})
        return Measurement(U_x, values, noise, slips_of(F, noise["F_bar"]), unit, notes, width, said or {})


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
    return np.flatnonzero(steep | (steps < -ALONE * np.maximum(beside, _rise(steps))))


def slips_of(F: NDArray[np.float64], noise: float) -> tuple[int, ...]:
    """First indices after the slips: those of `drops_of` that exceed the noise (standard deviation of F)."""
    return tuple(int(i) + 1 for i in drops_of(F) if F[i] - F[i + 1] > JUMP * noise)


def _rise(steps):
    """The 90 % quantile of rising steps; 0 without any."""
    rises = steps[steps > 0.0]
    # the largest rises may be noise
    return float(np.quantile(rises, 0.9)) if rises.size else 0.0
