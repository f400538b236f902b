"""Error against run time for one scene: which tolerance, steps and window are worth their cost.

for progress, report in measure(Scene(delta_bar=0.4), quick=True): ...
print(sentence(report))
"""

from dataclasses import dataclass, replace
from math import ceil

from ..run.loadpath import load_path
from ..scene import Scene, SceneError
from .compare import Point, Run, compare, perform, ratio, reference, refined
from .landings import Judgement, judge, scene_for
from .methods import SERIES

VISIBLE = 1e-4  # of the largest value: what no plot shows, and no experiment on adhesion resolves
# The values swept; those of du_x and du_z times the scene's own. gfmd and its kin get fewer, they take longer.
SWEEPS = {
    "tolerance": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
    "du_x": (0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
    "du_z": (0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
    "window_n": (6.0, 8.0, 10.0, 12.0, 16.0, 20.0),
    "window_t": (4.0, 4.5, 5.0, 6.0, 8.0),
}
FEWER = {
    "tolerance": (1e-3, 1e-4, 1e-6, 1e-8),
    "du_x": (1.0, 2.0, 5.0),
    "du_z": (1.0, 5.0),
    "window_n": (6.0, 10.0),
    "window_t": (4.0, 5.0),
}
QUICK = {"gfmd": (1e-4,), "gfmd mass-weighted": (1e-4, 1e-6), "FIRE": (1e-4, 1e-6)}  # tolerances; other sweeps: fast
WHOLE_WINDOW = {"window_n": 30.0, "window_t": 10.0}  # for the references of these sweeps: e^-30 is nothing cut off
REACH = 4.0  # of the longest increments beyond a slip, up to where states are compared
LONGEST = {False: 20.0, True: 4.0}  # s for one run; quick or not
SLIPS = {False: 2, True: 1}
REPEATS = {False: 3, True: 2}  # of a run of fast, which is short: the least time counts
COST = {"fast": 1.0, "gfmd": 25.0, "gfmd mass-weighted": 6.0, "FIRE": 6.0}  # of a run in the progress shown
REFERENCE = 3.0  # the same for a reference
JUDGE = {False: 75.0, True: 20.0}  # and for the judge of branches


@dataclass(frozen=True)
class Report:
    """Work and precision of a scene: `points` so far, against the reference's slips [(stage, load, F_bar)]."""

    scene: Scene  # as asked for
    quick: bool
    horizon: float  # nm: the runs end there, beyond `slips` slips
    slips: int
    tolerance: float  # nm, of the reference
    steps: tuple  # (du_x, du_z) of the reference
    seconds: float  # of the reference
    known_slips: tuple
    judgement: Judgement  # of the reference, by GFMD
    safe_damping: float = 0.0  # the largest of the reference's frames
    points: tuple = ()

    def of(self, sweep, series=None):
        """Points of a sweep, of one series or of all."""
        return [p for p in self.points if p.sweep == sweep and series in (None, p.series)]


def measure(scene, quick=False, slips=None):
    """Yield (progress 0..1, Report so far or None), often: stop asking to cancel; raises NotConverged.

    slips: runs end just beyond so many slips (default 2, quick 1), or at the scene's u_x_max.
    """
    yield 0.0, None
    slips = slips or SLIPS[quick]
    short = shortened(scene.changed(path="shear", hold="delta"), slips)  # what every method knows
    runs = plan(short, quick)
    weights = [COST[run.series] for run in runs]
    total, done, known = sum(weights) + REFERENCE * (1 + len(WHOLE_WINDOW)) + JUDGE[quick], 0.0, {}
    every, reach = ratio(scene_for(short, quick), refined(short)), REACH * _coarsest(short)
    for sweep in (None, *WHOLE_WINDOW):
        exact = short.changed(**{sweep: WHOLE_WINDOW[sweep]}) if sweep else short
        known[sweep] = yield from _through(reference(exact, every, reach), done / total, REFERENCE / total, None)
        done += REFERENCE
    judged, judgement = yield from _through(judge(short, known[None], quick), done / total, JUDGE[quick] / total, None)
    done += JUDGE[quick]
    report = _report(scene, quick, slips, short, known[None], judgement)
    finished = {}  # (series, scene): Curves; the scene's own values belong to every sweep
    for run, weight in zip(runs, weights, strict=True):
        against, key = known.get(run.sweep, known[None]), (run.series, run.scene)
        if key not in finished and not _too_long(run, runs, finished):
            work = perform(run, judged, LONGEST[quick])
            finished[key] = yield from _through(work, done / total, weight / total, report)
        done += weight
        point = compare(run, finished[key], against, judged) if key in finished else _left_out(run)
        report = replace(report, points=(*report.points, point))
        yield done / total, report


def _too_long(run, runs, finished):
    """Whether a cheaper run of the same sweep and series was stopped."""
    kin = [finished.get((r.series, r.scene)) for r in runs if (r.sweep, r.series) == (run.sweep, run.series)]
    return any(curves is not None and curves.stopped for curves in kin)


def _left_out(run):
    return Point(run.sweep, run.series, run.value, None, None, failure="left out: a cheaper run was stopped")


def _through(work, start, part, report):
    """Pass on the progress of a generator as (start + part * progress, report); returns what it returns."""
    try:
        while True:
            yield start + part * next(work), report
    except StopIteration as end:
        return end.value


def _report(scene, quick, slips, short, known, judgement):
    fine = known.scene
    events = tuple((stage, event.load, event.F_bar) for stage, event in known.slips)
    steps = (fine.du_x, fine.du_z)
    return Report(
        scene, quick, short.u_x_max, slips, fine.tolerance, steps, known.seconds, events, judgement, known.safe_damping
    )


def shortened(scene, slips):
    """The scene up to just beyond its first slips, on the grid of the coarsest increment."""
    seen, end, coarsest = 0, scene.u_x_max, _coarsest(scene)
    for frame in load_path(scene):
        seen += len(frame.slips) if frame.stage == "shear" else 0
        if seen >= slips:
            end = min(end, (ceil(frame.U_x / coarsest - 1e-9) + 1) * coarsest)
            break
    return scene.changed(u_x_max=end)


def _coarsest(scene):
    """The longest increment of shear tried, nm."""
    return max(_values(scene, "du_x", SWEEPS["du_x"])) * scene.delta_t


def _values(scene, sweep, values):
    """What a sweep sets its parameter to, its own value too, where allowed and divided by the reference's steps."""
    own, found = getattr(scene, sweep), []
    if sweep in ("du_x", "du_z"):
        values = [round(factor * own, 12) for factor in values]
    fine = refined(scene)
    for value in sorted({*values, own}):
        try:
            changed = scene.changed(**{sweep: value})
        except SceneError:
            continue
        if ratio(changed, fine):
            found.append(value)
    return found


def plan(scene, quick):
    """The Runs to measure, cheap ones first within each sweep and series."""
    runs = []
    for sweep in SWEEPS:
        for series in SERIES:
            repeats = 1
            if series == "fast":
                values, repeats = _values(scene, sweep, SWEEPS[sweep]), REPEATS[quick]
            elif not quick:
                values = _values(scene, sweep, FEWER[sweep])
            else:
                values = list(QUICK[series]) if sweep == "tolerance" else []
            values.sort(reverse=sweep in ("tolerance", "du_x", "du_z"))
            runs += [Run(sweep, series, v, scene.changed(**{sweep: v}), repeats) for v in values]
    return runs
