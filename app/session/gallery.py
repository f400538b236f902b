"""Small pictures of the presets, computed when the first visitor opens the gallery, and then there for all."""

import json
from functools import cache

from app.limits import coarse
from app.service import tasks
from app.service.sweep import Sweep
from solver.presets import presets


@cache
def _names():
    """{call: preset}"""
    return {(tasks.thumbnail, coarse(one.scene)): one.name for one in presets().values()}


class Gallery(Sweep):
    """The pictures that one visitor waits for; every method runs under the lock of the document."""

    def __init__(self, session):
        super().__init__(session, self._made)

    def want(self):
        """Send the picture of every preset, one by one as they are made."""
        self.add(_names())

    def _made(self, call, found):
        drawn = None if isinstance(found, Exception) else found
        self.session.wire.thumbnail = json.dumps({"preset": _names()[call], "drawn": drawn})
