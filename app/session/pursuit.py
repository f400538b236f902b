"""The computation for a visitor: idle, following a held slider, or computing the exact run. The newest RunRequest wins.

A drag, from the slider to the screen:

1. `steer.js` sends the newest position after the server has answered the previous one: an order "scene" with `held`.
2. `Session.change` reads the order and hands the scene to `Pursuit.request`.
3. `Pursuit` submits one call to the workers. A newer request waits until the call ends; those in between are dropped.
4. A worker continues the run on screen to the new parameters and packs the picture (service/following.py).
5. `Pursuit` sends the picture and starts the newest request. The number of the picture acknowledges the order.
6. `player.js` unpacks the picture and draws it.

When the visitor releases the slider, the exact run replaces the last picture, and a worker compares the two. If
following is impossible, the exact run starts at once.
"""

import logging
import time
from concurrent.futures import CancelledError
from functools import partial
from math import isfinite

from app.limits import increments_of
from app.service import metrics
from app.service.following import AGREE_F, AGREE_U, SHOWN, Followed, compared, followed
from app.service.pool import LATER, SCREEN
from app.service.requests import Requests
from app.session.orders import order
from app.session.run import ERROR, Run
from solver.cautions import cautions

log = logging.getLogger("app")
FIRST = 0.025  # s of work in the first slice: the approach and the first shear, so that the page shows it soon
BUDGET = 0.12  # s of work in any other slice: most runs end in the second, and a slow run visibly grows
SOON = 2.0  # s: a run that ends within this time is finished during a drag, as following continues from it
PATIENCE = 0.5  # s that a newer request waits for a slice: its budget plus the longest increment of most runs
WAITS = 1.0  # s in the queue before a visitor sees the position
OFF = "What was shown while the slider moved"  # a note begins with it


