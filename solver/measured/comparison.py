"""A measured curve beside that of a computed run, point by point, and how far they are apart."""

from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ..text import counted
from .noise import drops_of, noise_of

Floats = NDArray[np.float64]
WAY = {"approach": "approach", "retract": "unload"}  # stages of a run for segments of a load
PLACE = 1e-3  # of what the run covers: closer points are at one place
TRIALS = 200  # zeros of delta that are tried: a step is a hundredth of what the run covers


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


class Pair(NamedTuple):
    """A Segment, and the stage of a run beside it in the units of the curve: x ascending (n,), {quantity: (n,)}."""

    segment: Any
    x: Floats
    curves: dict[str, Floats]

    def within(self, at: Floats) -> NDArray[np.bool_]:
        """Which places (k,) are within the run."""
        return (at >= self.x.min()) & (at <= self.x.max())

    def both(self, name: str, shift: float) -> Floats:
        """(measured, computed) values (2, k) of the points within the run, at a shift."""
        at = self.segment.x + shift
        inside = self.within(at)
        return np.array([self.segment.values[name][inside], np.interp(at[inside], self.x, self.curves[name])])


def compared(measured: Any, result: Any) -> Comparison:
    """Compares every measured point with the run, linearly between its increments.

    Segments are compared with the stages that go the same way; a hold with none. Forces over F_s or w E, and areas over
    A_0 or w, are compared as such. The zero of an instrument's delta, and a factor and a zero of forces in N, are those
    with the least squares.

    Parameters: measured: a Measurement or Recording of `read_measurement`; result: of `simulate`, or anything with its
    scene, frames and first_slip.
    Returns a Comparison. Raises ValueError where the run has no stage like a segment, or where no zero and positive
    factor bring half of the points over the run.

    Example: `read_measurement(Scene(), "measured.csv").residuals(simulate(Scene()))`
    """
    segments = [segment for segment in measured.segments if segment.name != "hold"]
    pairs = [_paired(measured, segments, result, k) for k in range(len(segments))]
    shift = _shift(measured, pairs) if measured.free else 0.0
    _reject_few(measured, pairs, shift)
    scale, zero = _scale(measured, pairs, shift)
    if scale <= 0.0:
        raise ValueError(f"a scale of {scale:.3g} brings the forces nearest to the run; turn their sign")
    by = {name: (scale, zero) if unit == "N" else (1.0, 0.0) for name, unit in measured.units.items()}
    rows, off, outside = _differences(measured, pairs, shift, by)
    rms = {name: float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) for name, parts in off.items()}
    units = {name: "N/m" if measured.units[name] == "N" else measured.units[name] for name in off}
    curves = {name: [segment.values[name] for segment in segments] for name in off}
    each = {name: np.mean([noise_of(y, drops_of(y)) ** 2 for y in parts]) for name, parts in curves.items()}
    noise = {name: float(np.sqrt(square)) * by[name][0] for name, square in each.items()}
    return Comparison(rows, rms, noise, units, outside, shift, scale, zero)


def _differences(measured, pairs, shift, by):
    """(rows as of a Comparison, {quantity: differences within the run}, points outside); ValueError for all outside.

    by: {quantity: (factor, zero)} that bring it into the units of the run.
    """
    rows, off, outside, (times, plus) = [], {}, 0, by.get(measured.over, (1.0, 0.0))
    for pair in pairs:
        at = times * (pair.segment.x + shift) + plus
        inside = pair.within(at)
        outside += int((~inside).sum())
        for name, y in pair.segment.values.items():
            seen, found = by[name][0] * y + by[name][1], np.interp(at, pair.x, pair.curves[name])
            columns = [pair.segment.name] * at.size, at.tolist(), [name] * at.size, seen.tolist(), found.tolist()
            rows += zip(*columns, strict=True)
            off.setdefault(name, []).append((seen - found)[inside])
    if outside == sum(pair.segment.x.size for pair in pairs):
        remedy = f"compute one that covers {measured.over} of the curve, or read a part of it, part=(from, to)"
        raise ValueError(f"no point lies within the run; {remedy}")
    return rows, off, outside


