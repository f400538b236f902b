"""A measured curve beside that of a computed run, point by point, and how far they are apart."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ..text import counted
from .noise import drops_of, noise_of

if TYPE_CHECKING:
    from ..run.frame import Frame
    from ..scene import Scene

Floats = NDArray[np.float64]
WAY = {"approach": "approach", "retract": "unload"}  # stages of a run for segments of a load
PLACE = 1e-3  # of what the run covers: closer points are at one place
TRIALS = 200  # zeros of delta that are tried: a step is a hundredth of what the run covers


class Computed(Protocol):
    """What a curve is compared with, such as a Result: the Frames of a run, and its first slip or None."""

    @property
    def scene(self) -> Scene: ...
    @property
    def frames(self) -> Sequence[Frame]: ...
    @property
    def first_slip(self) -> Any: ...


class Measured(Protocol):
    """What is compared: a Measurement or a Recording."""

    @property
    def kind(self) -> str: ...
    @property
    def over(self) -> str: ...
    @property
    def segments(self) -> Sequence[Any]: ...
    @property
    def units(self) -> dict[str, str]: ...
    @property
    def free(self) -> bool: ...
    @property
    def virgin(self) -> bool: ...


class NoStage(ValueError):
    """The run has no stage like a segment of the curve; path: a parameter `path` whose runs have one."""

    def __init__(self, reason: str, path: str) -> None:
        super().__init__(f"{reason}; compute it with path={path!r}")
        self.path = path


class Comparison(NamedTuple):
    """rows: (segment, x, quantity, measured, computed) of every point, x as computed, both in the unit of the run.

    rms: {quantity: root mean square of the difference, of points within the run}; noise: {quantity: noise of the
    measured points}; units of both, N/m or nm, or relative. outside: points beyond the run, beside its nearest
    value. shift: nm added to delta of an instrument, whose zero is free. scale, zero: of forces in N, whose width
    is unknown: N/m per N, and N/m added.
    """

    rows: list[tuple[str, float, str, float, float]]
    rms: dict[str, float]
    noise: dict[str, float]
    units: dict[str, str]
    outside: int = 0
    shift: float = 0.0
    scale: float = 1.0
    zero: float = 0.0

    def __repr__(self) -> str:
        lines = [
            f"{name}: {rms:.3g} {self.units[name]} apart (rms), {rms / self.noise[name]:.3g} times the noise"
            for name, rms in self.rms.items()
        ]
        lines += [f"{counted(self.outside, 'point')} of {len(self.rows)} beyond the run"] * (self.outside > 0)
        lines += [f"delta shifted by {self.shift:.4g} nm, to where the curves are nearest"] * (self.shift != 0.0)
        scaled = f"forces times {self.scale:.4g} (N/m per N), plus {self.zero:.4g} N/m, to where the curves are nearest"
        return "\n".join([*lines, *[scaled] * (self.scale != 1.0)])


def compared(measured: Measured, result: Computed) -> Comparison:
    """Compares every measured point with the run, linearly between its increments.

    Segments are compared with the stages that go the same way; a hold with none. Forces over F_s or w E, and areas over
    A_0 or w, are compared as such. The zero of an instrument's delta, and a factor and a zero of forces in N, are those
    with the least squares.

    Parameters: measured: of `read_measurement`; result: of `simulate`.
    Returns a Comparison. Raises ValueError where the run has no stage like a segment, or where no zero and positive
    factor bring half of the points over the run.

    Example: `read_measurement(Scene(), "measured.csv").residuals(simulate(Scene()))`
    """
    pairs = [(segment, _curve(measured, result, k)) for k, segment in enumerate(_moving(measured))]
    shift = _shift(measured, pairs) if measured.free else 0.0
    _reject_few(measured, pairs, shift)
    scale, zero = _scale(measured, pairs, shift)
    if scale <= 0.0:
        raise ValueError(f"a scale of {scale:.3g} brings the forces nearest to the run; turn their sign")
    rows, off, outside = _differences(measured, pairs, shift, scale, zero)
    rms = {name: float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) for name, parts in off.items()}
    units = {name: "N/m" if measured.units[name] == "N" else measured.units[name] for name in off}
    noise = {name: noise_in(measured, name) * (abs(scale) if measured.units[name] == "N" else 1.0) for name in off}
    return Comparison(rows, rms, noise, units, outside, shift, scale, zero)


def _differences(measured, pairs, shift, scale, zero):
    """(rows as of a Comparison, {quantity: differences within the run}, points outside); ValueError for all outside."""
    rows, off, outside = [], {}, 0
    for segment, (x, curves) in pairs:
        at = segment.x + shift
        if measured.units.get(measured.over) == "N":
            at = scale * at + zero
        inside = (at >= x.min()) & (at <= x.max())
        outside += int((~inside).sum())
        for name, y in segment.values.items():
            seen, found = (scale * y + zero if measured.units[name] == "N" else y), np.interp(at, x, curves[name])
            columns = at.tolist(), [name] * at.size, seen.tolist(), found.tolist()
            rows += [(segment.name, *row) for row in zip(*columns, strict=True)]
            off.setdefault(name, []).append((seen - found)[inside])
    if outside == sum(segment.x.size for segment, _ in pairs):
        remedy = f"compute one that covers {measured.over} of the curve, or read a part of it, part=(from, to)"
        raise ValueError(f"no point lies within the run; {remedy}")
    return rows, off, outside


def noise_in(measured: Measured, name: str) -> float:
    """Standard deviation of the noise of a quantity in all segments together, in the unit of the curve."""
    parts = [segment.values[name] for segment in _moving(measured)]
    return float(np.sqrt(np.mean([noise_of(y, drops_of(y)) ** 2 for y in parts])))


def _moving(measured):
    return [segment for segment in measured.segments if segment.name != "hold"]


def _curve(measured, result, k):
    """(x ascending (n,), {name: (n,)}) of the stage of a Result for the k-th moving segment, in units of `measured`."""
    segments, kind = _moving(measured), measured.kind
    frames = _stage(measured, segments, result, k)
    if len(frames) < 2:
        reason = f"the run has no stage for the segment {segments[k].name!r} of a curve of kind {kind!r}"
        raise NoStage(reason, {"load": "unload", "loop": "loop"}.get(kind, "shear"))
    over = measured.over
    columns = {name: np.array([getattr(f, name) for f in frames]) for name in {over, *segments[k].values}}
    columns = {name: y / unit_in(measured.units.get(name, "nm"), result) for name, y in columns.items()}
    order = np.argsort(columns[over], kind="stable")
    return columns[over][order], {name: y[order] for name, y in columns.items()}


def _stage(measured, segments, result, k):
    """The frames of the stage of a Result that the k-th segment is compared with."""
    kind = measured.kind
    stages = [list(group) for _, group in groupby(result.frames, key=lambda frame: frame.stage)]
    segment = segments[k]
    if kind == "load":
        earlier = any(each.name == "retract" for each in segments[:k])
        wanted = "reload" if segment.name == "approach" and earlier else WAY.get(segment.name)
        return next((frames for frames in stages if frames[0].stage.kind == wanted), [])
    if kind == "area over load":
        return stages[0] if stages else []
    slides = [frames for frames in stages if frames[0].stage.moves == "U_x"]
    if kind == "area over force":  # up to the first slip
        first = result.first_slip
        end = first.U_s if first else np.inf
        return [frame for frame in slides[0] if frame.U_x <= end] if slides else []
    same = [frames for frames in slides if (frames[0].stage.kind == "back") == (segment.name == "back")]
    if (kind != "loop" or measured.virgin) and k < len(slides) and slides[k] in same:
        return slides[k]
    return same[-1] if same else []


def unit_in(unit: str, result: Computed) -> float:
    """What numbers of a run, in N/m and nm, are divided by to have a unit of a curve."""
    scene, first = result.scene, result.first_slip
    if unit == "F_s":
        return first.F_s if first else max(abs(frame.F) for frame in result.frames)
    if unit == "A_0":
        return next((frame.A for frame in result.frames if frame.stage != "approach"), 0.0) or 1.0
    return {"w E": scene.width * scene.E, "w": scene.width}.get(unit, 1.0)


def _scale(measured, pairs, shift):
    """(factor, zero) of forces in N with the least squares; (1, 0) where there are none, or no area over one."""
    names = [name for name, unit in measured.units.items() if unit == "N"]
    if not names:
        return 1.0, 0.0
    if measured.over in names:  # the largest force of both
        largest = [(np.abs(segment.x).max(), np.abs(x).max()) for segment, (x, _) in pairs]
        return float(max(found for _, found in largest) / max(seen for seen, _ in largest)), 0.0
    seen, found = np.hstack(
        [both for segment, (x, curves) in pairs for name in names for both in [_both(segment, name, x, curves, shift)]]
    )
    scale, zero = np.linalg.lstsq(np.column_stack([seen, np.ones(seen.size)]), found, rcond=None)[0]
    return float(scale), float(zero)


def _reject_few(measured, pairs, shift):
    """Raises ValueError where a scale and a zero of forces in N have too few places inside the run."""
    if "N" not in measured.units.values() or measured.units.get(measured.over) == "N":
        return
    at, run = np.concatenate([segment.x + shift for segment, _ in pairs]), np.concatenate([x for _, (x, _) in pairs])
    inside = at[(at >= run.min()) & (at <= run.max())]
    if np.unique(np.round(inside / (PLACE * np.ptp(run)))).size < 3:
        raise ValueError(f"a scale and a zero need three points at different places inside the run: {_spans(at, run)}")


def _spans(at, run):
    """Both ranges, and the remedy."""
    curve, computed = (f"{x.min():.4g} .. {x.max():.4g} nm" for x in (at, run))
    remedy = "read a part of the curve that is as long as the run, part=(from, to), or compute a longer run"
    return f"the curve covers {curve}, the run {computed}; {remedy}"


def _both(segment, name, x, curves, shift):
    """(measured, computed) values (2, k) of the points of a Segment within the run, at a shift."""
    at = segment.x + shift
    inside = (at >= x.min()) & (at <= x.max())
    return np.array([segment.values[name][inside], np.interp(at[inside], x, curves[name])])


def _shift(measured, pairs):
    """nm to add to x of an instrument, with the least squares. Raises ValueError where none brings half of it there."""
    low, high = min(x.min() for _, (x, _) in pairs), max(x.max() for _, (x, _) in pairs)
    first, last = min(s.x.min() for s, _ in pairs), max(s.x.max() for s, _ in pairs)
    points = sum(segment.x.size * len(segment.values) for segment, _ in pairs)

    def apart(shift):
        every = [_both(segment, name, *curve, shift) for segment, curve in pairs for name in segment.values]
        seen, found = np.hstack(every)
        if 2 * seen.size < points:
            return np.inf
        scale, zero = _scale(measured, pairs, shift)
        if scale <= 0.0:
            return np.inf
        rms = float(np.mean((scale * seen + zero - found) ** 2))
        return rms / (scale if measured.units.get("L") == "N" else 1.0) ** 2

    shifts = np.linspace(low - last, high - first, TRIALS + 1)[1:-1]
    tried = [apart(shift) for shift in shifts]
    best, step = shifts[int(np.argmin(tried))], shifts[1] - shifts[0]
    if min(tried) == np.inf:
        reason = _spans(np.array([first, last]), np.array([low, high]))
        raise ValueError(f"no zero and positive scale bring half of the points over the run: {reason}")
    with np.errstate(invalid="ignore"):  # a parabola through an infinite value
        found = minimize_scalar(
            apart, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-6 * step}
        )
    return float(found.x)
