"""Slow motion through a slip of the run on screen, when its visitor asks for it."""

from app.service import packing, worker
from app.service.film import slow_motion
from app.service.pool import LATER
from app.service.wanted import Wanted

NAME = "Slow motion"  # the browser knows by it what its notes begin with
FIRST = 2_000_000  # numbers of films lie above, as FILM in run.js: the frame that the slip led to is added
MOST = 20 * worker.SLOW  # s that it may take: an increment is made again, and every state on its way packed


class Film(Wanted):
    """The motion that the visitor waits for; every method runs under the lock of the document."""

    def want(self, values):
        """Send the motion that led to frame values["frame"] of run values["run"], or say why there is none."""
        self.forget()
        session, run, k = self.session, self.session.computing.run, values["frame"]
        session.notes = [note for note in session.notes if not note.startswith(NAME)]
        if run is None or run.number != values["run"]:
            return
        places = [run.place(frame, session.shelf) for frame in (k - 1, k)]
        if None in places:
            session.notes = [f"{NAME}: the increment before this slip belongs to a run that is no longer at hand."]
            return
        call = (slow_motion, run.scene, *places)
        self.ask(call, lambda made: self._made(made, k), rank=LATER, seconds=MOST)

    def _made(self, made, k):
        if made is None or isinstance(made, str):
            self.session.notes = [f"{NAME}: {made or 'it could not be computed'}."]
            return self.session.publish()
        for block in made:
            self.session.wire.chunk = packing.numbered(FIRST + k, block)
