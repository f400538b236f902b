"""A visitor's measurement of accuracy. It runs in its own process, so the workers stay free."""

import logging
import threading
from functools import partial

from app.service.measuring import work
from solver.isolated import Caller, Lost

log = logging.getLogger("app")
turn = threading.Lock()  # one measurement at a time: two at once would slow each other down
LOOK = 0.1  # s between two checks whether a waiting measurement is still needed
LONGEST = 600.0  # s, time limit of a measurement
WHY = {
    "crash": "its process ended unexpectedly. Measure again",
    "hang": f"it took longer than {LONGEST:g} s. Choose a less expensive scene",
    "error": "it could not be measured; the server's log says why",
}
FINAL = ("done", "failed")


class Job(threading.Thread):
    """One measurement: waits for its turn, then reads from its process. This thread calls `tell(job, news)`."""

    def __init__(self, scene, tell):
        super().__init__(name="measurement", daemon=True)
        self.scene, self.tell = scene, tell
        self.stopped = threading.Event()
        self.caller = None

    def run(self):
        """Wait for the turn, then pass on every report until the process ends or the job is stopped."""
        while not turn.acquire(timeout=LOOK):
            if self.stopped.is_set():
                return
        try:
            self.caller = Caller()
            if not self.stopped.is_set():
                hear = partial(self.tell, self)
                self.caller.call(work, self.scene, limit=LONGEST, hear=hear)
        except Lost as lost:
            if lost.kind == "error":
                log.error("a measurement failed:\n%s", lost.reason)
            self.tell(self, {"state": "failed", "why": WHY[lost.kind]})
        except OSError:
            log.exception("no process could be started")
            self.tell(self, {"state": "failed", "why": WHY["error"]})
        finally:
            if self.caller is not None:
                self.caller.end()
            turn.release()

    def stop(self):
        """End the measurement at once."""
        self.stopped.set()
        if self.caller is not None:
            self.caller.process.kill()  # the job's thread reaps the process


class Bench:
    """The measurement of one visitor. It calls `hear()`, if set, when `told` has changed.

    Every method but `_heard` runs under the lock of the visitor's document.
    """

    def __init__(self, doc):
        self.doc, self.job, self.told, self.hear = doc, None, {}, None

    def begin(self, scene):
        """Measure a scene. This ends the current measurement."""
        self.close()
        self.job = Job(scene, self._heard)
        self._tell({"state": "waiting", "progress": 0.0, "points": [], "scene": scene})
        log.info("a measurement begins")
        self.job.start()

    def cancel(self, why=""):
        """End the current measurement, if any, and keep its results so far."""
        if self.job is not None:
            self.close()
            self._tell(self.told | {"state": "cancelled", "why": why})

    def close(self):
        """End the current measurement without a report."""
        if self.job is not None:
            self.job.stop()
            self.job = None
            log.info("a measurement ends early")

    def _heard(self, job, news):
        """Pass a report from the job's thread to the document's thread."""
        if not job.stopped.is_set():
            self.doc.add_next_tick_callback(lambda: self._take(job, news))

    def _take(self, job, news):
        if job is self.job:
            if news["state"] in FINAL:
                self.job = None
                log.info("a measurement is %s", news["state"])
            self._tell(self.told | news)

    def _tell(self, news):
        self.told = news
        if self.hear:
            self.hear()
