"""Code of the process that measures accuracy: runs `solver.validation.accuracy` and reports in plain data.

The server imports this module only to name `work`, so the functions import what is expensive.
"""

import time

from app.service import worker
from solver import Scene, SceneError, load_path

PAUSE = 0.2  # s between two messages that have only progress


def work(scene):
    """Measure `scene` and yield reports {'state', 'progress', 'points', ...}; the last is final."""
    from solver.continuation.state import NotConverged

    worker.start()
    try:
        _warm_up()
        yield from reports(scene)
    except (NotConverged, SceneError) as error:
        yield {"state": "failed", "why": f"The reference did not converge: {error}"}


def _warm_up():
    """Run every method once on a small scene: the time to load its kernels must not count."""
    from solver.validation.methods import SERIES

    small = Scene(nodes=128, width=312.5, radius=20.0, u_x_max=1.0)
    for method in SERIES.values():
        for _ in load_path(small, method):
            pass


def reports(scene):
    """Yield the measurements of a Scene as plain data."""
    from solver.validation.accuracy import SWEEPS, measure
    from solver.validation.accuracy_report import choice, command, failures, sentence

    sent, count, report = 0.0, 0, None
    for progress, report in measure(scene, quick=True):
        done, now = len(report.points) if report else 0, time.monotonic()
        if done > count or now - sent > PAUSE:
            sent, count = now, done
            yield {"state": "measuring", "progress": progress, "points": points(report)}
    others = [choice(report, sweep) for sweep in SWEEPS if sweep != "tolerance" and report.of(sweep, "fast")]
    others += [f"Not finished: {line}." for line in failures(report)]
    others.append(f"All numbers in tables: {command(report)}")
    told = {"sentence": sentence(report), "others": others, "reference": report.reference.tolerance}
    told["end"] = report.reference.u_x_max
    yield {"state": "done", "progress": 1.0, "points": points(report), **told}


def points(report):
    """Return the sweep of the tolerance as plain data, without unfinished runs."""
    from solver.validation.accuracy import LEAST

    swept = report.of("tolerance") if report else []
    return [
        {
            "series": p.series,
            "tolerance": p.value,
            "seconds": max(p.seconds, LEAST["seconds"]),
            "evaluations": max(p.evaluations, LEAST["evaluations"]),
            "error": max(p.branch_error, LEAST["error"]),
            "astray": p.branches[0] < p.branches[1],
        }
        for p in swept
        if not p.failure and p.branch_error is not None
    ]
