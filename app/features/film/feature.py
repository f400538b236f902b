"""Slow motion: the transient during a slip, at one place of the top."""

from app import interface
from app.features.film import tasks
from app.service import worker
from app.service.job import HEAVY
from app.session import orders
from app.session.orders import order

LONGEST_FILM = 20 * worker.SLOW  # s: a worker repeats the run up to the slip, and packs the states of its motion


class Feature(interface.Feature):
    """The film of one visitor."""

    ORDER = 20
    PARAMS = {
        "film": "asks for the transient of a slip: run, frame",
        "slip": "states of the transient of a slip: frame, body (bytes); or why there are none",
    }

    @order("film", run=orders.is_whole, frame=orders.is_whole)
    def request(self, run: int, frame: int) -> None:
        """Send the transient that led to a frame of the run with this number, or the reason for a failure."""
        self.cancel()
        shown = self.session.run
        if shown is None or shown.number != run:
            return self._made("the run on screen has changed; try again", frame)
        call = (tasks.slow_motion, shown.scene, frame)
        how = {"rank": HEAVY, "seconds": LONGEST_FILM, "private": True}
        return self.ask(call, lambda made: self._made(made, frame), **how)

    def _made(self, made, frame):
        if made is None or isinstance(made, str):
            return self.session.send("slip", why=made or "it could not be computed; try again")
        for block in made:
            self.session.send("slip", frame=frame, body=block)
