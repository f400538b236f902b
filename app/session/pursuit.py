"""The computation for a visitor, one coroutine: it follows a held slider, or computes the exact run. The newest wins.

docs/slider_step.md follows a drag from the slider to the screen. RESTS after the visitor has released the slider, a
worker checks that the predicted run is the exact one. Where it is not, where somebody wants the frames of the solver,
or where following is impossible, the exact run is computed. `tests/bench/certify.py` measures both.
"""

import logging
import time
from collections.abc import Callable, Coroutine, Generator
from functools import partial
from types import coroutine
from typing import Any

from app import document
from app.document import on_loop
from app.limits import increments_of
from app.service import metrics, worker
from app.service.job import EXACT, SCREEN, Job
from app.service.skeletons import Certified, Followed, certified, followed
from app.session import orders
from app.session.orders import order
from app.session.run import ERROR, Request, Run
from solver import Scene
from solver.cautions import cautions
from solver.following.skeleton import Skeleton

log = logging.getLogger("app")
FIRST = 0.025  # s of work in the first part: the approach and the first shear, so that the page shows it soon
SOON = 2.0  # s: a run that ends within this time is finished during a drag, as following continues from it
PATIENCE = 0.5  # s that a newer request waits for a part: its budget plus the longest increment of most runs
RESTS = 1.0  # s without a change before a prediction is checked: a class changes sliders more often
WAITS = 1.0  # s in the queue before a visitor sees the position


@coroutine
def news() -> Generator[None, None, None]:
    """Wait until the coroutine is woken. The reason is not passed on: look what has changed."""
    yield


class Stepped:
    """Runs a coroutine that awaits nothing but `news()`, so that its steps run under the lock of the document.

    schedule(function) calls it under this lock.
    """

    def __init__(self, made: Coroutine[Any, Any, None], schedule: Callable[[Callable[[], None]], None]) -> None:
        self._coroutine, self._schedule = made, schedule
        self._due = self._running = self._closed = False

    def ring(self, *_: object) -> None:
        """Wake the coroutine soon; any thread may call this."""
        if not self._closed:
            self._schedule(self.step)

    def step(self) -> None:
        """Wake the coroutine, and return when it waits again. Call this under the lock of the document."""
        self._due = not self._closed
        if self._running:  # it looks again before it waits
            return
        self._running = True
        try:
            while self._due:
                self._due = False
                self._coroutine.send(None)
        finally:
            self._running = False

    def close(self) -> None:
        """End the coroutine where it waits."""
        self._closed = True
        self._coroutine.close()


