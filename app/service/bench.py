"""A visitor's measurement of accuracy: a generator for a worker, see jobs.py."""

import time
from collections.abc import Iterator
from functools import cache
from typing import Any

from solver import NotConverged, Scene, SceneError, load_path

LONGEST = 600.0  # s, time limit of a measurement
PAUSE = 0.2  # s between two reports that have only progress


def work(scene: Scene) -> Iterator[dict[str, Any]]:
    """Measure `scene` and yield reports {'state', 'progress', 'points', ...}; the last is final."""
    try:
        _warm_up()
        yield from reports(scene)
    except (NotConverged, SceneError) as error:
        yield {"state": "failed", "why": f"The reference did not converge: {error}"}


@cache  # once in a worker
def _warm_up():
    """Run every method once on a small scene: the time to load its kernels must not count."""
    from solver.accuracy.measure import SERIES

    small = Scene(nodes=128, width=312.5, radius=20.0, u_x_max=1.0)
    for method in SERIES.values():
        for _ in load_path(small, method):
            pass


def reports(scene: Scene) -> Iterator[dict[str, Any]]:
    """Yield the measurements of a Scene as plain data."""
    from solver.accuracy.measure import SWEEPS, measure
    from solver.accuracy.report import choice, command, failures, sentence

    sent, count = 0.0, 0
    report: Any = None
    for progress, report in measure(scene, quick=True):
        done, now = len(report.points) if report else 0, time.monotonic()
        if done > count or now - sent > PAUSE:
            sent, count = now, done
            yield {"state": "measuring", "progress": progress, "points": points(report)}
    others = [choice(report, sweep) for sweep in SWEEPS if sweep != "tolerance" and report.of(sweep, "fast")]
    others += [f"Not finished: {line}." for line in failures(report)]
    others.append(f"All numbers in tables: {command(report)}")
    words = {"sentence": sentence(report), "others": others}
    yield {"state": "done", "progress": 1.0, "points": points(report), **words}


def points(report: Any) -> list[dict[str, Any]]:
    """Return the sweep of the tolerance as plain data, without unfinished runs."""
    from solver.accuracy.measure import LEAST

    swept = report.of("tolerance") if report else []
    return [
        {
            "series": p.series,
            "tolerance": p.value,
            "seconds": max(p.seconds, LEAST["seconds"]),
            "evaluations": max(p.evaluations, LEAST["evaluations"]),
            "error": max(p.branch_error, LEAST["error"]),
        }
        for p in swept
        if not p.failure and p.branch_error is not None
    ]
