"""Finished runs, shared by all visitors of the server: a class that follows the same steps computes each only once."""

from dataclasses import dataclass

from app.service.kept import Kept

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
    safe_damping: float = 0.0  # the largest of its frames
    skeleton: bytes | None = None  # what a hand on a slider goes on from, if the run has one

    @property
    def size(self):
        return BESIDE + sum(map(len, self.blocks)) + len(self.skeleton or b"")


class Shelf(Kept):
    """Finished runs by Scene, or by any key that one visitor alone knows: those used last, up to `capacity` bytes."""

    def __init__(self, capacity=CAPACITY):
        super().__init__(capacity, lambda run: run.size)


shelf = Shelf()