class Pursuit:
    """The computation for one visitor. Every method runs under the lock of the document.

    `task` is the one call in flight: a picture, or a slice of the exact run. The browser has the frames; the server
    keeps them during a run, and then in the cache for all visitors.
    """

    def __init__(self, session):
        self.session = session
        self.run = None  # the last one
        self.requested = None  # the newest RunRequest, while `task` is in flight
        self.task, self.since, self.budget = None, 0.0, 0.0  # since: s, monotonic; budget: s of work in a slice
        self.held = False  # whether a slider is held
        self.skeleton = self.shown = None  # start of predictions; the Scene of the picture on screen, or None
        self.cautions = []  # warnings about the last finished run
        self.comparison = Requests(session)

    @property
    def state(self):
        """'idle', 'following' or 'exact'."""
        return "idle" if self.task is None else "following" if self.task.call[0] is followed else "exact"

    @property
    def scene(self):
        """The Scene of the last requested run."""
        return (self.requested or self.run or self.session).scene

    @property
    def position(self):
        """Number of tasks before this visitor's in the queue; None: none, or a wait shorter than WAITS."""
        waits = self.task is not None and time.monotonic() - self.since > WAITS
        return (self.session.pool.position(self.task) or None) if waits else None

    def close(self):
        """Cancel every call."""
        self.abandon()
        self.comparison.cancel()
        self.run = self.requested = None

    # requests of the visitor

    def request(self, request):
        """Show the run of a RunRequest, at once or after the call in flight."""
        self.session.pages.scene_changed()
        self.requested, self.held = request, request.held
        state = self.state
        if (state == "following" and not request.held) or (state == "exact" and (self.run.refines or self._queued())):
            self.abandon()
        if self.task is None:
            self._start_newest()
        elif state == "exact":
            self.session.doc.add_timeout_callback(partial(self._time_out, self.task), round(1000 * PATIENCE))
            self.session.publish()  # acknowledges the order: the browser then sends the newest position

    @order("release")
    def release(self):
        """Compute the exact run of the picture on screen: the visitor released the slider."""
        self.held = False
        if self.task is None and self.shown is not None:
            self._begin(self.shown, refines=True)

    @order("pause")
    def pause(self):
        """Submit no further slice until `resume`."""
        if self.run and self.run.state in ("running", "warming") and not self.run.refines:
            self.run.pause(time.monotonic())
            self.session.publish()

    @order("resume")
    def resume(self):
        """Continue a paused run."""
        if self.run and self.run.state == "paused":
            self.run.resume(time.monotonic())
            self._slice(BUDGET)
            self.session.publish()

    @order("step")
    def step(self):
        """Compute one further increment of a paused run."""
        if self.run and self.run.state == "paused":
            self._slice(0.0)

    @order("skip")
    def skip(self):
        """End the run and keep its frames."""
        if self.run and self.run.state == "running":
            self.abandon()
            self.run.state = "skipped"
            self._end()
            if self.requested is not None:
                return self._start_newest()
            self.session.publish()

    # one call in flight

    def abandon(self):
        """Abandon the call in flight: another worker takes the next one."""
        task, self.task = self.task, None
        if task is not None:
            self.session.pool.abandon(task)

    def _queued(self):
        """Whether the call in flight waits for a worker."""
        return not self.task.running() and not self.task.done()

    def _submit(self, call, take, **how):
        self.task, self.since = self.session.pool.submit(*call, owner=id(self.session), **how), time.monotonic()
        schedule = self.session.doc.add_next_tick_callback  # under the lock of the document
        self.task.add_done_callback(lambda task: self.session.closed or schedule(lambda: self._done(task, take)))

    def _done(self, task, take):
        """Pass the result of the call in flight, or its error, to `take`."""
        if self.session.closed or task is not self.task:
            return
        self.task = None
        try:
            take(CancelledError() if task.cancelled() else task.exception() or task.result())
        except Exception:
            self.fail_unexpectedly()

    def _time_out(self, task):
        """Abandon this call if a newer request waits for it."""
        if self.requested is not None and task is self.task:
            self.abandon()
            self._start_newest()

    def _start_newest(self):
        """Start the newest request. A held slider follows the nearest Skeleton: of the open page, or of the run."""
        request, self.requested = self.requested, None
        skeleton = None
        if request.held:
            origin = (self.shown or self.run.scene) if self.skeleton else None
            page = self.session.pages.page
            skeleton = (page and page.nearer(request.scene, origin)) or self.skeleton
        if skeleton is None:
            return self._begin(request.scene)
        if self.run and self.run.state == "running":
            self.run.state = "skipped"
        self.session.marks.cancel()  # until the next run has ended
        call = (followed, skeleton, request.scene, request.at)
        self._submit(call, partial(self._show_picture, request=request), rank=SCREEN)

    # following

    def _show_picture(self, made, request):
        """Send the picture and start the next request; without a picture, start the exact run."""
        if not isinstance(made, Followed):
            metrics.not_followed.labels(made if isinstance(made, str) else "the worker was lost").inc()
            self.shown, request = None, self.requested or request
            return self._begin(request.scene)
        metrics.count("followed")
        self.skeleton, self.shown = made.skeleton, request.scene
        self.session.send("picture", acknowledged=request.number, **made.picture)
        if self.requested is not None:
            self._start_newest()
        elif not self.held:
            self.release()

    # the exact run

    def _begin(self, scene, refines=False):
        """Start the run of a scene. refines: the run replaces a picture."""
        self.abandon()
        self.requested = None
        if not self.held and not refines:
            self.skeleton = self.shown = None
        if self.run:
            self.run.leave()
        number = self.run.number + 1 if self.run else 1
        state = "warming" if self.session.pool.status != "ready" else "running"
        self.run = run = Run(number, scene, increments_of(scene), state, time.monotonic(), refines=refines)
        cached = self.session.run_cache.get(scene)
        metrics.count("run_cache_misses" if cached is None else "run_cache_hits")
        if cached is None:
            self._slice(BUDGET if refines else FIRST)
        else:
            run.take_over(cached)
            self._send(cached.blocks)
            self._ended(cached)
        self.session.publish()

    def _slice(self, budget):
        """Submit the next slice of the run; budget: s of work."""
        if self.task is None:
            self.budget = budget
            call, how = self.run.slice(budget)
            self._submit(call, self._show_slice, **how)

    def _show_slice(self, piece):
        """Send a slice, then submit the next one or start a newer request."""
        if isinstance(piece, Exception):
            return self._lost(piece)
        run, before = self.run, self.run.frames
        metrics.count("slices")
        metrics.count("evaluations", piece.evaluations)
        run.add(piece, time.monotonic())
        self._send(piece.blocks)
        if piece.done:
            self._end()
        if self._is_replaced():
            return self._start_newest()
        if run.state == "running":
            self._slice(BUDGET)
        elif run.state == "paused" and self.budget == 0.0 and run.frames == before:
            self._slice(0.0)  # the single increment took too long: repeat it with a longer limit
        self.session.publish()

    def _is_replaced(self):
        """Whether a newer request ends the run now; not during a drag if the run ends soon by itself."""
        ends = self.held and self.run.state == "running" and self.run.ends_within(SOON)
        return self.requested is not None and not ends

    def _end(self):
        """End the run; all visitors may use a complete one."""
        run = self.run
        if run.state == "finished":
            self.session.run_cache.put(run.scene, run.packed)
        self._ended(run.packed)
        run.leave()

    def _ended(self, whole):
        """After a run: compare it with the last picture, follow from it, and search the marks of the sliders."""
        run = self.run
        self.cautions = cautions(run.scene, whole.widest, whole.safe_damping, whole.sensitive, whole.overlap)
        if run.state == "finished" and self.shown == run.scene:
            call = (compared, self.skeleton, whole.blocks)
            self.comparison.ask(call, partial(self._compared, run.scene), rank=LATER)
        self.session.marks.seek(run.scene, whole.skeleton)
        self.skeleton, self.shown = whole.skeleton, None

    def _compared(self, scene, off):
        """Count how the last picture of a scene agreed with its run, and show a note if it did not."""
        if off is None:
            return
        off_U, off_F = off
        agreed = off_U <= AGREE_U and off_F <= AGREE_F
        metrics.count("agreed" if agreed else "disagreed")
        if not agreed:
            where = {name: getattr(scene, name) for name in SHOWN}
            log.info("a followed run was off: slips by %.2g nm, F by %.2g of its largest, %s", off_U, off_F, where)
            if self.session.scene == scene:
                how = f"by {off_U:.2g} nm at a slip" if isfinite(off_U) else "by a slip more or less"
                self.session.notes = [f"{OFF} was off {how}; the exact run has taken its place."]
                self.session.publish()

    def _send(self, blocks):
        """Send packed frames of the run."""
        for block in blocks:
            self.session.send("run", run=self.run.number, body=block)

    # failures

    def _lost(self, lost):
        """Submit a lost slice again, unless that is useless."""
        if why := self.run.lose(lost):
            return self._fail(why)
        self.session.notes = ["A worker process ended unexpectedly. Another worker repeats its slice."]
        if self._is_replaced():
            return self._start_newest()
        self._slice(self.budget)
        self.session.publish()

    def _fail(self, why):
        """End the run as failed, with its frames so far."""
        if self.requested is not None:
            return self._start_newest()
        if self.run:
            self.run.state, self.run.why = "failed", why
        self.session.publish()

    def fail_unexpectedly(self):
        """Log the traceback of a programming error, and show the visitor a message."""
        log.exception("a visitor's run failed")
        self.requested = None
        self._fail(ERROR)
