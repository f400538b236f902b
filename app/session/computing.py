"""The run that a visitor wants, computed slice by slice: the newest wish wins, and pictures follow a moving hand."""

import logging
import time
from concurrent.futures import CancelledError

from cachetools import FIFOCache

from app.limits import coarse, increments_of
from app.service import metrics, worker
from app.service.pool import EXACT, HEAVY, SCREEN
from app.session.following import Following
from app.session.run import Run
from solver.cautions import cautions
from solver.isolated import Lost

log = logging.getLogger("app")
FIRST = 0.025  # s of work in the first slice: the approach and a little of the shear, so that something shows soon
BUDGET = 0.12  # s of work in any other: most runs end in their second slice, and a slow one grows before one's eyes
SPARE = 0.2  # s that a superseded run may still need: it is finished, for whole curves in a drag
PATIENCE = 0.25  # s for which a slice in flight may keep a newer scene waiting
PATIENTLY = 4, 8  # times that if nothing of its run was seen; if it is a coarse one: given up, it would hold its worker
COARSE = 0.6  # s of work in the first slice of a coarse run, which nearly always is the whole of it
ITS_TIME = 1.2  # s that a coarse run has to itself: most of its work is in few increments, a late curve beats none
LONGER = 1.5  # s that it may still need then, to be finished all the same
LIVES = 3  # how often a slice may be lost with its worker before the run counts as failed
RUNS = 40  # of a visitor, from which another run may go on
WAITS = 1.0  # s in the queue, after which a visitor is told its place


