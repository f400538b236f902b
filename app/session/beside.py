"""Runs beside the one on screen: those pinned in an address, computed in the background and sent whole."""

from app.service import packing, tasks
from app.service.packing import Frames
from app.service.sweep import Sweep
from app.session.controls import scene_from_address

FIRST = 1_000_000  # numbers of these runs lie above, as BESIDE in run.js
MOST = 4


class Beside(Sweep):
    """The pinned runs that a visitor's browser waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        super().__init__(session, self._made)
        self.numbers = {}  # {call: numbers of its run}

    def want(self, entries):
        """Send the run of an address {name: text} under the number entries["beside"]; one that fails is not sent."""
        number = entries["beside"]
        if FIRST < number <= FIRST + MOST:
            texts = {name: [text.encode()] for name, text in entries.items() if name != "beside"}
            call = tasks.whole_run, scene_from_address(texts)[0]
            self.numbers.setdefault(call, []).append(number)
            known = self.session.shelf.get(call[1])
            if known is None:
                self.add([call])
            else:
                self._made(call, known)

    def _made(self, call, run):
        numbers = self.numbers.pop(call, ())
        if isinstance(run, Frames):
            self.session.shelf.put(call[1], run)
            for number in numbers:
                for block in run.blocks:
                    self.session.wire.chunk = packing.numbered(number, block)
