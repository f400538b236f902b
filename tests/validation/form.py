"""One comparison of the solver with a published solution."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Form:
    """A closed form: the relative error reached, the largest one allowed and its reason, the source."""

    name: str
    error: float
    tolerance: float
    reason: str
    source: str

    @property
    def held(self) -> bool:
        """Whether the error is within its tolerance."""
        return bool(self.error <= self.tolerance)


def relative(computed, expected) -> float:
    """The largest deviation over the largest expected magnitude."""
    expected = np.asarray(expected, float)
    return float(np.abs(np.asarray(computed, float) - expected).max() / np.abs(expected).max())
