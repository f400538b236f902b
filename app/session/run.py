"""A request of a visitor, and one run of a scene: its progress, and its status for the browser."""

from dataclasses import dataclass, field, replace
from typing import Any

from app.service.job import ATTEMPTS
from app.service.packing import Frames
from solver import Scene

ERROR = "an error of the server, which its log describes; choose an experiment to start again"
ENDED = "skipped", "finished", "failed"


@dataclass(frozen=True)
class Request:
    """The Scene to show.

    held: a slider is held; number: of the order with this request. refines: the exact run of the prediction on screen.
    """

    scene: Scene
    held: bool = False
    number: float | None = None
    refines: bool = False


@dataclass
class Run:
    """One run of a scene; `state` is warming, running, skipped, finished or failed."""

    number: int
    scene: Scene
    total: int  # expected number of frames
    state: str
    started: float  # s, monotonic
    refines: bool = False  # whether it replaces a prediction: the browser shows it when complete
    known: bool = False  # whether it was in the cache
    parts: int = 0  # of its job that were sent
    lost: int = 0  # parts of its job that were repeated
    checked: tuple = ()  # of a prediction that is exact: how many states, folds and landings were checked
    packed: Frames = field(default_factory=Frames)  # without blocks
    seconds: float = 0.0
    why: str = ""

    @property
    def frames(self) -> int:
        return self.packed.frames

    @property
    def ended(self) -> bool:
        return self.state in ENDED

    @property
    def shown_state(self) -> str:
        """The state for the browser: a run that replaces a prediction is refining."""
        return "refining" if self.refines and self.state == "running" else self.state

    def add(self, part: Frames, now: float) -> None:
        """Count the frames of a part; now: s, monotonic."""
        self.parts += 1
        self.packed += replace(part, blocks=(), skeleton=None)
        self.total = self.frames + part.ahead
        self.seconds = 0.0 if self.known else now - self.started
        if self.state == "warming":
            self.state, self.started = "running", now

    def certify(self, about: Frames, checked: tuple[int, int, int], now: float) -> None:
        """Finish without frames, as the prediction on screen is exact; now: s, monotonic."""
        self.add(about, now)
        self.state, self.checked = "finished", checked

    def end(self, result: Any) -> None:
        """Finish, or fail: result is that of its job."""
        failure = result.failure if isinstance(result, Frames) else reason(result)
        self.state, self.why = ("failed", failure) if failure else ("finished", result.parted)

    def ends_within(self, seconds: float) -> bool:
        """Whether the run ends within `seconds` at its current rate."""
        return self.seconds * (self.total - self.frames) <= seconds * self.frames

    def status(self) -> dict[str, Any]:
        """Return the status for the browser, as plain data."""
        return {
            "state": self.shown_state,
            "run": self.number,
            "frames": self.frames,
            "total": self.total,
            "evaluations": self.packed.evaluations,
            "seconds": round(self.seconds, 3),
            "residual": self.packed.residual,
            "tolerance": self.scene.tolerance,
            "why": self.why,
            "known": self.known,
        }


def reason(error: Exception) -> str:
    """Return why a run has failed, from the error of its job."""
    kind = getattr(error, "kind", "error")
    if kind == "crash":
        return f"{ATTEMPTS} workers ended during this run; change a parameter or choose an experiment"
    if kind == "hang":
        return f"{error}, so the worker was ended; what is computed stays. Change a parameter"
    if kind == "closed":
        return f"{error}; choose an experiment to try again"
    return ERROR
