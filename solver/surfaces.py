"""The undeformed surface of the layer: the `gap` of every Shape gives g0 (nm) at a Scene's nodes.

Gaps are periodic over w; at delta = 0 the undeformed surfaces just touch. For punch and wave g0 = 0 is the lowest point
of the continuous profile: the lowest node is higher unless it lies on a crest. For other shapes it is the lowest node.
The largest gap lies at the ends of the cell, so contact spreads across them last. A measured profile is not moved:
`read_profile` puts its deepest valley there, which means over the node spacing may fill.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .schema import as_number

Floats = NDArray[np.float64]

STEEPEST = 0.3  # slope of a wave or a measured profile; beyond it slopes are not small: 1 - cos of the angle is 5 %
FEWEST_NODES = 8  # to a wavelength of a wave: linear between them, its slope is right to 3 %
FEWEST_POINTS = 2 * FEWEST_NODES  # of a measured profile: two waves
LENGTHS = (1.0, 1e6)  # nm, of a measured profile: the range of a cell's width
PERIOD = "One period: the last point repeats the first"  # in a file that `Profile.to_csv` wrote
EVEN = 1e-6  # of the spacing: points off by no more count as equidistant, as numbers of seven digits are


class DataError(ValueError):
    """An unusable file or profile; the message gives the reason and the call that would read the file, if any.

    line: its number in the file, or None. reason: without line and call. table: the `solver.measured.tables.Table` that
    was seen, or None. call: {argument: value} that would read the file; values not known are `...`. function: what is
    called, up to its first argument. choices: {channel: its name}, where one is asked for.
    """

    def __init__(
        self,
        reason: str,
        line: int | None = None,
        table: Any = None,
        call: dict[str, Any] | None = None,
        choices: Mapping[str, str] | None = None,
    ) -> None:
        self.reason, self.line, self.table, self.call = reason, line, table, call or {}
        self.function, self.choices = "", dict(choices or {})
        super().__init__(reason)

    @property
    def brief(self) -> str:
        """The reason with the line, without a call."""
        return f"line {self.line}: {self.reason}" if self.line else self.reason

    def __str__(self) -> str:
        if not (self.call and self.function):
            return self.brief
        return f"{self.brief}; call {self.function}{''.join(f', {k}={_written(v)}' for k, v in self.call.items())})"


def _written(value):
    """An argument as Python has it, `...` for what is not known."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_written(k)}: {_written(v)}' for k, v in value.items())}}}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_written, value))})"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return "..." if value is ... else f"{value:g}" if isinstance(value, float) else repr(value)


@dataclass(frozen=True)
class Profile:
    """A measured profile: heights z (nm) at equal distances over one period, kept as bytes of float64.

    Parameters: length: the period, nm; heights: a sequence of numbers, nm, or these bytes; notes: how the data were
    processed.
    Raises DataError for fewer than FEWEST_POINTS heights, for one that is not finite, for a length outside LENGTHS,
    and for a slope over STEEPEST, also across the end of the period.

    Example: `Profile(100.0, np.sin(2 * np.pi * np.arange(200) / 200))`
    """

    length: float
    heights: ArrayLike = field(repr=False)
    notes: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", _length(self.length))
        if not isinstance(self.heights, bytes):
            object.__setattr__(self, "heights", _heights(self.heights))
        object.__setattr__(self, "notes", tuple(self.notes))
        if (size := len(bytes(self.heights))) % 8:  # type: ignore[arg-type]
            raise DataError(f"heights = {size} bytes: allowed: 8 for each float64; give numbers")
        if self.z.size < FEWEST_POINTS:
            raise DataError(f"heights: {self.z.size} points; allowed: {FEWEST_POINTS} or more; give more of them")
        if not np.isfinite(self.z).all():
            k = int(np.argmin(np.isfinite(self.z)))
            raise DataError(f"heights[{k}] = {self.z[k]:g}: allowed: finite numbers, in nm; leave it out")
        with np.errstate(over="ignore"):  # an infinite slope is too steep as well
            slope = np.abs(np.diff(self.z, append=self.z[0])).max() / (self.length / self.z.size)
        if slope > STEEPEST * (1.0 + 4.0 * EVEN):  # distances may have been off by EVEN
            reason = f"heights: the largest slope is {slope:.3g}; allowed: up to {STEEPEST:g}; smooth or rescale them"
            raise DataError(reason)

    @property
    def z(self) -> Floats:
        """Heights, nm, (points,); read-only."""
        return np.frombuffer(cast(bytes, self.heights), "<f8")

    def to_csv(self, file: str | PathLike[str]) -> None:
        """Writes x and z (nm) of one period, whose last point repeats the first; `read_profile` reads the same Profile.

        file: a path.
        """
        x = np.arange(self.z.size + 1) * (self.length / self.z.size)
        x[-1] = self.length
        rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), [*self.z.tolist(), float(self.z[0])], strict=True))
        heading = f"# Lateral units: nm\n# Value units: nm\n# {PERIOD}\nx (nm),z (nm)\n"
        Path(file).write_text(heading + rows, encoding="utf-8")