def _paired(measured, segments, result, k):
    """The Pair of the k-th of some segments that move."""
    frames = _stage(measured, segments, result, k)
    if len(frames) < 2:
        reason = f"the run has no stage for the segment {segments[k].name!r} of a curve of kind {measured.kind!r}"
        raise NoStage(reason, {"load": "unload", "loop": "loop"}.get(measured.kind, "shear"))
    over = measured.over
    columns = {name: np.array([getattr(f, name) for f in frames]) for name in {over, *segments[k].values}}
    columns = {name: y / unit_in(measured.units.get(name, "nm"), result) for name, y in columns.items()}
    order = np.argsort(columns[over], kind="stable")
    return Pair(segments[k], columns[over][order], {name: y[order] for name, y in columns.items()})


def _stage(measured, segments, result, k):
    """The frames of the stage of a Result that the k-th segment is compared with."""
    kind, segment = measured.kind, segments[k]
    stages = [list(group) for _, group in groupby(result.frames, key=lambda frame: frame.stage)]
    if kind == "load":
        earlier = any(each.name == "retract" for each in segments[:k])
        wanted = "reload" if segment.name == "approach" and earlier else WAY.get(segment.name)
        return next((frames for frames in stages if frames[0].stage.kind == wanted), [])
    if kind == "area over load":
        return stages[0] if stages else []
    slides = [frames for frames in stages if frames[0].stage.moves == "U_x"]
    if kind == "area over force":  # up to the first slip
        end = result.first_slip.U_s if result.first_slip else np.inf
        return [frame for frame in slides[0] if frame.U_x <= end] if slides else []
    same = [frames for frames in slides if (frames[0].stage.kind == "back") == (segment.name == "back")]
    if (kind != "loop" or measured.virgin) and k < len(slides) and slides[k] in same:
        return slides[k]
    return same[-1] if same else []


def unit_in(unit: str, result: Any) -> float:
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
        largest = np.max([(np.abs(pair.segment.x).max(), np.abs(pair.x).max()) for pair in pairs], axis=0)
        return float(largest[1] / largest[0]), 0.0
    seen, found = np.hstack([pair.both(name, shift) for pair in pairs for name in names])
    scale, zero = np.linalg.lstsq(np.column_stack([seen, np.ones(seen.size)]), found, rcond=None)[0]
    return float(scale), float(zero)


def _reject_few(measured, pairs, shift):
    """Raises ValueError where a scale and a zero of forces in N have too few places inside the run."""
    if "N" not in measured.units.values() or measured.units.get(measured.over) == "N":
        return
    at, run = np.concatenate([pair.segment.x + shift for pair in pairs]), np.concatenate([pair.x for pair in pairs])
    inside = at[(at >= run.min()) & (at <= run.max())]
    if np.unique(np.round(inside / (PLACE * np.ptp(run)))).size < 3:
        raise ValueError(f"a scale and a zero need three points at different places inside the run: {_spans(at, run)}")


def _spans(at, run):
    """Both ranges, and the remedy."""
    curve, computed = (f"{x.min():.4g} .. {x.max():.4g} nm" for x in (at, run))
    remedy = "read a part of the curve that is as long as the run, part=(from, to), or compute a longer run"
    return f"the curve covers {curve}, the run {computed}; {remedy}"


def _shift(measured, pairs):
    """nm to add to x of an instrument, with the least squares. Raises ValueError where none brings half of it there."""
    at, run = np.concatenate([pair.segment.x for pair in pairs]), np.concatenate([pair.x for pair in pairs])
    points = sum(pair.segment.x.size * len(pair.segment.values) for pair in pairs)

    def apart(shift):
        seen, found = np.hstack([pair.both(name, shift) for pair in pairs for name in pair.segment.values])
        scale, zero = _scale(measured, pairs, shift) if 2 * seen.size >= points else (0.0, 0.0)
        if scale <= 0.0:
            return np.inf
        rms = float(np.mean((scale * seen + zero - found) ** 2))
        return rms / (scale if measured.units.get("L") == "N" else 1.0) ** 2

    shifts = np.linspace(run.min() - at.max(), run.max() - at.min(), TRIALS + 1)[1:-1]
    tried = [apart(shift) for shift in shifts]
    best, step = shifts[int(np.argmin(tried))], shifts[1] - shifts[0]
    if min(tried) == np.inf:
        raise ValueError(f"no zero and positive scale bring half of the points over the run: {_spans(at, run)}")
    with np.errstate(invalid="ignore"):  # a parabola through an infinite value
        found = minimize_scalar(
            apart, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-6 * step}
        )
    return float(found.x)
