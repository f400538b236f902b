"""A visitor's measurement of accuracy, in a process of its own that lives no longer than it: the workers stay free."""

import logging
import threading
from functools import partial

from app.service.measuring import work
from solver.isolated import Caller, Lost

log = logging.getLogger("app")
turn = threading.Lock()  # one measurement at a time: side by side they would measure each other
LOOK = 0.1  # s between two looks whether a measurement that waits is still wanted
LONGEST = 600.0  # s
WHY = {
    "crash": "its process ended unexpectedly. Measure again",
    "hang": f"it took longer than {LONGEST:g} s. Choose a scene that is sooner done",
    "error": "it could not be measured; the server's log says why",
}
FINAL = ("done", "failed")


class Job(threading.Thread):
    """One measurement: waits for its turn, then listens to its process; `tell(job, news)` is called in this thread."""

    def __init__(self, scene, tell):
        super().__init__(name="measurement", daemon=True)
        self.scene, self.tell = scene, tell
        self.stopped = threading.Event()
        self.caller = None

    def run(self):
        """Until the process has said its last word, or nobody wants to hear it."""
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
        """End it, whatever it does."""
        self.stopped.set()
        if self.caller is not None:
            self.caller.process.kill()  # its thread collects it


class Bench:
    """What one visitor measures: `hear()`, if any, is called when `told` has changed.

    All but `_heard` runs under the lock of the visitor's document.
    """

    def __init__(self, doc):
        self.doc, self.job, self.told, self.hear = doc, None, {}, None

    def begin(self, scene):
        """Measure a scene instead of what is being measured."""
        self.close()
        self.job = Job(scene, self._heard)
        self._tell({"state": "waiting", "progress": 0.0, "points": [], "scene": scene})
        log.info("a measurement begins")
        self.job.start()

    def cancel(self, why=""):
        """End a measurement, if one goes on; what it has found so far stays."""
        if self.job is not None:
            self.close()
            self._tell(self.told | {"state": "cancelled", "why": why})

    def close(self):
        """End a measurement without a word."""
        if self.job is not None:
            self.job.stop()
            self.job = None
            log.info("a measurement ends early")

    def _heard(self, job, news):
        """Called in the thread of the job: hand over to the thread of the document."""
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
