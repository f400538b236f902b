"""A wish, and one computation of one scene: how far it is, the next slice, and what the browser shows of it."""

from dataclasses import dataclass, field, replace

from app.service import packing, worker
from app.service.packing import Frames
from app.service.pool import EXACT, HEAVY, SCREEN
from solver import Scene

LIVES = 3  # how often a slice may be lost with its worker before the run counts as failed
ERROR = "the server made an error, which is in its log; choose an experiment to start again"


@dataclass(frozen=True)
class Wish:
    """The Scene to show; after: (number of a run, frame) to carry on from.

    held: a slider is held, and the frame at U_x = `at` nm is on screen; number: of the order that asks for it.
    """

    scene: Scene
    after: tuple | None = None
    held: bool = False
    at: float = 0.0
    number: float | None = None


@dataclass
class Run:
    """One computation of one scene; `state` is warming, running, paused, finished or failed."""

    number: int
    scene: Scene
    total: int  # frames, as far as is known
    state: str
    started: float  # s, monotonic
    kept: bytes | None = None  # of the last slice, for the next
    history: tuple = ()  # ((Scene, frames), ...) of the runs that this one carries on
    after: tuple = ()  # (number of a run, frame) from which this one carries on, as the browser knows them
    frames: int = 0  # with those before
    made: Frames = field(default_factory=Frames)  # its own, whose blocks are kept as long as it lasts
    seconds: float = 0.0
    heavy: bool = False  # whether an increment takes so long that the run must not be in the way of others
    refines: bool = False  # whether it takes the place of a picture: the browser shows it once it is whole
    lost: int = 0
    why: str = ""
    kept_as: object = None  # under what the blocks are on the shelf since, as long as there is room

    def slice(self, budget):
        """(call, {"rank", "seconds"}) of the next slice, with so many s of work."""
        rank = HEAVY if self.heavy else EXACT if self.refines else SCREEN
        limit = worker.SLOW if self.heavy else worker.QUICK
        call = worker.compute, self.scene, self.kept, budget, self.history, limit
        return call, {"rank": rank, "seconds": worker.APPROACH * budget}

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

    def ends_within(self, seconds):
        """Whether, at its pace until now, the run ends within so many s."""
        return not self.heavy and self.seconds * (self.total - self.frames) <= seconds * self.frames

    def lose(self, lost):
        """A slice was lost: why the run fails; empty where the slice is to be computed again, as it is pure."""
        self.lost, kind = self.lost + 1, getattr(lost, "kind", "closed")
        if kind == "crash" and self.lost < LIVES:
            return ""
        if kind == "crash":
            return f"{LIVES} workers ended while they computed it; change a parameter or choose an experiment"
        if kind == "hang":
            return f"{lost}, so the worker was ended; what is computed stays. Change a parameter"
        why = str(lost) or "the server is being stopped"
        return ERROR if kind == "error" else f"{why}; choose an experiment to try again"

    def take_over(self, known):
        """All of it is known: its Frames."""
        self.state, self.kept_as, self.made = "finished", self.scene, replace(known, blocks=(), skeleton=None)
        self.total = self.frames = known.frames

    def shelve(self, shelf):
        """Go on the Shelf: for all visitors, or for this one alone where it is no whole run of its scene."""
        self.kept_as = self.scene if self.state == "finished" and not self.history else object()
        shelf.put(self.kept_as, self.made)

    def leave(self):
        """Another takes its place: keep what tells how frames of it came about, and nothing else."""
        self.kept = None
        self.made = replace(self.made, blocks=(), skeleton=None)

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
