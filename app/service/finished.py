"""Finished runs, shared by all visitors of the server: a class that follows the same steps computes each only once."""

from contextlib import suppress

from cachetools import LRUCache

from app.service import metrics

CAPACITY = 100e6  # bytes; some 70 runs
BESIDE = 2000  # bytes that a run takes beside its frames: its Scene, and the record of it


class Shelf(LRUCache):
    """Frames of whole runs by Scene, or by any key that one visitor alone knows: those used last, `maxsize` bytes."""

    def __init__(self, capacity=CAPACITY):
        super().__init__(capacity, lambda run: BESIDE + sum(map(len, run.blocks)) + len(run.skeleton or b""))

    def put(self, key, run):
        """Keep a run, unless it is larger than the shelf."""
        with suppress(ValueError):
            self[key] = run


shelf = Shelf()
metrics.gauge("shelf_bytes", "of finished runs that are kept", lambda: shelf.currsize)
