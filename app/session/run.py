"""One computation of one scene, as far as it has come, and what the browser is told about it."""

from dataclasses import dataclass, field

from app.service import packing
from solver import Scene


@dataclass
class Run:
    """One computation of one scene; `state` is warming, running, paused, finished or failed."""

    number: int
    scene: Scene
    total: int
    state: str
    started: float  # s, monotonic
    checkpoint: object = None
    last: object = None  # of the slice before, for the next
    history: tuple = ()  # ((Scene, frames), ...) of the runs that this one goes on from
    after: tuple = ()  # (number of the run, frame) from which this one goes on, as the browser knows them
    frames: int = 0
    evaluations: int = 0
    residual: float = 0.0
    seconds: float = 0.0
    widest: float = 0.0  # part of w over which anything acted, at most
    safe_damping: float = 0.0  # the largest of its frames
    heavy: bool = False  # whether an increment takes so long that the run must not be in the way of others
    wish: Scene = None  # what was asked for: `scene`, but with its own increments
    refines: bool = False  # whether it takes the place of a coarser one: shown when it is done
    seen: bool = False  # whether the browser has some of it beyond the approach
    lost: int = 0
    why: str = ""
    blocks: list = field(default_factory=list)  # packed frames, as long as it lasts
    kept_as: object = None  # under what they are on the shelf since, as long as there is room

    @property
    def coarse(self):
        """Whether finer increments are asked for than these."""
        return self.scene != self.wish

    @property
    def coming(self):
        """Whether the run that was asked for is still to come, and one with coarser increments on screen."""
        return (self.refines and self.state == "running") or (self.coarse and self.state == "finished")

    def add(self, piece, now):
        """One more Slice is done; now: s, monotonic."""
        self.checkpoint, self.last = piece.checkpoint, piece.last
        self.frames += piece.frames
        self.heavy = piece.heavy
        if piece.ahead is not None:
            self.total = self.frames + piece.ahead
        self.evaluations += piece.evaluations
        for name in ("residual", "widest", "safe_damping"):
            setattr(self, name, max(getattr(self, name), getattr(piece, name)))
        self.blocks += piece.blocks
        self.seen = self.seen or piece.done or (piece.frames > 0 and piece.checkpoint.stage != "approach")
        self.seconds = now - self.started
        if self.state == "warming":
            self.state, self.started = "running", now
        if piece.done:
            self.state, self.why = ("failed", piece.failure) if piece.failure else ("finished", "")
            self.total = self.frames if self.state == "finished" else self.total
            self.checkpoint = self.last = None

    def take_over(self, known):
        """All of it is known: a Finished."""
        self.state, self.total, self.kept_as = "finished", known.frames, self.scene
        for name in ("frames", "evaluations", "residual", "widest", "safe_damping"):
            setattr(self, name, getattr(known, name))

    def place(self, k, shelf):
        """(packed block, row) of frame k as the browser numbers them, its own or on the Shelf; None if it is gone."""
        k -= sum(frames for _, frames in self.history)  # those of the runs before are not kept
        known = shelf.get(self.kept_as)
        for block in self.blocks or (known.blocks if known else ()):
            frames = packing.header(block)["frames"]
            if 0 <= k < frames:
                return block, k
            k -= frames
        return None

    def status(self):
        """The numbers for the browser, as plain data."""
        return {
            "state": "refining" if self.coming else self.state,
            "run": self.number,
            "after": self.after or None,
            "frames": self.frames,
            "total": self.total,
            "evaluations": self.evaluations,
            "seconds": round(self.seconds, 3),
            "residual": self.residual,
            "tolerance": self.scene.tolerance,
            "why": self.why,
            "coarse": self.coarse,
            "known": self.state == "finished" and self.seconds == 0.0,
        }


class Chains:
    """Which scenes a visitor's runs went through: all that a later run needs to go on from a frame of one of them."""

    def __init__(self, most=40, longest=40):
        self.most, self.longest = most, longest
        self._of = {}  # number of a run: ((Scene, frames), ..., (its own Scene, None))
        self._frames = {}  # number of a run: frames it has, with those before

    def reaches(self, number, frame):
        """Whether a run is known and has come to that frame."""
        return 0 <= frame < self._frames.get(number, 0)

    def too_long(self, number):
        """Whether a run has gone on from others so often that none should go on from it."""
        return len(self._of[number]) > self.longest

    def add(self, run):
        """Remember a run, and forget the oldest of too many."""
        self._of[run.number] = (*run.history, (run.scene, None))
        self.grown(run)
        if len(self._of) > self.most:
            oldest = min(self._of)
            del self._of[oldest], self._frames[oldest]

    def grown(self, run):
        """Remember how far a run has come."""
        self._frames[run.number] = run.frames

    def history(self, number, frame):
        """((Scene, frames), ...) that lead to a frame of a run, that frame included."""
        found, left = [], frame + 1
        for scene, count in self._of[number]:
            if count is None or left <= count:
                break
            found.append((scene, count))
            left -= count
        return (*found, (scene, left))