def _length(value):
    """A Profile's length as a float."""
    length = as_number(value)
    if not LENGTHS[0] <= length <= LENGTHS[1]:  # nan fails it too
        allowed = f"{LENGTHS[0]:g} .. {LENGTHS[1]:g} nm"
        raise DataError(f"length = {value!r}: allowed: {allowed}; give a number in that range")
    return length


def _heights(values):
    """The bytes of a row of numbers."""
    try:
        heights = np.asarray(values).astype("<f8", casting="same_kind")
    except (TypeError, ValueError):
        heights = None
    if heights is None or heights.ndim != 1:
        raise DataError("heights: allowed: one row of real numbers, in nm; give a list or a one-dimensional array")
    return heights.tobytes()


def averaged(x: Floats, z: Floats, points: int) -> Floats:
    """Means (points,) of the profile linear between x, z (n,), each over the spacing around an equidistant position.

    Waves shorter than the new spacing are averaged away; sampling would alias them into long ones. The last point is
    the first of the next period.
    """
    x, level = x - x[0], z.mean()
    z, gaps = z - level, np.diff(x)
    integral = np.append(0.0, np.cumsum(0.5 * gaps * (z[1:] + z[:-1])))
    spacing = x[-1] / points
    turns, at = np.divmod((np.arange(points + 1) - 0.5) * spacing, x[-1])
    k = np.minimum(np.searchsorted(x, at, "right") - 1, gaps.size - 1)
    beyond = at - x[k]
    sums = turns * integral[-1] + integral[k] + beyond * (z[k] + 0.5 * beyond * (np.diff(z) / gaps)[k])
    return level + np.diff(sums) / spacing


def circular(scene: Any) -> Floats:
    """(x - w/2)^2 / (2R), the protrusion of the paper."""
    from_middle = (np.arange(scene.nodes) - scene.nodes / 2) * scene.spacing  # even to the last bit
    return from_middle**2 / (2.0 * scene.radius * scene.width)


def flat(scene: Any) -> Floats:
    """0."""
    return np.zeros(scene.nodes)


def wave(scene: Any) -> Floats:
    """amplitude (1 + cos(2 pi waves x/w)), twice the amplitude from crest to trough."""
    k = (np.arange(scene.nodes) * scene.waves) % scene.nodes
    k = np.minimum(k, scene.nodes - k)  # even to the last bit
    return scene.amplitude * (1.0 + np.cos(2.0 * np.pi * k / scene.nodes))


def _wave_refused(scene):
    """See `Shape.refused`."""
    most = scene.nodes // FEWEST_NODES
    if scene.waves > most:
        return "waves", f"allowed: 1 .. {most}, {FEWEST_NODES} nodes to a wavelength", "lower it, or enlarge nodes"
    highest = STEEPEST * scene.width / (2.0 * np.pi * scene.waves)
    if scene.amplitude > highest:
        return "amplitude", f"allowed: up to {highest:.4g} nm, where the slope is {STEEPEST:g}", "lower it, or waves"
    return None


