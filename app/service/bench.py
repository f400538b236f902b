"""A visitor's measurement of accuracy. It runs in its own process, so the workers stay free.

`work` runs in that process; it imports what the server does not need.
"""

import logging
import threading
import time
from functools import partial

from app.service import worker
from solver import Scene, SceneError, load_path
from solver.isolated import Caller, Lost

log = logging.getLogger("app")
lock = threading.Lock()  # one measurement at a time: two at once would slow each other down
LOOK = 0.1  # s between two checks whether a waiting measurement is still needed
LONGEST = 600.0  # s, time limit of a measurement
PAUSE = 0.2  # s between two reports that have only progress
WHY = {
    "crash": "its process ended unexpectedly. Measure again",
    "hang": f"it took longer than {LONGEST:g} s. Choose a less expensive scene",
    "error": "it could not be measured; the server's log says why",
}
FINAL = ("done", "failed")


class Job(threading.Thread):
    """One measurement: waits for the lock, then reads from its process. This thread calls `notify(job, report)`."""

    def __init__(self, scene, notify):
        super().__init__(name="measurement", daemon=True)
        self.scene, self.notify = scene, notify
        self.stopped = threading.Event()
        self.caller = None

    def run(self):
        """Wait for the lock, then pass on every report until the process ends or the job is stopped."""
        while not lock.acquire(timeout=LOOK):
            if self.stopped.is_set():
                return
        try:
            self.caller = Caller()
            if not self.stopped.is_set():
                notify = partial(self.notify, self)
                self.caller.call(work, self.scene, limit=LONGEST, hear=notify)
        except Lost as lost:
            if lost.kind == "error":
                log.error("a measurement failed:\n%s", lost.reason)
            self.notify(self, {"state": "failed", "why": WHY[lost.kind]})
        except OSError:
            log.exception("no process could be started")
            self.notify(self, {"state": "failed", "why": WHY["error"]})
        finally:
            if self.caller is not None:
                self.caller.end()
            lock.release()

    def stop(self):
        """End the measurement at once."""
        self.stopped.set()
        if self.caller is not None:
            self.caller.process.kill()  # the job's thread reaps the process


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
    from solver.accuracy.measure import SERIES

    small = Scene(nodes=128, width=312.5, radius=20.0, u_x_max=1.0)
    for method in SERIES.values():
        for _ in load_path(small, method):
            pass


def reports(scene):
    """Yield the measurements of a Scene as plain data."""
    from solver.accuracy.measure import SWEEPS, measure
    from solver.accuracy.report import choice, command, failures, sentence

    sent, count, report = 0.0, 0, None
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


def points(report):
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
