"""Computations for a visitor beside the run on screen. Every method runs under the lock of the document.

A film and the table of a layer belong to one visitor.
"""

from typing import Any

from app.service import tasks, worker
from app.service.pool import HEAVY
from app.service.requests import Requests
from app.session import orders
from app.session.orders import order

LONGEST_FILM = 20 * worker.SLOW  # s: a worker repeats the run up to the slip, and packs the states of its motion
GEOMETRY = ("nu", "height", "width", "nodes")  # the parameters that the table of a layer depends on
TABLES = 2  # tables that a visitor may wait for
ROWS, MODES, DEPTH = (16, 120), (16, 1024), (1.0, 1e6)  # ranges that a browser may request; DEPTH in nm


class Film(Requests):
    """The transient during a slip of the run on screen."""

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


class Layer(Requests):
    """Tables that turn tractions into stress inside the layer, one per geometry; the browser draws with them."""

    @order("layer", rows=orders.is_number, modes=orders.is_number, depth=orders.is_number)
    def request(self, rows: Any, modes: int, depth: float) -> None:
        """Send the table for the run on screen: {rows, modes, depth (nm) of the last row}.

        A browser repeats its request while it waits. That must not start the work again.
        """
        run = self.session.run
        if run is None:
            return
        scene = run.scene
        asked = {"rows": rows, "modes": modes, "depth": depth}
        rows = int(min(max(rows, ROWS[0]), ROWS[1]))
        modes = int(min(max(modes, MODES[0]), MODES[1], scene.nodes // 2))
        depth = min(max(depth, DEPTH[0]), DEPTH[1], scene.height * scene.width)
        head = {"asked": asked, "depth": depth, "geometry": [getattr(scene, name) for name in GEOMETRY]}
        call = tasks.layer_table, scene, depth, rows, modes
        if len(self.waiting) >= TABLES and call not in self.waiting:
            self.cancel()
        self.add_one(call, lambda made: self._made(made, head))

    def _made(self, made, head):
        if not isinstance(made, Exception):  # without a table the browser draws nothing
            counts, scale, body = made
            self.session.send("table", counts=counts, scale=scale, body=body, **head)