class Computing:
    """Computes the scene that one visitor wants last; every method runs under the lock of the document.

    Frames live in the visitor's browser; here they are kept while a run lasts, and then on the shelf for all.
    At most one slice is in flight that the visitor waits for.
    """

    def __init__(self, session):
        self.session = session
        self.run, self.runs = None, FIFOCache(RUNS)  # by number, from which another may go on
        self.wanted = None  # a newer (scene, after, held, at), as of `want`, while a slice of the old one is in flight
        self.flight, self.budget, self.since = None, 0.0, 0.0  # the slice, s of work in it, when it was asked for
        self.cautions = []  # of the last finished run
        self.following = Following(session, lambda scene: self._begin(scene, held=self.held))
        self.held = False  # whether a hand is on a slider

    @property
    def legs(self):
        """((Scene, frames), ..., (Scene, None)) that lead to the run wanted last: see `solver.carried_path`."""
        if self.wanted is not None:
            scene, after, *_ = self.wanted
            return (*(self.runs[after[0]].up_to(after[1]) if after else ()), (scene, None))
        return (*self.run.history, (self.run.wish, None)) if self.run else ((self.session.scene, None),)

    def close(self):
        """Wait for nothing any longer."""
        self.abandon()
        self.following.leave()
        self.run = self.wanted = None

    def pause(self):
        """Submit no further slice until `go`."""
        if self.run and self.run.state in ("running", "warming") and not self.run.refines:
            self.run.state = "paused"
            self.session.publish()

    def go(self):
        """Continue a paused run."""
        if self.run and self.run.state == "paused":
            self.run.state = "running"
            self._submit(BUDGET)
            self.session.publish()

    def one(self):
        """Compute one further increment of a paused run."""
        if self.run and self.run.state == "paused":
            self._submit(0.0)

    def skip(self):
        """Go on with what was computed."""
        if self.run and self.run.state == "running":
            self.abandon()
            self.run.state = "skipped"
            self._keep()
            self.session.publish()

    def want(self, scene, after=None, held=False, at=0.0):
        """The latest wish wins, once the visitor has seen something of the run before; a refinement ends at once.

        held: what follows the hand comes first, with the frame at U_x = `at` nm; the exact run with `rest`.
        """
        self.session.bench.cancel("the scene has changed")
        self.session.pages.scene_changed()
        self.held = held
        new = scene, after, held, at
        if self._follows(*new):
            return
        if self.flight is None or self.flight.cancel() or self.run.refines:
            self._take_up(new)
            return
        if self.wanted is None:
            self._wait(self.run.number, PATIENTLY[self.run.coarse])
        self.wanted = new
        self.session.publish()  # so that the browser says where the hand is by then

    def rest(self):
        """The hand has come to rest: now the exact run of where it is."""
        self.held, run, scene = False, self.run, self.session.scene
        if self.following.moves:
            if not (run.refines and run.state == "running" and run.scene == scene):
                self._begin(scene, refines=True)
        elif self.flight is None and run is not None:
            self._follow_up()
            self.session.publish()

    def _follows(self, scene, after, held, at):
        """Whether a picture of the scene is on its way, in place of a run; a coarse one under way goes first."""
        makes_coarse = self.flight is not None and self.run.coarse
        if not held or after or makes_coarse or not self.following.want(scene, at):
            return False
        self.abandon()
        self.session.marks.cancel()  # until the run of where the hand goes has ended
        if self.run.state == "running":
            self.run.state = "skipped"
        return True

    def _take_up(self, new):
        """What is wanted now."""
        self.wanted = None
        if not self._follows(*new):
            self._begin(*new[:3])
        elif not self.held:
            self.rest()

    def _wait(self, number, times):
        self.session.doc.add_timeout_callback(lambda: self._lose_patience(number, times - 1), round(1000 * PATIENCE))

    def _lose_patience(self, number, times):
        """The run had its time: its slice may end unseen, rather sooner if something of it is on screen."""
        if not self.session.closed and self.wanted is not None and self.run.number == number:
            if times == 0 or (self.run.seen and not self.run.coarse):
                self._take_up(self.wanted)
            else:
                self._wait(number, times)

    def _far_from_done(self):
        """Whether at its pace until now the run would need too long; False before its first slice."""
        run = self.run
        if run.coarse and run.seconds < ITS_TIME:
            return False
        spare = LONGER if run.coarse else 2 * SPARE
        return run.seconds * (run.total - run.frames) > spare * run.frames

    def _gives_way(self):
        """Whether the run ends here for a newer scene."""
        run = self.run
        return self.wanted is not None and (run.state != "running" or (run.seen and self._far_from_done()))

    def abandon(self):
        """Wait no longer for the slice in flight: another worker takes what comes next."""
        if self.flight is not None:
            self.session.pool.abandon(self.flight)
            self.flight = None

    def _begin(self, wish, after=None, held=False, refines=False):
        self.abandon()
        if not held and not refines:
            self.following.goes_on_from(None)
        number = 1
        if self.run:
            number = self.run.number + 1
            self.run.leave()
        state = "warming" if self.session.pool.status != "ready" else "running"
        scene = coarse(wish) if held and wish not in self.session.shelf else wish
        self.run = Run(number, scene, increments_of(scene), state, time.monotonic(), wish=wish, refines=refines)
        self.wanted = None
        if after:
            self.run.after, self.run.history = after, self.runs[after[0]].up_to(after[1])
            self.run.frames = after[1] + 1
        self.runs[number] = self.run
        known = None if after else self.session.shelf.get(scene)
        metrics.count("shelf_misses" if known is None else "shelf_hits")
        if known is not None:
            self._show_known(known)
        else:
            self._submit(COARSE if self.run.coarse else BUDGET if refines else FIRST)
        self._follow_up()
        self.session.publish()

    def _follow_up(self):
        """After a run with coarse increments one with its own follows, when the hand rests; then the sliders' marks."""
        run = self.run
        if run.state == "finished" and not run.coarse:
            self.session.marks.seek(run.scene, self.following.skeleton)
        elif run.state == "finished" and not self.held:
            self._begin(run.wish, run.after or None, refines=True)

    def _submit(self, budget):
        if self.flight is None:
            run, self.budget = self.run, budget
            rank, limit = (EXACT if run.refines else SCREEN), worker.QUICK
            if run.heavy:
                rank, limit = HEAVY, worker.SLOW
            call = (worker.compute, run.scene, run.checkpoint, budget, run.last, run.history, limit)
            how = {"owner": id(self.session), "rank": rank, "seconds": worker.APPROACH * budget}
            self.flight = self.session.pool.submit(*call, **how)
            self.since = time.monotonic()
            self.session.when_done(self.flight, self._take)

    @property
    def place(self):
        """How many have their turn before this visitor, or None: nobody, or it has not waited for long."""
        waits = self.flight is not None and time.monotonic() - self.since > WAITS
        return (self.session.pool.place(self.flight) or None) if waits else None

    def _take(self, future):
        """A slice is back: show it, and go on with this run or with the scene wanted since."""
        if self.session.closed or future is not self.flight:
            return
        self.flight = None
        try:
            piece, before = future.result(), self.run.frames
            self._show(piece)
            self._go_on(before)
        except (Lost, CancelledError) as lost:
            self._lost(lost)
        except Exception:
            self.fail_unexpectedly()

    def _go_on(self, before):
        if self._gives_way():
            return self._take_up(self.wanted)
        if self.run.state == "running":
            self._submit(BUDGET)
        elif self.run.state == "paused" and self.budget == 0.0 and self.run.frames == before:
            self._submit(0.0)  # the one increment asked for was left out, as it takes longer: once more, with more time
        self._follow_up()
        self.session.publish()

    def _show(self, piece):
        run = self.run
        metrics.count("slices")
        metrics.count("evaluations", piece.evaluations)
        run.add(piece, time.monotonic())
        if piece.done:
            if run.refines:
                self._send(run.made.blocks)
            self._keep()
        if not run.refines:
            self._send(piece.blocks)

    def _keep(self):
        """A run that has ended goes on the shelf: for all, or, if it is no whole run of its scene, for this visitor."""
        run = self.run
        run.kept_as = run.scene if run.state == "finished" and not run.history else object()
        self.session.shelf.put(run.kept_as, run.made)
        self._ended(run.made)
        run.leave()

    def _ended(self, whole):
        """A hand that moves goes on from this run; if it has brought the pictures here, were they right?"""
        self.cautions = cautions(self.run.scene, whole.widest, whole.safe_damping, whole.sensitive)
        if self.run.state == "finished" and not self.run.coarse:
            self.following.judge(self.run.scene, whole.blocks)
        if whole.skeleton or not self.run.coarse:
            self.following.goes_on_from(whole.skeleton)

    def _show_known(self, known):
        run = self.run
        run.take_over(known)
        self._send(known.blocks)
        self._ended(known)

    def _send(self, blocks):
        self.session.wire.send(self.run.number, blocks)

    def _lost(self, lost):
        """A worker was lost with a slice: it is pure, so it is computed again, unless that would be of no use."""
        run, kind = self.run, getattr(lost, "kind", "closed")
        run.lost += 1
        if kind == "crash" and run.lost < LIVES:
            self.session.notes = [
                "A worker process ended unexpectedly. It was replaced, and its slice is computed again."
            ]
            if self._gives_way():
                return self._take_up(self.wanted)
            self._submit(self.budget)
            return self.session.publish()
        if kind == "error":
            return self._fail("the server made an error, which is in its log. Press Reset to start again")
        why = {
            "crash": f"lost {LIVES} workers; change a parameter or press Reset",
            "hang": f"{lost}, so the worker was ended; what is computed stays. Change a parameter or press Reset",
        }
        self._fail(why.get(kind, f"{str(lost) or 'the server is being stopped'}. Press Reset to try again"))

    def _fail(self, why):
        """The run ends here, with what it has."""
        if self.wanted is not None:
            return self._take_up(self.wanted)
        if self.run:
            self.run.state, self.run.why = "failed", why
        self.session.publish()

    def fail_unexpectedly(self):
        """An error of this program: its traceback is for the log, not for the visitor."""
        log.exception("a visitor's run failed")
        self.wanted = None
        self._fail("the server made an error, which is in its log. Press Reset to start again")
