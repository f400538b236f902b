"""Measured curves in segments: approach, hold and retract of a load, forth and back of a slide, area over a force."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..run.frame import STAGES, Stage
from ..surfaces import DataError
from .comparison import Comparison, compared
from .noise import FEWEST

Floats = NDArray[np.float64]
BACK = 0.05  # of the range of x: a way back that is longer is another segment, a shorter one is noise
STILL, LASTING = 1e-3, 0.02  # of the range of x, and of the points: so many within so little are a hold
VIRGIN = 0.1  # of the amplitude
KINDS = {
    **{"friction": "U_x", "loop": "U_x", "area over displacement": "U_x"},
    **{"load": "delta", "area over force": "F", "area over load": "L"},
}

PARTS = {  # words for a segment
    "approach": ("approach", "extend", "loading", "false", "0"),
    "retract": ("retract", "withdraw", "unloading", "true", "1"),
    "hold": ("hold", "pause", "dwell", "intermediate", "2"),
    "forth": ("forth", "trace", "forward"),
    "back": ("back", "retrace", "backward"),
}
PART_OF = {word: part for part, words in PARTS.items() for word in words}
OF_STAGE = {"unload": "retract", "reload": "approach", "shear": "forth", "move": "forth"}  # others keep their name


class Segment(NamedTuple):
    """A part of a measured curve in which x goes one way: approach, hold, retract, forth, back or shear.

    x (k,) in the order measured: U_x or delta in nm, or a force. values: {"F", "L" or "A": (k,)}.
    """

    name: str
    x: Floats
    values: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured curve of one of KINDS, in Segments.

    units: {"U_x", "delta", "F", "L", "A": unit}; forces are in N/m, or in N where the width across the pull is not
    known; "F_s" and "A_0": over the largest. free: whether the zero of x is that of the instrument. said: what the file
    says above its columns. notes: what it has that was not used, and how the rest was read. lever: stiffness, N/m, that
    the file says of a lever whose deflection is in delta.
    """

    kind: str
    segments: tuple[Segment, ...]
    units: dict[str, str]
    free: bool = False
    said: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    lever: float | None = None

    @property
    def over(self) -> str:
        """What the curve is over: U_x, delta, F or L."""
        return KINDS[self.kind]

    @property
    def virgin(self) -> bool:
        """Whether a loop begins with the first pull, near U_x = 0."""
        reach = max(float(np.abs(each.x).max()) for each in self.segments)
        return abs(float(self.segments[0].x[0])) <= VIRGIN * reach

    @property
    def unfit(self) -> str:
        """Why no fit takes it, with the remedy; "" for a loop in N/m."""
        force = self.units.get("F", "")
        if self.kind not in ("friction", "loop"):
            taken = "a fit takes friction over displacement, or a loop of it"
            return f"this is {self.kind}; {taken}; compare it by measured.residuals(result)"
        if force == "N":
            remedy = "divide it by the width of the contact across the pull, or give force= (N/m per unit)"
            return f"F is in N, and a fit needs N/m; {remedy}"
        return "" if force == "N/m" else f"F is over {force}, and a fit needs N/m or F_bar; convert it"

    def residuals(self, result: Any) -> Comparison:
        """The curves of a Result beside the measured ones; see `comparison.compared`. Raises ValueError."""
        return compared(self, result)


def turns_of(x: Floats) -> list[int]:
    """Indices of the first point of x (n,), of each extremum from which it goes back by BACK of its range, the last."""
    least, turns, extreme = BACK * float(np.ptp(x)), [0], 0
    up = x[np.argmax(np.abs(x - x[0]) > least)] >= x[0]
    for k, at in enumerate(x):
        if (at > x[extreme]) if up else (at < x[extreme]):
            extreme = k
        elif abs(at - x[extreme]) > least:
            turns.append(extreme)
            up, extreme = not up, k
    return [*turns, len(x) - 1]


def parts_of(x: Floats, up: str, down: str) -> list[tuple[str, NDArray[np.int_]]]:
    """[(name, indices)] of the segments of x (n,): `up` where it ascends, `down` where it descends, "hold" between.

    Raises DataError for a segment of fewer than FEWEST points, as unsorted lines make.
    """
    turns, parts, begin = turns_of(x), [], 0
    for before, turn in pairwise(turns):
        first, last = _still(x, turn)
        held = last - first >= max(FEWEST, LASTING * x.size)
        end = first if held else turn + 1
        if end - begin < FEWEST and len(turns) > 2:
            reason = f"{x[turn]:g} after {end - begin} points is a turn"
            raise DataError(f"{reason}; sort the lines, or measure {FEWEST} points or more each way")
        parts.append((up if x[turn] >= x[before] else down, np.arange(begin, end)))
        parts += [("hold", np.arange(first, last + 1))] * held
        begin = last + 1 if held else turn + 1
    return parts


def _still(x, turn):
    """(first, last) index of the points around a turn that are as good as there."""
    apart = np.flatnonzero(np.abs(x - x[turn]) > STILL * np.ptp(x))
    k = np.searchsorted(apart, turn)
    return int(apart[k - 1]) + 1 if k else 0, int(apart[k]) - 1 if k < apart.size else x.size - 1


def sliding(stages: Iterable[object]) -> list[str]:
    """The stages of a column that move U_x to and fro, in order."""
    words = dict.fromkeys(map(str, stages))
    return [each for each in words if Stage(each).kind in STAGES and Stage(each).moves == "U_x"]


def part_named(text: str) -> str | None:
    """The name of a segment, from a cell; None for an unknown word."""
    kind = Stage(text).kind
    return OF_STAGE.get(kind, kind) if kind in STAGES else PART_OF.get(text.strip().lower())