def rough(scene: Any) -> Floats:
    """Self-affine: C(q) ~ q^(-1-2H) from roll-off to cut-off, constant below, 0 above; random phases.

    The sum of cosines with amplitudes sqrt(C) at q = 2 pi k/w, scaled to the exact rms slope. Mode k has the same phase
    at any cut-off and number of nodes.
    """
    k = np.arange(1, int(1.0 / scene.cut_off + 1e-9) + 1)
    # from the generator's raw bits, which are the same in every version of NumPy
    phases = 2.0 * np.pi * (np.random.Philox(key=scene.seed).random_raw(k.size) >> np.uint64(11)) * 2.0**-53
    amplitude = np.maximum(k, 1.0 / scene.roll_off) ** (-0.5 - scene.hurst)
    slope = np.sqrt(0.5 * np.sum((2.0 * np.pi * k / scene.width * amplitude) ** 2))
    spectrum = np.zeros(scene.nodes // 2 + 1, complex)
    spectrum[k] = 0.5 * scene.nodes * scene.rms_slope / slope * amplitude * np.exp(1j * phases)
    gap = np.fft.irfft(spectrum, scene.nodes)
    return np.roll(gap - gap.min(), -int(np.argmax(gap)))


def _rough_refused(scene):
    least = 4 / scene.nodes  # two node spacings to half a wave
    if scene.cut_off < least:
        return "cut_off", f"allowed: {least:.4g} .. 1 w, 4 node spacings or more", "enlarge it, or nodes"
    if scene.cut_off > scene.roll_off:
        return "cut_off", f"allowed: up to roll_off = {scene.roll_off:g}", "lower it, or enlarge roll_off"
    return None


def measured(scene: Any) -> Floats:
    """Highest z minus z: the profile's summits face the substrate; linear between its points.

    With fewer nodes than points, each node has the mean over the node spacing.
    """
    z = scene.measured.z
    at, depth = np.arange(z.size + 1), np.append(z.max() - z, z.max() - z[0])
    if z.size > scene.nodes:
        gap = averaged(at, depth, scene.nodes)
    else:
        gap = np.interp(np.arange(scene.nodes) * (z.size / scene.nodes), at, depth)
    return gap - gap.min()


def _measured_refused(scene):
    if scene.measured is None:
        return (
            "surface",
            "it needs a profile",
            "give one: profile=FILE on the command line, measured=read_profile(...) in Python",
        )
    length = scene.measured.length
    if abs(scene.width - length) > 1e-9 * length:
        return "width", f"allowed: the profile's {length!r} nm", "set that width, or read the profile with yours"
    return None


@dataclass(frozen=True)
class Shape:
    """A value of the parameter `surface`.

    gap: from a Scene to g0 of its nodes, nm, (nodes,). parameters: the fields of Scene that only this shape reads.
    refused: from a Scene to (parameter, what is allowed, remedy) if it cannot be built, else None.
    """

    meaning: str
    gap: Callable[[Any], Floats]
    parameters: tuple[str, ...] = ()
    refused: Callable[[Any], tuple[str, str, str] | None] = lambda scene: None


SURFACES = {
    "circular": Shape("the paper's cylindrical punch", circular, ("radius",)),
    "flat": Shape("flat on flat", flat),
    "wave": Shape("a cosine", wave, ("amplitude", "waves"), _wave_refused),
    "rough": Shape("self-affine", rough, ("rms_slope", "hurst", "roll_off", "cut_off", "seed"), _rough_refused),
    "measured": Shape("a profile from a file", measured, ("measured",), _measured_refused),
}


@lru_cache(maxsize=8)
def undeformed_gap(scene: Any) -> Floats:
    """g0 of every node, nm, (nodes,). The array is kept: copy it before changing it."""
    return SURFACES[scene.surface].gap(scene)
