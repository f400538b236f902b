"""A visitor: obeys the orders of the browser, and publishes the status of the run."""

import json
import logging
import os

from app.limits import INCREMENTS
from app.service import metrics, tasks
from app.service.bench import Bench
from app.service.finished import shelf as shared_shelf
from app.service.pool import LATER
from app.service.pool import pool as shared_pool
from app.service.requests import Requests
from app.service.worker import KERNELS
from app.session import controls, orders
from app.session.aside import Film, Layer, Marks, Pinned
from app.session.pursuit import Pursuit
from app.session.run import Wish
from app.session.share import Share
from app.session.wire import Wire
from solver import SceneError
from solver.run.carry import GEOMETRY

log = logging.getLogger("app")
LEGS = 40  # runs that carry on one another
VISITORS = int(os.environ.get("APP_VISITORS", 60))  # at most
visitors = set()  # the sessions of this process; Panel's own count lags behind


class Session:
    """One visitor; every method runs under the lock of the visitor's document."""

    def __init__(self, doc, pages, arguments=None, pool=shared_pool, shelf=shared_shelf):
        """pages: of a session, the pages beside the experiment."""
        self.doc, self.pool, self.shelf = doc, pool, shelf
        self.wire = Wire()
        self.scene, self.preset, self.notes = controls.scene_from_address(arguments or {})
        self.errors = {}
        self.pursuit = Pursuit(self)
        self.bench = Bench(doc)
        self.pages = pages(self)
        self.share, self.film, self.layer = Share(self), Film(self), Layer(self)
        self.pinned, self.marks = Pinned(self), Marks(self)
        self.acknowledged = None  # number of the last order: the browser ignores echoes of what it has changed since
        self.told_position = self.told_order = None
        self.reading = Requests(self)  # a profile
        self.closed = False
        visitors.add(self)
        metrics.count("visits")
        log.info("visitor arrived, now %d", len(visitors))

    def close(self):
        """Free everything: called when the visitor has left."""
        if not self.closed:
            self.closed = True
            for part in (self.pursuit, self.bench, self.pages):
                part.close()
            parts = (self.reading, self.share, self.share.code, self.film, self.layer)
            for requests in (*parts, self.pinned, self.marks):
                requests.cancel()
            visitors.discard(self)
            log.info("visitor left, now %d, slices in flight %d", len(visitors), self.pool.in_flight)

    def when_done(self, task, take):
        """Call `take(task)` under the lock of the document once a call of the pool is done, unless the visitor left."""
        task.add_done_callback(lambda _: self.closed or self.doc.add_next_tick_callback(lambda: take(task)))

    # orders from the browser

    def obey(self, message):
        """Do what a message of the browser orders; every order is acknowledged, whether it is obeyed or refused.

        A picture acknowledges the order that it answers: until then the browser sends no newer position of the slider.
        """
        try:
            number, order = orders.read(message)
        except orders.Refused as refused:
            return self._refuse(refused)
        self.acknowledged = self.acknowledged if number is None else number
        try:
            order.obey(self)
        except Exception:
            self.pursuit.fail_unexpectedly()
        pictured = getattr(order, "held", False) and self.pursuit.state == "following"
        if self.told_order != self.acknowledged and not pictured:
            self.publish()

    def _refuse(self, refused):
        metrics.count("refused_messages")
        self.acknowledged = self.acknowledged if refused.n is None else refused.n
        self.notes = [f"{refused}{controls.STAYS}"]
        self.publish()

    def hello(self):
        """The page is drawn and listens."""
        self.pursuit.want(Wish(self.scene))

    def change(self, entries, after=None, held=False, at=0.0):
        """Change parameters {name: text}; unusable ones leave a message, and what is on screen stays.

        after: (number of a run, frame) from which the new run carries on; without, it starts from the beginning.
        held: a slider is held: pictures follow it, with the frame at U_x = `at` nm.
        """
        self.notes = []
        scene, self.errors = controls.changed_scene(self.scene, entries, self.notes)
        if scene == self.scene:
            self.publish()
        else:
            after = self._usable(scene, after)
            self.scene = scene
            self.pursuit.want(Wish(scene, after, held, at, self.acknowledged))

    def _usable(self, scene, after):
        """(run, frame) to carry on from, or None, with a note, where the new scene must start from the beginning."""
        run = after and self.pursuit.runs.get(after[0])
        if not run or after[1] >= run.frames:
            return None
        if any(getattr(scene, name) != getattr(self.scene, name) for name in (*GEOMETRY, "path")):
            self.notes += ["A run carries on with the same surface and path only: this one starts from the beginning."]
            return None
        if after[1] >= INCREMENTS:
            self.notes += [
                f"A run carries on from its first {INCREMENTS} increments only: this one starts from the beginning."
            ]
            return None
        if len(run.history) >= LEGS:
            self.notes += [f"{LEGS} runs carry on one another already: this one starts from the beginning."]
            return None
        return after

    def read_profile(self, text):
        """Show the surface that a CSV describes; one of no use leaves a message, and what is on screen stays."""
        self.reading.ask((tasks.measured, text), self._read, rank=LATER)

    def _read(self, made):
        profile, why = made or (None, "it could not be read; try again")
        if profile is not None:  # sliders may have been moved since it was sent
            try:
                scene = controls.with_profile(self.scene, profile)
            except SceneError as error:
                profile, why = None, error
        if profile is None:
            self.errors = {"profile": f"profile: {why}.{controls.STAYS}"}
            return self.publish()
        self.scene, self.errors, self.notes = scene, {}, [f"Profile: {' '.join(profile.notes)}"]
        self.pursuit.want(Wish(scene))

    def restore(self, entries):
        """Show the scene of an address {name: text}."""
        scene, preset, notes = controls.scene_from_address({name: [text.encode()] for name, text in entries.items()})
        self.show(scene, preset, notes)

    def show(self, scene, preset, notes=()):
        """Show another scene, made from `preset`, with notes on how it was read."""
        self.reading.cancel()
        self.scene, self.preset, self.errors, self.notes = scene, preset, {}, [*notes]
        self.pursuit.want(Wish(scene))

    @property
    def run(self):
        """The run on screen, or None."""
        return self.pursuit.run

    def look(self):
        """From time to time: publish the position in the queue and the kernels compiled, in any thread."""
        warming = self.run is not None and self.run.state == "warming"
        if not self.closed and (warming or self.told_position or self.pursuit.position):
            self.doc.add_next_tick_callback(lambda: self.closed or self.publish())

    def publish(self):
        """Send status, values, notes and errors to the browser."""
        run = self.run
        if run is None:
            return
        self.told_position = self.pursuit.position
        waits = [f"{self.told_position} before you in the queue of the server."] if self.told_position else []
        own = {"values": controls.values_of(self.scene), "heard": self.acknowledged, "errors": self.errors}
        own |= {"preset": self.preset, "address": controls.address_of(self.scene, self.preset)}
        own |= {"scene": controls.values_of(run.scene), "marks": self.marks.told}  # scene: whose run it is
        self.told_order = self.acknowledged
        if run.state == "warming":
            own["compiled"] = min(self.pool.compiled, KERNELS), KERNELS
        own |= {"notes": self.notes + waits, "cautions": self.pursuit.cautions}
        self.wire.status = json.dumps(run.status() | own)
