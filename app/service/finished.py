"""Finished runs, shared by all visitors of the server: a class that follows the same steps computes each only once."""

from collections import OrderedDict
from dataclasses import dataclass
from threading import Lock

CAPACITY = 100e6  # bytes; some 70 runs
BESIDE = 2000  # bytes that a run takes beside its frames: its Scene, and this record


@dataclass(frozen=True)
class Finished:
    """A whole run, packed as `packing.pack` does: the blocks, and the sums over their frames."""

    blocks: tuple
    frames: int
    evaluations: int
    residual: float  # nm, the largest of the run
    widest: float = 0.0  # part of w over which anything acted, at most

    @property
    def size(self):
        return BESIDE + sum(map(len, self.blocks))


class Shelf:
    """Finished runs by Scene, or by any key that one visitor alone knows: those used last, up to `capacity` bytes."""

    def __init__(self, capacity=CAPACITY):
        self.capacity, self.size = capacity, 0
        self._runs, self._lock = OrderedDict(), Lock()

    def __contains__(self, scene):
        return scene in self._runs

    def __len__(self):
        return len(self._runs)

    def get(self, scene):
        """The Finished run of `scene`, or None."""
        with self._lock:
            if scene in self._runs:
                self._runs.move_to_end(scene)
            return self._runs.get(scene)

    def put(self, scene, run):
        """Keep a run, and drop those not used for longest."""
        with self._lock:
            if scene in self._runs or run.size > self.capacity:
                return
            self._runs[scene] = run
            self.size += run.size
            while self.size > self.capacity:
                self.size -= self._runs.popitem(last=False)[1].size

    def clear(self):
        """Keep none."""
        with self._lock:
            self._runs.clear()
            self.size = 0


shelf = Shelf()
