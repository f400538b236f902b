"""Error against run time for one scene: the tolerance and the increment that are worth their cost.

for progress, report in measure(Scene(delta_bar=0.4), quick=True): ...
print(sentence(report))
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import ceil

from ..run.loadpath import load_path
from ..scene import Scene, SceneError
from .compare import Point, Run, compare, perform, ratio, reference, refined
from .landings import Landings, landings, scene_for
from .methods import SERIES

# The values swept with fast: nm; and factors of the scene's own du_x
SWEEPS = {
    "tolerance": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
    "du_x": (0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
}
COST = {"fast": 1.0, "gfmd": 25.0, "gfmd mass-weighted": 6.0, "FIRE": 6.0}  # of a run in the progress shown
PREPARED = 20.0  # the same for the reference and the landings
LEAST = {"seconds": 1e-4, "evaluations": 1, "error": 1e-13}  # drawn on logarithmic axes, which have no zero


@dataclass(frozen=True)
class Effort:
    """How much is measured: times for a quick look while a visitor waits, or for a minute of one core."""

    slips: int  # in shear, after which the runs end
    longest: float  # s for one run
    repeats: int  # of a run of fast, which is short: the shortest time counts
    landing: float  # nm, tolerance of the landings: branches lie compare.SAME_BRANCH apart
    longest_landing: float  # s
    finer: bool  # whether landings are compared with those at half the time step
    values: dict = field(default_factory=dict)  # {series: {sweep: values}}, as in SWEEPS; fast: SWEEPS


_SLOW = {"tolerance": (1e-3, 1e-4, 1e-6, 1e-8), "du_x": (1.0, 2.0, 5.0)}
_QUICK = {series: {"tolerance": (1e-4,) if series == "gfmd" else (1e-4, 1e-6)} for series in SERIES}
FULL = Effort(2, 20.0, 3, 1e-6, 40.0, True, {series: _SLOW for series in SERIES} | {"fast": SWEEPS})
QUICK = Effort(1, 4.0, 2, 1e-5, 8.0, False, _QUICK | {"fast": SWEEPS})


@dataclass(frozen=True)
class Report:
    """Work and precision of a scene: `points` so far, against the reference's slips [(stage, load, F_bar)]."""

    scene: Scene  # as asked for
    quick: bool
    horizon: float  # nm: the runs end there, beyond `slips` slips
    slips: int
    tolerance: float  # nm, of the reference
    steps: tuple[float, float]  # (du_x, du_z) of the reference
    seconds: float  # of the reference
    known_slips: tuple
    landings: Landings  # of the reference
    safe_damping: float = 0.0  # the largest of the reference's frames
    points: tuple[Point, ...] = ()

    def of(self, sweep: str, series: str | None = None) -> list[Point]:
        """Points of a sweep, of one series or of all."""
        return [p for p in self.points if p.sweep == sweep and series in (None, p.series)]


def measure(scene: Scene, quick: bool = False, slips: int | None = None) -> Iterator[tuple[float, Report | None]]:
    """Yield (progress 0..1, Report so far or None) after each run; raises NotConverged, SceneError.

    slips: runs end just beyond so many slips (default 2, quick 1), or at the scene's u_x_max.
    """
    yield 0.0, None
    effort = QUICK if quick else FULL
    slips = slips or effort.slips
    short = shortened(scene.changed(path="shear", hold="delta"), slips)  # every method knows these
    grid = scene_for(short, effort.landing)
    known = reference(short, grid)
    right, landed = landings(grid, known, effort.longest_landing, effort.finer)
    fine, events = known.scene, tuple((event.stage, event.load, event.F_bar) for event in known.slips)
    made = fine.tolerance, (fine.du_x, fine.du_z), known.seconds
    report = Report(scene, quick, short.u_x_max, slips, *made, events, landed, known.safe_damping)
    runs = plan(short, effort)
    total, done = sum(COST[run.series] for run in runs) + PREPARED, PREPARED
    finished, stopped = {}, set()  # {(series, scene): Curves}, as the scene's own values belong to every sweep
    for run in runs:
        key, kin = (run.series, run.scene), (run.sweep, run.series)
        if key not in finished and kin in stopped:
            point = Point(*kin, run.value, failure="left out: a cheaper run was stopped")
        else:
            finished[key] = finished.get(key) or perform(run, right, effort.longest)
            point = compare(run, finished[key], known, right)
            stopped |= {kin} if finished[key].stopped else set()
        done, report = done + COST[run.series], replace(report, points=(*report.points, point))
        yield done / total, report


def shortened(scene: Scene, slips: int) -> Scene:
    """The scene up to just beyond its first slips, on the grid of the longest increment."""
    seen, end, longest = 0, scene.u_x_max, _values(scene, "du_x", SWEEPS["du_x"])[0] * scene.delta_t
    for frame in load_path(scene):
        seen += len(frame.slips) if frame.stage == "shear" else 0
        if seen >= slips:
            end = min(end, (ceil(frame.U_x / longest - 1e-9) + 1) * longest)
            break
    return scene.changed(u_x_max=end)


def _values(scene, sweep, values):
    """The values of a sweep, the cheapest first, in range and with increments that the reference's divide."""
    fine, possible = refined(scene), []
    if sweep == "du_x":
        values = [round(factor * scene.du_x, 12) for factor in values]
    for value in sorted(values, reverse=True):
        try:
            changed = scene.changed(**{sweep: value})
        except SceneError:
            continue
        if ratio(changed, fine):
            possible.append(value)
    return possible


def plan(scene: Scene, effort: Effort) -> list[Run]:
    """The Runs to measure, cheap ones first within each sweep and series."""
    return [
        Run(sweep, series, value, scene.changed(**{sweep: value}), effort.repeats if series == "fast" else 1)
        for sweep in SWEEPS
        for series in SERIES
        if sweep in effort.values[series]
        for value in _values(scene, sweep, effort.values[series][sweep])
    ]
