"""A measured curve: one stroke of friction cut at its slips, or any curve in segments. Each segment goes one way."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..run.frame import STAGES, Stage
from ..surfaces import DataError
from .comparison import Comparison, compared
from .noise import ALONE, FEWEST, JUMP, SUDDEN, drops_of, noise_of, rise_of, slips_of

Floats = NDArray[np.float64]
BACK = 0.05  # of the range of x: a way back that is longer is another segment, a shorter one is noise
STILL, LASTING = 1e-3, 0.02  # of the range of x, and of the points: so many within so little are a hold
VIRGIN = 0.1  # of the amplitude
OVER = {"load": "delta", "area over force": "F", "area over load": "L"}  # of other kinds: U_x
PARTS = {  # words for a segment
    "approach": ("approach", "extend", "loading", "false", "0"),
    "retract": ("retract", "withdraw", "unloading", "true", "1"),
    "hold": ("hold", "pause", "dwell", "intermediate", "2"),
    "forth": ("forth", "trace", "forward"),
    "back": ("back", "retrace", "backward"),
}
PART_OF = {word: part for part, words in PARTS.items() for word in words}
CODES = "false", "true", "0", "1", "2"  # of PARTS: numbers that some machines write
OF_STAGE = {"unload": "retract", "reload": "approach", "shear": "forth", "move": "forth"}  # others keep their name


class Segment(NamedTuple):
    """A part of a measured curve in which x goes one way: approach, hold, retract, forth, back or shear.

    x (k,) in the order measured: U_x or delta in nm, or a force. values: {"F", "L" or "A": (k,)}.
    """

    name: str
    x: Floats
    values: dict[str, Floats]


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

        One that is 0 throughout is left out, with a note. Raises DataError for fewer than FEWEST points, and for a
        constant force.
        """
        F = values["F_bar"]
        if len(U_x) < FEWEST:
            raise DataError(f"points: {len(U_x)}; needed: {FEWEST} or more; measure more densely")
        if not np.ptp(F) > 0.0:
            raise DataError(f"F is {F[0]:g} at every point; needed: a force that changes; check the column F")
        still = [name for name, y in values.items() if not np.any(y)]  # without noise to compare with
        notes = (*notes, *(f"{name} is 0 at every point: not used." for name in still))
        values = {name: y for name, y in values.items() if name not in still}
        drops = drops_of(F)
        noise = {name: noise_of(y, drops) for name, y in values.items()} | (noise or {})
        return Measurement(U_x, values, noise, slips_of(F, noise["F_bar"]), unit, notes, width, said or {})


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured curve in Segments. kind: friction, loop, load, or area over displacement, force or load.

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
        return OVER.get(self.kind, "U_x")

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


def goes(name: str | None, x: Floats, at: NDArray[np.int_]) -> bool:
    """Whether x (n,) rises, falls or stays in a segment `at` (k,), as its name approach, retract or hold says."""
    rise, least = float(x[at[-1]] - x[at[0]]), BACK * float(np.ptp(x))
    return {"approach": rise > 0.0, "retract": rise < 0.0, "hold": abs(rise) <= least}.get(name or "", True)


def part_named(text: str) -> str | None:
    """The name of a segment, from a cell; None for an unknown word."""
    kind = Stage(text).kind
    return OF_STAGE.get(kind, kind) if kind in STAGES else PART_OF.get(text.strip().lower())