class Pursuit:
    """The computation for one visitor. Every method runs under the lock of the document.

    `job` is the one in progress: of a prediction, or of the exact run. The browser has the frames; the server keeps
    them during a run, and then in the cache for all visitors.
    """

    def __init__(self, session: Any) -> None:
        self.session = session
        self.run: Run | None = None  # the last one
        self.requested: Request | None = None  # the newest, until the coroutine takes it
        self.overdue = False  # whether it has waited for PATIENCE
        self.held = False  # whether a slider is held
        self.rested = False  # whether the prediction on screen is to be checked now, or the exact run to replace it
        self.framed = False  # whether that must be the exact run, as somebody wants its frames
        self.skeleton: Skeleton | None = None  # start of predictions
        self.shown: Scene | None = None  # of the prediction on screen, if there is one
        self.cautions: list[str] = []  # warnings about the last finished run
        self.job: Job | None = None
        self.since = 0.0  # s, monotonic: when the job began to wait for a worker
        self.wake = Stepped(self._pursue(), partial(document.later, session.doc))
        self.wake.step()

    @property
    def state(self) -> str:
        """'idle', 'following' or 'exact'."""
        return "idle" if self.job is None else "following" if self.job.call[0] is followed else "exact"

    @property
    def scene(self) -> Scene:
        """The Scene of the last requested run."""
        return (self.requested or self.run or self.session).scene

    @property
    def position(self) -> int | None:
        """Number of tasks before this visitor's in the queue; None: none, or a wait shorter than WAITS."""
        waits = self.job is not None and time.monotonic() - self.since > WAITS
        return (self.session.jobs.pool.position(self.job) or None) if waits else None

    def close(self) -> None:
        """Cancel every call."""
        self.wake.close()
        self.run = self.requested = None

    # orders of the visitor

    def request(self, request: Request) -> None:
        """Show the run of a Request, at once or after the job in progress."""
        self.requested, self.held = request, request.held
        self.overdue = self.rested = self.framed = False
        self.session.tell("requested", request.scene)
        self.wake.step()
        if self.requested is request and self.state == "exact":
            self.session.doc.add_timeout_callback(on_loop(self._time_out, request), round(1000 * PATIENCE))

    def _time_out(self, request: Request) -> None:
        """Let a request wait no longer."""
        if self.requested is request and not self.session.closed:
            self.overdue = True
            self.wake.step()

    @order("release", exact=orders.is_flag)
    def release(self, exact: bool = False) -> None:
        """Check the prediction on screen RESTS from now; exact: compute the frames of its exact run at once.

        Where slips go over several sites, predictions are wrong more often: they are checked at once.
        """
        self.held, at = False, self.session.scene
        if exact or at.surface != "circular":
            self._rest(at, exact)
        else:
            self.session.doc.add_timeout_callback(on_loop(self._rest, at), round(1000 * RESTS))

    def _rest(self, scene: Scene, framed: bool = False) -> None:
        """Check the prediction now, or compute its run, unless the visitor has left or changed the scene since."""
        if not self.session.closed and not self.held and scene is self.session.scene:
            self.rested, self.framed = True, framed or self.framed
            self.wake.step()

    @order("skip")
    def skip(self) -> None:
        """End the run and keep its frames."""
        if self.run and self.run.state == "running":
            self.run.state = "skipped"
            self.wake.step()

    # the coroutine

    async def _pursue(self) -> None:
        """Show the newest request until the visitor leaves: by a prediction if a slider is held, else by its run."""
        while True:
            request = await self._newest()
            try:
                if not (request.held and await self._follow(request)):
                    newest, self.requested = self.requested or request, None
                    await self._compute(newest)
            except Exception:
                self.fail_unexpectedly()

    async def _newest(self) -> Request:
        """Return the newest request; for a prediction on screen that has rested, that of its exact run."""
        while True:
            request, self.requested = self.requested, None
            if request is None and self.rested:
                request, self.rested = self._refined(), False
            if request is not None:
                return request
            await news()

    def _refined(self) -> Request | None:
        """Return the request for the exact run of a prediction on screen, or for the frames of one that is checked."""
        if self.shown is not None:
            return Request(self.shown, refines=True)
        return Request(self.run.scene, refines=True) if self.framed and self.run and self.run.checked else None

    def _start(self, *call: Any, **how: Any) -> Job:
        self.since = time.monotonic()
        self.job = self.session.jobs.start(call, self.wake.ring, owner=id(self.session), **how)
        return self.job

    def _leave(self) -> None:
        job, self.job = self.job, None
        if job is not None:
            self.session.jobs.leave(job, self.wake.ring)

    # following

    async def _follow(self, request: Request) -> bool:
        """Show the predicted run of a request; return False if the run must be computed."""
        skeleton = self._nearest(request.scene)
        if skeleton is None:
            return False
        if self.run and not self.run.ended:
            self.run.state = "skipped"
        try:
            job = self._start(followed, skeleton, request.scene, rank=SCREEN, private=True)
            while not job.done() and (self.requested is None or self.requested.held):
                await news()
            if not job.done():  # another scene was chosen
                return True
        finally:
            self._leave()
        made = job.outcome
        if not isinstance(made, Followed):
            metrics.not_followed.labels(made if isinstance(made, str) else "the worker was lost").inc()
            self.shown = None
            return False
        metrics.count("followed")
        self.skeleton, self.shown = made.skeleton, request.scene
        self.session.send("skeleton", acknowledged=request.number, body=made.body)
        self.session.tell("predicted", self.skeleton)
        return True

    def _nearest(self, scene: Scene) -> Skeleton | None:
        """Return the Skeleton nearest to a scene: of a feature, or of the run; None: nothing can be followed."""
        origin = (self.shown or (self.run and self.run.scene)) if self.skeleton else None
        return next(filter(None, self.session.tell("nearer", scene, origin)), self.skeleton)

    # the exact run

    async def _compute(self, request: Request) -> None:
        """Show the run of a request, part by part, until it ends or a newer request replaces it."""
        run = self._begin(request)
        if run.refines and self.shown is not None and not self.framed and await self._certify(run):
            return
        try:
            rank, begin = (EXACT, ()) if run.refines else (SCREEN, (None, FIRST))
            seconds = worker.APPROACH * worker.BUDGET
            job = self._start(worker.compute, run.scene, rank=rank, seconds=seconds, begin=begin)
            run.known = job.done()
            metrics.count("run_cache_hits" if run.known else "run_cache_misses")
            came = self._show(run, job)
            while not run.ended and not self._is_replaced(run, job, came):
                self.session.publish()
                await news()
                came = self._show(run, job)
        finally:
            self._leave()
        if run.ended:
            self._end(run, job.outcome.skeleton if run.state == "finished" else None)
            self.session.publish()

    async def _certify(self, run: Run) -> bool:
        """Check the prediction on screen; return False if its run must be computed."""
        if self.session.jobs.keeps(worker.compute, run.scene):
            return False
        try:
            job = self._start(certified, run.scene, rank=EXACT, begin=(self.skeleton,))
            while not (job.done() or self.framed or self._is_replaced(run, job, came=False)):
                self.session.publish()
                await news()
            if not job.done():
                return not self.framed
        finally:
            self._leave()
        made = job.outcome
        holds = isinstance(made, Certified) and not made.failure
        metrics.count("certified" if holds else "not_certified")
        if not holds:
            log.info("a prediction does not hold, so its run is computed: %s", getattr(made, "failure", made))
        if holds:
            run.certify(made.about, made.checked, time.monotonic())
            self.session.send("skeleton", checked=made.checked, body=made.body)
            self._end(run, made.skeleton)
            self.session.publish()
        return holds

    def _begin(self, request: Request) -> Run:
        """Return a new Run; whether it can be followed is not known before its end."""
        if not self.held and not request.refines:
            self.skeleton = self.shown = None
        number = self.run.number + 1 if self.run else 1
        state = "warming" if self.session.jobs.pool.status != "ready" else "running"
        total = increments_of(request.scene)
        self.run = Run(number, request.scene, total, state, time.monotonic(), refines=request.refines)
        return self.run

    def _show(self, run: Run, job: Job) -> bool:
        """Send the parts of a run that have come; return whether there were any."""
        done, parts = job.done(), job.parts[run.parts :]
        if job.lost > run.lost:
            run.lost = job.lost
            self.session.notes = ["A worker process ended unexpectedly. Another worker repeats its part of the run."]
        for part in parts:
            self.since = time.monotonic()
            run.add(part, self.since)
            if done and run.parts == len(job.parts):
                run.end(job.outcome)
            for block in part.blocks:
                self.session.send("run", run=run.number, state=run.shown_state, frames=run.frames, body=block)
        if done and not run.ended:
            run.end(job.outcome)
        return bool(parts)

    def _is_replaced(self, run: Run, job: Job, came: bool) -> bool:
        """Whether a newer request ends the run now; came: whether a part has come since.

        A run that starts is ended after its part, and during a drag not at all if it ends soon by itself.
        """
        if self.requested is None:
            return False
        if run.refines or job.waits or self.overdue:
            return True
        return came and not (self.held and not job.heavy and run.ends_within(SOON))

    def _end(self, run: Run, skeleton: Skeleton | None) -> None:
        """After a run: follow from it, and tell the features."""
        whole = run.packed
        self.cautions = cautions(run.scene, whole.widest, whole.safe_damping, whole.sensitive, whole.overlap)
        self.session.tell("ended", run, skeleton)
        self.skeleton, self.shown = skeleton, None

    def fail_unexpectedly(self) -> None:
        """Log the traceback of a programming error, and show the visitor a message."""
        log.exception("a visitor's run failed")
        self.requested = self.shown = None
        if self.run:
            self.run.state, self.run.why = "failed", ERROR
        self.session.publish()
        self.wake.ring()
