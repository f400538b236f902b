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


class Bench:
    """The measurement of one visitor. It calls `on_change()`, if set, when `report` has changed.

    Every method but `_report` runs under the lock of the visitor's document.
    """

    def __init__(self, doc):
        self.doc, self.job, self.report, self.on_change = doc, None, {}, None

    def begin(self, scene):
        """Measure a scene. This ends the current measurement."""
        self.close()
        self.job = Job(scene, self._report)
        self._set({"state": "waiting", "progress": 0.0, "points": [], "scene": scene})
        log.info("a measurement begins")
        self.job.start()

    def cancel(self, why=""):
        """End the current measurement, if any, and keep its results so far."""
        if self.job is not None:
            self.close()
            self._set(self.report | {"state": "cancelled", "why": why})

    def close(self):
        """End the current measurement without a report."""
        if self.job is not None:
            self.job.stop()
            self.job = None
            log.info("a measurement ends early")

    def _report(self, job, report):
        """Pass a report from the job's thread to the document's thread."""
        if not job.stopped.is_set():
            self.doc.add_next_tick_callback(lambda: self._take(job, report))

    def _take(self, job, report):
        if job is self.job:
            if report["state"] in FINAL:
                self.job = None
                log.info("a measurement is %s", report["state"])
            self._set(self.report | report)

    def _set(self, report):
        self.report = report
        if self.on_change:
            self.on_change()


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
    words = {"sentence": sentence(report), "others": others}
    yield {"state": "done", "progress": 1.0, "points": points(report), **words}


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
