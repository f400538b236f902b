"""Small pictures of the presets, computed when the first visitor opens the gallery, and then there for all."""

import json
from collections import Counter
from functools import cache

from app.limits import coarse
from app.service import tasks
from app.service.sweep import LIVES, Sweep
from solver.continuation.state import OutOfTime
from solver.presets import presets


@cache
def _names():
    """{call: preset}"""
    return {(tasks.thumbnail, coarse(one.scene)): one.name for one in presets().values()}


class Gallery:
    """The pictures that one visitor waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        self.session, self.sweep, self.late = session, Sweep(session, self._take), Counter()

    def want(self):
        """Send the picture of every preset, one by one as they are made."""
        self.sweep.add(_names())

    def close(self):
        """Wait for nothing any longer."""
        self.sweep.cancel()

    def _take(self, call, found):
        self.late[call] += isinstance(found, OutOfTime)
        if isinstance(found, OutOfTime) and self.late[call] < LIVES:  # the machine was busy
            return self.sweep.add([call])
        drawn = None if isinstance(found, Exception) else found
        self.session.wire.thumbnail = json.dumps({"preset": _names()[call], "drawn": drawn})
