"""A visitor: which scene is wanted, the run that computes it slice by slice, and what the browser is told about it."""

import json
import logging
import os
import time
from concurrent.futures import CancelledError
from concurrent.futures.process import BrokenProcessPool

from app.service import tasks, worker
from app.service.bench import Bench
from app.service.finished import Finished
from app.service.finished import shelf as shared_shelf
from app.service.pool import pool as shared_pool
from app.session.cautions import cautions
from app.session.controls import DEFAULT, address_of, changed_scene, increments_of, scene_from_address, values_of
from app.session.run import Chains, Run
from app.session.wire import Wire
from app.views.pages import Pages
from solver import SceneError
from solver.presets import presets
from solver.run.carry import GEOMETRY

log = logging.getLogger("app")
FIRST = 0.025  # s of work in the first slice: the approach and a little of the shear, so that something shows soon
BUDGET = 0.12  # s of work in any other: most runs end in their second slice, and a slow one grows before one's eyes
SPARE = 0.09  # s for which a superseded run may go on if that is enough to finish it: whole curves in a drag
LIVES = 3  # how often a slice may be lost with its worker before the run counts as failed
VISITORS = int(os.environ.get("APP_VISITORS", 60))  # at most
visitors = set()  # the sessions of this process; Panel's own count lags behind


