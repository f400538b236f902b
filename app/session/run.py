"""One computation of one scene, as far as it has come, and what the browser is told about it."""

from dataclasses import dataclass, field, replace

from app.service import packing
from app.service.packing import Frames
from solver import Scene


@dataclass
class Run:
    """One computation of one scene; `state` is warming, running, paused, finished or failed."""

    number: int
    scene: Scene
    total: int
    state: str
    started: float  # s, monotonic
    kept: bytes | None = None  # of the last slice, for the next
    history: tuple = ()  # ((Scene, frames), ...) of the runs that this one goes on from
    after: tuple = ()  # (number of the run, frame) from which this one goes on, as the browser knows them
    frames: int = 0  # with those before
    made: Frames = field(default_factory=Frames)  # its own, whose blocks are kept as long as it lasts
    seconds: float = 0.0
    heavy: bool = False  # whether an increment takes so long that the run must not be in the way of others
    refines: bool = False  # whether it takes the place of a picture: the browser shows it once it is whole
    lost: int = 0
    why: str = ""
    kept_as: object = None  # under what the blocks are on the shelf since, as long as there is room

    def add(self, piece, now):
        """One more Slice is done; now: s, monotonic."""
        self.kept = piece.kept
        self.frames += piece.frames
        self.heavy = piece.heavy
        if piece.ahead is not None:
            self.total = self.frames + piece.ahead
        self.made += piece
        self.seconds = now - self.started
        if self.state == "warming":
            self.state, self.started = "running", now
        if piece.done:
            self.state, self.why = ("failed", piece.failure) if piece.failure else ("finished", "")
            self.total = self.frames if self.state == "finished" else self.total

    def take_over(self, known):
        """All of it is known: its Frames."""
        self.state, self.kept_as, self.made = "finished", self.scene, replace(known, blocks=())
        self.total = self.frames = known.frames

    def leave(self):
        """Another takes its place: keep what tells how frames of it came about, and nothing else."""
        self.kept = None
        self.made = replace(self.made, blocks=())

    def up_to(self, frame):
        """((Scene, frames), ...) that lead to a frame, that included: see `solver.carried_path`."""
        found, left = [], frame + 1
        for scene, count in self.history:
            if left <= count:
                return (*found, (scene, left))
            found.append((scene, count))
            left -= count
        return (*found, (self.scene, left))

    def place(self, k, shelf):
        """(packed block, row) of frame k as the browser numbers them, its own or on the Shelf; None if it is gone."""
        k -= sum(frames for _, frames in self.history)  # those of the runs before are not kept
        known = shelf.get(self.kept_as)
        for block in self.made.blocks or (known.blocks if known else ()):
            frames = packing.header(block)["frames"]
            if 0 <= k < frames:
                return block, k
            k -= frames
        return None

    def status(self):
        """The numbers for the browser, as plain data."""
        return {
            "state": "refining" if self.refines and self.state == "running" else self.state,
            "run": self.number,
            "after": self.after or None,
            "frames": self.frames,
            "total": self.total,
            "evaluations": self.made.evaluations,
            "seconds": round(self.seconds, 3),
            "residual": self.made.residual,
            "tolerance": self.scene.tolerance,
            "why": self.why,
            "known": self.state == "finished" and self.seconds == 0.0,
        }
