"""A request of a visitor, and one run of a scene: its progress, its next slice, and its status for the browser."""

from dataclasses import dataclass, field, replace

from app.service import worker
from app.service.packing import Frames
from app.service.pool import EXACT, HEAVY, SCREEN
from solver import Scene

ATTEMPTS = 3  # slices that may be lost with their worker before the run fails
ERROR = "an error of the server, which its log describes; choose an experiment to start again"


@dataclass(frozen=True)
class RunRequest:
    """The Scene to show.

    held: a slider is held, and the frame at U_x = `at` nm is on screen; number: of the order with this request.
    """

    scene: Scene
    held: bool = False
    at: float = 0.0
    number: float | None = None


@dataclass
class Run:
    """One run of a scene; `state` is warming, running, paused, skipped, finished or failed."""

    number: int
    scene: Scene
    total: int  # expected number of frames
    state: str
    started: float  # s, monotonic
    paused: float = 0.0  # s, monotonic: when it was paused last
    checkpoint: bytes | None = None  # state of the last slice, for the next
    frames: int = 0
    packed: Frames = field(default_factory=Frames)  # their blocks are dropped after the run
    seconds: float = 0.0
    heavy: bool = False  # whether an increment is so expensive that the run must not delay others
    refines: bool = False  # whether it replaces a picture: the browser shows it when complete
    lost: int = 0
    why: str = ""

    def slice(self, budget):
        """Return (call, {"rank", "seconds"}) of the next slice; budget: s of work."""
        rank = HEAVY if self.heavy else EXACT if self.refines else SCREEN
        limit = worker.SLOW if self.heavy else worker.QUICK
        call = worker.compute, self.scene, self.checkpoint, budget, limit
        return call, {"rank": rank, "seconds": worker.APPROACH * budget}

    def pause(self, now):
        """Stop until `resume`; now: s, monotonic. The time between is not counted."""
        self.state, self.paused = "paused", now

    def resume(self, now):
        """Continue a paused run."""
        self.state, self.started = "running", self.started + now - self.paused

    def add(self, piece, now):
        """Add a Slice; now: s, monotonic."""
        self.checkpoint = piece.state
        self.frames += piece.frames
        self.heavy = piece.heavy
        self.total = self.frames + piece.ahead
        self.packed += piece
        self.seconds = now - self.started
        if self.state == "warming":
            self.state, self.started = "running", now
        if piece.done:
            self.state, self.why = ("failed", piece.failure) if piece.failure else ("finished", "")
            self.total = self.frames if self.state == "finished" else self.total

    def ends_within(self, seconds):
        """Whether the run ends within `seconds` at its current rate."""
        return not self.heavy and self.seconds * (self.total - self.frames) <= seconds * self.frames

    def lose(self, lost):
        """Count a lost slice; return why the run fails, or an empty text if the slice should be repeated."""
        self.lost, kind = self.lost + 1, getattr(lost, "kind", "closed")
        if kind == "crash" and self.lost < ATTEMPTS:
            return ""
        if kind == "crash":
            return f"{ATTEMPTS} workers ended during this run; change a parameter or choose an experiment"
        if kind == "hang":
            return f"{lost}, so the worker was ended; what is computed stays. Change a parameter"
        why = str(lost) or "the server is being stopped"
        return ERROR if kind == "error" else f"{why}; choose an experiment to try again"

    def take_over(self, cached):
        """Finish the run with its cached Frames."""
        self.state, self.packed = "finished", replace(cached, blocks=(), skeleton=None)
        self.total = self.frames = cached.frames

    def leave(self):
        """Drop the blocks; frames can be computed again."""
        self.checkpoint = None
        self.packed = replace(self.packed, blocks=(), skeleton=None)

    def status(self):
        """Return the status for the browser, as plain data."""
        return {
            "state": "refining" if self.refines and self.state == "running" else self.state,
            "run": self.number,
            "frames": self.frames,
            "total": self.total,
            "evaluations": self.packed.evaluations,
            "seconds": round(self.seconds, 3),
            "residual": self.packed.residual,
            "tolerance": self.scene.tolerance,
            "why": self.why,
            "known": self.state == "finished" and self.seconds == 0.0,
        }