class Session:
    """The state machine of one visitor; every method but `_arrived` runs under the lock of the visitor's document.

    Frames live in the visitor's browser; here they are kept while a run lasts, and then on the shelf for all.
    At most one slice is in flight that the visitor waits for.
    """

    def __init__(self, doc, arguments=None, pool=shared_pool, shelf=shared_shelf):
        self.doc, self.pool, self.shelf = doc, pool, shelf
        self.wire = Wire()
        self.scene, self.preset, self.notes = scene_from_address(arguments or {})
        self.errors, self.cautions = {}, []  # cautions: of the last finished run
        self.bench = Bench(doc, self.wire)
        self.pages = Pages(self)
        self.acknowledged = None  # number of the last order: the browser ignores echoes of what it has changed since
        self.run = None
        self.chains = Chains()
        self.wanted = None  # a newer (scene, run and frame to go on from), while a slice of the old one is in flight
        self.flight = None
        self.last = None  # the slice before: the worker that did it is the best for the next
        self.closed = False
        self.wire.on_change("order", self._on_order)
        visitors.add(self)
        log.info("visitor arrived, now %d", len(visitors))

    def close(self):
        """Free everything: called when the visitor has left."""
        if not self.closed:
            self.closed = True
            self._abandon()
            self.bench.close()
            self.pages.close()
            self.run = self.wanted = None
            visitors.discard(self)
            log.info("visitor left, now %d, slices in flight %d", len(visitors), self.pool.in_flight)

    # orders from the browser

    def _on_order(self, attribute, old, new):
        try:
            order = json.loads(new)
            name, self.acknowledged = order["do"], order.get("n", self.acknowledged)
            if name == "scene":
                self.change(dict(order["values"]), order.get("from"))
            elif name in ("hello", "pause", "go", "one", "reset"):
                getattr(self, name)()
            elif name == "profile":
                self.read_profile(str(order["values"]["text"]))
            elif name == "preset":
                self.choose(order["values"]["preset"])
            elif name == "ask":
                self.pages.order(dict(order["values"]))
            elif name == "page":
                self.pages.open(order["values"]["page"])
                self.publish()
            elif name in ("measure", "cancel"):
                self.bench.begin(self.scene, self.pool.wisdom) if name == "measure" else self.bench.cancel()
                self.publish()
        except (ValueError, KeyError, TypeError, AttributeError):
            log.info("unreadable order from a browser: %.80s", new)
        except Exception as error:
            self._fail_unexpectedly(error)

    def hello(self):
        """The page is drawn and listens."""
        self._want(self.scene)

    def change(self, entries, after=None):
        """Change parameters {name: text}; unusable ones leave a message, and what is on screen stays.

        after: (number of a run, frame) whose state the new run goes on from, rather than starting anew.
        """
        self.notes = []
        scene, self.errors = changed_scene(self.scene, entries, self.notes)
        if scene == self.scene:
            self.publish()
        else:
            after = self._usable(scene, after)
            self.scene = scene
            self._want(scene, after)

    def _usable(self, scene, after):
        """(run, frame) to go on from, or None where the new scene must start anew, with a note."""
        if not after or int(after[0]) not in self.chains:
            return None
        if any(getattr(scene, name) != getattr(self.scene, name) for name in (*GEOMETRY, "path")):
            self.notes += ["A run goes on with the same surface and path only: this one starts anew."]
            return None
        return int(after[0]), int(after[1])

    def read_profile(self, text):
        """Show the surface that a CSV describes; one of no use leaves a message, and what is on screen stays."""
        task = self.pool.submit(tasks.measured, self.scene, text)
        task.add_done_callback(lambda task: self.closed or self.doc.add_next_tick_callback(lambda: self._read(task)))

    def _read(self, task):
        scene, why = (None, "the worker was lost; try again") if task.exception() else task.result()
        if scene is None:
            self.errors = {"profile": f"profile: {why}. The run on screen stays."}
            return self.publish()
        self.scene, self.errors, self.notes = scene, {}, [f"Profile: {' '.join(scene.measured.notes)}"]
        self._want(scene)

    def choose(self, preset):
        """Everything as in a preset."""
        self.show(presets()[preset].scene, preset)

    def show(self, scene, preset):
        """A scene that a page has made from `preset`."""
        self.scene, self.preset, self.errors, self.notes = scene, preset, {}, []
        self._want(scene)

    def reset(self):
        """Everything as in the paper's Fig. 6."""
        self.choose(DEFAULT)

    def pause(self):
        """Submit no further slice until `go`."""
        if self.run and self.run.state in ("running", "warming"):
            self.run.state = "paused"
            self.publish()

    def go(self):
        """Continue a paused run."""
        if self.run and self.run.state == "paused":
            self.run.state = "running"
            self._submit(BUDGET)
            self.publish()

    def one(self):
        """Compute one further increment of a paused run."""
        if self.run and self.run.state == "paused":
            self._submit(0.0)

    # the run

    def _want(self, scene, after=None):
        """The latest wish wins: at once, or after a run that seems to end soon, whether it does or not."""
        self.bench.cancel("the scene has changed")
        self.pages.scene_changed()
        if self.flight is None or self.flight.cancel() or self._far_from_done():
            self._begin(scene, after)
            return
        if self.wanted is None:
            number = self.run.number
            self.doc.add_timeout_callback(lambda: self._lose_patience(number), round(1000 * SPARE))
        self.wanted = scene, after

    def _lose_patience(self, number):
        """The run had its time and is still not done: its slice may end unseen."""
        if not self.closed and self.wanted is not None and self.run.number == number:
            self._begin(*self.wanted)

    def _far_from_done(self):
        """Whether at its pace until now the run would need much longer than SPARE; False before its first slice."""
        run = self.run
        return run.seconds * (run.total - run.frames) > 2 * SPARE * run.frames

    def _gives_way(self):
        """Whether the run ends here for a newer scene."""
        return self.wanted is not None and (self.run.state != "running" or self._far_from_done())

    def _abandon(self):
        """Wait no longer for the slice in flight: another worker takes what comes next."""
        if self.flight is not None:
            self.pool.abandon(self.flight)
            self.flight = None

    def _begin(self, scene, after=None):
        self._abandon()
        number = self.run.number + 1 if self.run else 1
        state = "warming" if self.pool.status != "ready" else "running"
        self.run = Run(number, scene, increments_of(scene), state, time.monotonic())
        self.wanted = None
        if after:
            self.run.after, self.run.history = after, self.chains.history(*after)
            self.run.frames = after[1] + 1
        self.chains.add(self.run)
        known = None if after else self.shelf.get(scene)
        if known is not None:
            self._show_known(known)
        else:
            self._submit(FIRST)
        self.publish()

    def _submit(self, budget):
        if self.flight is None:
            run = self.run
            call = (worker.compute, run.scene, run.checkpoint, budget, run.last, run.history)
            self.flight = self.pool.submit(*call, near=self.last)
            self.last = self.flight
            self.flight.add_done_callback(self._arrived)

    def _arrived(self, future):
        """Called in a thread of the pool: hand over to the thread of the document."""
        if not self.closed:
            self.doc.add_next_tick_callback(lambda: self._take(future))

    def _take(self, future):
        """A slice is back: show it, and go on with this run or with the scene wanted since."""
        if self.closed or future is not self.flight:
            return
        self.flight = None
        try:
            self._show(future.result())
        except (BrokenProcessPool, CancelledError):
            self._compute_again()
        except SceneError as error:  # the state does not lead on into this scene
            self.run.state, self.run.why = "failed", str(error)
        except Exception as error:
            self._fail_unexpectedly(error)
        try:
            self._go_on()
        except Exception as error:  # the pool cannot take work
            self._fail_unexpectedly(error)

    def _go_on(self):
        if self._gives_way():
            self._begin(*self.wanted)
        elif self.run.state == "running":
            self._submit(BUDGET)
        self.publish()

    def _show(self, piece):
        run = self.run
        run.checkpoint, run.last = piece.checkpoint, piece.last
        run.frames += piece.frames
        run.total = run.frames + piece.ahead
        run.evaluations += piece.evaluations
        run.residual = max(run.residual, piece.residual)
        run.widest = max(run.widest, piece.widest)
        run.blocks += piece.blocks
        run.seconds = time.monotonic() - run.started
        if run.state == "warming":
            run.state, run.started = "running", time.monotonic()
        if piece.done:
            run.state, run.why = ("failed", piece.failure) if piece.failure else ("finished", "")
            run.total = run.frames if run.state == "finished" else run.total
            run.checkpoint = run.last = None
            self._keep()
        if piece.done or not self._gives_way():
            self._send(piece.blocks)

    def _keep(self):
        """A finished run goes on the shelf."""
        run = self.run
        self.cautions = cautions(run.scene, run.widest)
        if run.state == "finished" and not run.history:
            whole = Finished(tuple(run.blocks), run.frames, run.evaluations, run.residual, run.widest)
            self.shelf.put(run.scene, whole)
            run.blocks = []

    def _show_known(self, known):
        run = self.run
        run.state, run.frames, run.total = "finished", known.frames, known.frames
        run.evaluations, run.residual, run.widest = known.evaluations, known.residual, known.widest
        self.cautions = cautions(run.scene, run.widest)
        self._send(known.blocks)

    def _send(self, blocks):
        for block in blocks:
            self.wire.chunk = worker.numbered(self.run.number, block)

    def _compute_again(self):
        """A worker died and is being replaced: the slice is pure, so it is computed again by another."""
        self.run.lost += 1
        self.notes = ["A worker process ended unexpectedly. It was replaced, and its slice is computed again."]
        if self.run.lost >= LIVES:
            self.run.state, self.run.why = "failed", f"lost {LIVES} workers; change a parameter or press Reset"

    def _fail_unexpectedly(self, error):
        log.exception("a visitor's run failed")
        if self.run:
            self.run.state = "failed"
            self.run.why = f"{type(error).__name__}: {error}. Press Reset to start again"
        self.publish()

    def publish(self):
        """Send status, values, notes and errors to the browser."""
        run = self.run
        if run is None:
            return
        own = {"values": values_of(self.scene), "heard": self.acknowledged, "errors": self.errors}
        own |= {"preset": self.preset, "address": address_of(self.scene, self.preset)}
        self.wire.status = json.dumps(run.status() | own | {"notes": self.notes + self.cautions})
