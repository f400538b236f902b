"""Runs beside the one on screen: those pinned in an address, computed in the background and sent whole."""

from app.service import packing, worker
from app.service.finished import Finished
from app.service.pool import LATER
from app.service.wanted import Wanted
from app.session.controls import scene_from_address

FIRST = 1_000_000  # numbers of these runs lie above, as BESIDE in run.js
MOST = 4
BUDGET = 0.12  # s of work in a slice


class Beside:
    """The pinned runs that a visitor's browser waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        self.session, self.wanted = session, {}  # by number

    def want(self, entries):
        """Send the run of an address {name: text} under the number entries["beside"]; one that fails is not sent."""
        number = entries["beside"]
        if FIRST < number <= FIRST + MOST:
            texts = {name: [text.encode()] for name, text in entries.items() if name != "beside"}
            scene = scene_from_address(texts)[0]
            known = self.session.shelf.get(scene)
            if known is not None:
                self._send(number, known.blocks)
            else:
                self._go_on(number, scene, None, [])

    def close(self):
        """Wait for nothing any longer."""
        for wanted in self.wanted.values():
            wanted.forget()

    def _go_on(self, number, scene, before, pieces):
        call = (worker.compute, scene, before and before.checkpoint, BUDGET, before and before.last)
        wanted = self.wanted.setdefault(number, Wanted(self.session))
        wanted.ask(call, lambda piece: self._take(number, scene, piece, pieces), rank=LATER, seconds=BUDGET)

    def _take(self, number, scene, piece, pieces):
        if piece is None or piece.failure:
            return
        pieces = [*pieces, piece]
        if not piece.done:
            return self._go_on(number, scene, piece, pieces)
        blocks = tuple(block for one in pieces for block in one.blocks)
        sums = [sum(one.frames for one in pieces), sum(one.evaluations for one in pieces)]
        largest = [max(getattr(one, name) for one in pieces) for name in ("residual", "widest", "safe_damping")]
        self.session.shelf.put(scene, Finished(blocks, *sums, *largest, skeleton=piece.skeleton))
        self._send(number, blocks)

    def _send(self, number, blocks):
        for block in blocks:
            self.session.wire.chunk = packing.numbered(number, block)
