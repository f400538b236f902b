"""Small pictures of the presets, computed when the first visitor opens the gallery, and then there for all."""

import json
from functools import cache

from app.service import tasks
from app.service.sweep import Sweep
from app.session.computing import coarse
from solver.continuation.state import OutOfTime
from solver.presets import presets


@cache
def _names():
    """{call: preset}"""
    return {(tasks.thumbnail, coarse(one.scene)): one.name for one in presets().values()}


class Gallery:
    """The pictures that one visitor waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        self.session, self.sweep = session, Sweep(session, self._take)

    def want(self):
        """Send the picture of every preset, one by one as they are made."""
        self.sweep.add(_names())

    def close(self):
        """Wait for nothing any longer."""
        self.sweep.cancel()

    def _take(self, call, found):
        if isinstance(found, OutOfTime):  # the machine was busy
            return self.sweep.add([call])
        drawn = None if isinstance(found, Exception) else found
        self.session.wire.thumbnail = json.dumps({"preset": _names()[call], "drawn": drawn})
