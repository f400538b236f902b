"""A measured friction curve: cut at its slips, its noise estimated."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..surfaces import DataError
from .comparison import Comparison, compared
from .noise import ALONE, FEWEST, JUMP, SUDDEN, drops_of, noise_of, rise_of, slips_of
from .recording import Segment


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
    over: ClassVar[str] = "U_x"
    virgin: ClassVar[bool] = True
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

    def residuals(self, result: Any) -> Comparison:
        """The curves of a Result beside the measured ones; see `comparison.compared`. Raises ValueError."""
        return compared(self, result)

    @property
    def seen(self) -> float:
        """The least drop of F_bar that the data show as a slip; infinite where they show none."""
        if not self.slips:
            return np.inf
        steps = np.diff(self.values["F_bar"])
        return max(JUMP * self.noise["F_bar"], min(SUDDEN * float(np.median(np.abs(steps))), ALONE * rise_of(steps)))

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
