"""Values of a continuous parameter, even or even in the logarithm."""

from dataclasses import dataclass

import numpy as np

from ...following.follow import SAME
from ...scene import LIMITS, PARAMETERS, SceneError

COUNT = 2, 400  # values; more is a mistake, not a map
FORM = "allowed: NAME=LOW:HIGH:COUNT or NAME=LOW:HIGH:COUNT:log; give one of these"
CONTINUOUS = tuple(name for name, known in LIMITS.items() if name not in SAME and not known.whole)


@dataclass(frozen=True)
class Axis:
    """`count` values of the parameter `name` from `low` to `high`, its unit; raises SceneError."""

    name: str
    low: float
    high: float
    count: int
    log: bool = False

    def __post_init__(self):
        if self.name not in CONTINUOUS:
            raise SceneError("axis", self.name, f"allowed: {', '.join(CONTINUOUS)}", "choose one of them")
        for value in (self.low, self.high):
            PARAMETERS[self.name].checked(self.name, value)
        if not np.isfinite(self.low) or not np.isfinite(self.high) or self.low == self.high:
            raise SceneError(self.name, f"{self.low:g}:{self.high:g}", "allowed: two finite values", "give two values")
        if not COUNT[0] <= self.count <= COUNT[1]:
            raise SceneError(self.name, self.count, f"allowed: {COUNT[0]} .. {COUNT[1]} values", "give such a COUNT")
        if self.log and min(self.low, self.high) <= 0.0:
            raise SceneError(self.name, min(self.low, self.high), "allowed with log: above 0", "raise it, or omit log")

    @staticmethod
    def of(text):
        """From 'phi_ratio=0.02:2:31:log'."""
        name, _, rest = text.partition("=")
        parts = rest.split(":")
        log = parts[3:] == ["log"]
        parts = parts[:3] if log else parts
        try:
            low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
        except (ValueError, IndexError):
            parts = []
        if len(parts) != 3:
            raise SceneError("axis", text, FORM, f"as in {CONTINUOUS[0]}=-1:1:41")
        return Axis(name.strip(), low, high, count, log)

    @property
    def values(self):
        """(count,), to 12 digits: -0.85, not -0.8500000000000001."""
        spaced = np.geomspace if self.log else np.linspace
        return np.array([float(f"{value:.12g}") for value in spaced(self.low, self.high, self.count)])
