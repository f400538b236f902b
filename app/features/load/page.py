"""The page "Friction over load": force and load of the first slip of every run that this visitor has seen.

The browser collects the points (slips.js) and draws them (page.js). A sweep of the press depth adds points of
runs that nobody has seen: workers compute them.
"""

from typing import Any

from app.features.load import tasks
from app.features.pages.sheet import Sheet
from solver import SceneError
from solver.files import plain
from solver.scene import PARAMETERS

TITLE, ORDER = "Friction over load", 3
DEPTHS = tuple(k / 10 for k in range(-3, 9))  # delta_bar of a sweep: from a pull to a firm press


class Page(Sheet):
    """The page of one visitor; see app/features/pages."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.swept: list[dict[str, Any]] = []  # points as in slips.js
        self.why = ""  # there is no sweep, or a run of it failed
        self.number = 0  # of sweeps

    def scene_changed(self) -> None:
        """Publish what there is."""
        self._publish()

    def order(self, values: dict[str, Any]) -> None:
        """Sweep the press depth of the scene on screen, cancel that, or clear its points."""
        what = values.get("what")
        if what in ("sweep", "cancel", "clear"):
            self.sweep.cancel()
            self.swept, self.why = [], ""
            self.number += 1
        if what == "sweep":
            try:
                scenes = [self.session.scene.changed(delta_bar=depth) for depth in DEPTHS]
                self.sweep.add([(tasks.first_slip, scene) for scene in scenes])
            except SceneError as error:
                self.why = f"No sweep: {error}"
        self._publish()

    def take(self, call: Any, result: Any) -> None:
        """Take the first slip of a run; a run without a slip has no point."""
        if isinstance(result, dict):
            scene = plain({name: getattr(call[1], name) for name in PARAMETERS})  # as the head of a run has it
            self.swept = [*self.swept, {"scene": scene, **result}]
        elif result is not None:
            self.why = f"Not computed at δ/δ₀ = {call[1].delta_bar:g}: {result}"
        self._publish()

    def _publish(self):
        self.publish(busy=self.sweep.part, sweep=self.number, swept=self.swept, texts={"load-why": self.why})
