"""Error against run time for one scene: the tolerance and the increment that are worth their cost.

for progress, report in measure(Scene(delta_bar=0.4), quick=True): ...
print(text(report))
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

from ..run.frame import Frame, SlipEvent, largest_safe_damping
from ..run.loadpath import load_path
from ..scene import Scene
from .compare import Method, Point, compare, in_range, perform, recorded, reference

# The values swept with fast: nm; and factors of the scene's own du_x
SWEEPS = {
    "tolerance": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
    "du_x": (0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
}
SERIES: dict[str, Method] = {"fast": "fast", "gfmd": "gfmd"}  # name: method of `load_path`


class Effort(NamedTuple):
    """How much is measured: times for a quick look while a visitor waits, or for a minute of one core."""

    slips: int  # in shear, after which the runs end
    longest: float  # s for one run
    slow: dict  # as SWEEPS, of the methods other than fast


FULL = Effort(2, 20.0, {"tolerance": (1e-3, 1e-4, 1e-6, 1e-8), "du_x": (1.0, 2.0, 5.0)})
QUICK = Effort(1, 4.0, {"tolerance": (1e-4, 1e-6)})


@dataclass(frozen=True)
class Report:
    """Work and precision of a scene: `points` so far, against the reference."""

    scene: Scene  # as measured: with path shear at given delta, up to its own u_x_max
    quick: bool
    slips: int  # the runs end beyond so many
    reference: Scene  # that of the reference
    seconds: float  # of the reference
    known_slips: tuple[SlipEvent, ...]  # of the reference
    safe_damping: float = 0.0  # the largest of the scene's own run
    points: tuple[Point, ...] = ()

    def of(self, sweep: str, series: str | None = None) -> list[Point]:
        """Points of a sweep, of one series or of all."""
        return [p for p in self.points if p.sweep == sweep and series in (None, p.series)]


def measure(
    scene: Scene,
    quick: bool = False,
    slips: int | None = None,
    sweeps: Iterable[str] = tuple(SWEEPS),
    series: Mapping[str, Method] = SERIES,
) -> Iterator[tuple[float, Report | None]]:
    """Yield (progress 0..1, Report so far or None) after each run; raises NotConverged, SceneError.

    The path is shear at given delta, which every method knows, whatever path the scene has.
    slips: runs end just beyond so many slips (default 2, quick 1), or at the scene's u_x_max. series: {name: method}.
    A quick report begins with a point relative to the scene's own run, as the reference takes some seconds.
    """
    yield 0.0, None
    effort = QUICK if quick else FULL
    slips = slips or effort.slips
    scene = scene.changed(path="shear", hold="delta")
    short, frames = shortened(scene, slips)
    planned, safe = plan(short, effort, sweeps, series), largest_safe_damping(frames)
    if quick:
        own, first = recorded(short, iter(frames)), planned[0]
        coarse = perform(short.changed(**{first.sweep: first.value}), series[first.series])
        points = (compare(first, coarse, own),)
        yield 0.0, Report(scene, quick, slips, short, own.seconds, tuple(own.slips), safe, points)
    best = reference(short)
    report = Report(scene, quick, slips, best.scene, best.seconds, tuple(best.slips), safe)
    finished, stopped = {}, set()
    for done, point in enumerate(planned, 1):
        run, kin = (point.series, short.changed(**{point.sweep: point.value})), (point.sweep, point.series)
        if run not in finished and kin in stopped:
            point = replace(point, failure="left out: a cheaper run was stopped")
        else:
            if run not in finished:  # the scene's own values belong to every sweep
                # a run of fast is short: the shortest time of three counts
                repeats = 3 if point.series == "fast" else 1
                finished[run] = perform(run[1], series[point.series], effort.longest, repeats)
            point = compare(point, finished[run], best)
            stopped |= {kin} if finished[run].stopped else set()
        report = replace(report, points=(*report.points, point))
        yield done / len(planned), report


def shortened(scene: Scene, slips: int) -> tuple[Scene, list[Frame]]:
    """(the scene up to just beyond its first slips, on the grid of the longest increment; its frames until then)."""
    seen, end, longest, frames = 0, scene.u_x_max, _values(scene, "du_x", SWEEPS["du_x"])[0] * scene.delta_t, []
    for frame in load_path(scene):
        frames.append(frame)
        seen += len(frame.slips) if frame.stage == "shear" else 0
        if seen >= slips:
            end = min(end, (ceil(frame.U_x / longest - 1e-9) + 1) * longest)
            break
    return scene.changed(u_x_max=end), frames


def _values(scene, sweep, values):
    """The values of a sweep that are in range, the cheapest first."""
    values = [round(value * scene.du_x, 12) if sweep == "du_x" else value for value in values]
    return sorted(in_range(scene, sweep, values), reverse=True)


def plan(
    scene: Scene, effort: Effort, sweeps: Iterable[str] = tuple(SWEEPS), series: Mapping[str, Method] = SERIES
) -> list[Point]:
    """The Points to measure, cheap ones first within each sweep and series."""
    return [
        Point(sweep, name, value)
        for sweep in sweeps
        for name in series
        for value in _values(scene, sweep, (SWEEPS if name == "fast" else effort.slow).get(sweep, ()))
    ]
