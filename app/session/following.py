"""The pictures that follow a hand on a slider: one in the making, the newest position next, none in between."""

import logging
import struct
from math import nan

import numpy as np

from app.service import metrics, packing
from app.service.following import AGREE_F, AGREE_U, SHOWN, Followed, compared, followed
from app.service.pool import LATER, SCREEN
from app.service.wanted import Wanted

log = logging.getLogger("app")
OFF = "What was shown while the slider moved"  # a note begins with it


class Following(Wanted):
    """Of one visitor; `skeleton` (pickled) is what the next move goes on from, `shown` the Scene of the picture sent.

    Every method runs under the lock of the document.
    """

    def __init__(self, session, start):
        super().__init__(session)
        self.start = start  # start(scene): a run of it from its start, where nothing can be followed
        self.skeleton = self.shown = None
        self.wanted = None

    def goes_on_from(self, skeleton):
        """A run has ended: what is pickled here of it is what a hand moves on from; None: nothing."""
        self.leave()
        self.skeleton, self.shown = skeleton, None

    def want(self, scene, at):
        """Send a picture of the scene with the frame at U_x = `at` nm, unless a newer one is wanted first; or False."""
        if self._source(scene) is None:
            return False
        self.wanted = scene, at, self.session.acknowledged
        if self.task is None:
            self._submit()
        return True

    @property
    def moves(self):
        """Whether pictures, sent or on their way, have left the last run behind."""
        return self.task is not None or self.shown is not None

    def leave(self):
        """No picture is wanted any longer."""
        self.forget()
        self.wanted = None

    def _source(self, scene):
        """The pickled Skeleton to go on from to a scene: of the page that is open if it has a nearer one, or None."""
        origin = (self.shown or self.session.run.scene) if self.skeleton else None
        return self.session.pages.nearer(scene, origin) or self.skeleton

    def _submit(self):
        (scene, at, number), self.wanted = self.wanted, None
        call = (followed, self._source(scene), scene, at)
        self.ask(call, lambda made: self._take(made, scene, number), rank=SCREEN)

    def _take(self, made, scene, number):
        if not isinstance(made, Followed):
            metrics.not_followed.labels(made or "the worker was lost").inc()
            scene, self.wanted = self.wanted[0] if self.wanted else scene, None
            self.shown = None
            return self.start(scene)
        metrics.count("followed")
        self.skeleton, self.shown = made.skeleton, scene
        self.session.wire.hand = struct.pack("<d", nan if number is None else number) + made.picture
        if self.wanted:
            self._submit()

    def judge(self, scene, blocks):
        """The exact run of a scene is done: compare it with the picture of it, if there was one, and say so."""
        if self.shown != scene:
            return
        columns = [packing.unpack(block)[1] for block in blocks]
        stage, U_x, F_bar, slip, at = (
            np.concatenate([each[name] for each in columns]) for name in ("stage", "U_x", "F_bar", "slip", "slip_at")
        )
        sheared = stage == packing.ORDER.index("shear")
        exact = (U_x[sheared].astype(float), F_bar[sheared], at[sheared & (slip > 0)].tolist())
        Wanted(self.session).ask((compared, self.skeleton, *exact), lambda off: self._judged(off, scene), rank=LATER)

    def _judged(self, off, scene):
        if off is None:
            return
        off_U, off_F = off
        agreed = off_U <= AGREE_U and off_F <= AGREE_F
        metrics.count("agreed" if agreed else "disagreed")
        if not agreed:
            where = {name: getattr(scene, name) for name in SHOWN}
            log.info("a followed run was off: slips by %.2g nm, F by %.2g of its largest, %s", off_U, off_F, where)
            if self.session.scene == scene:
                how = f"by {off_U:.2g} nm at a slip" if np.isfinite(off_U) else "by a slip more or less"
                self.session.notes = [f"{OFF} was off {how}; the exact run has taken its place."]
                self.session.publish()
