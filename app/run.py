"""One computation of one scene, as far as it has come, and what the browser is told about it."""

from dataclasses import dataclass, field

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
    lost: int = 0
    why: str = ""
    blocks: list = field(default_factory=list)  # packed frames so far

    def told(self):
        """The numbers for the browser, as plain data."""
        return {
            "state": self.state,
            "run": self.number,
            "after": self.after or None,
            "frames": self.frames,
            "total": self.total,
            "evaluations": self.evaluations,
            "seconds": round(self.seconds, 3),
            "residual": self.residual,
            "tolerance": self.scene.tolerance,
            "why": self.why,
            "known": self.state == "finished" and self.seconds == 0.0,
        }
