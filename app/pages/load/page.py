"""The page "Friction over load": force and load of the first slip of every run that this visitor has seen.

The browser collects the points (static/js/slips.js) and draws them (page.js). A sweep of the press depth adds points of
runs that nobody has seen: workers compute them.
"""

from typing import Any

from bokeh.models import Span
from bokeh.models.glyphs import Line, Scatter

from app.pages import Sheet
from app.schema import CHANGES
from app.service import tasks
from app.views.plots import add, add_zero, blank, draw
from solver import SceneError
from solver.files import plain
from solver.scene import PARAMETERS

TITLE, ORDER, FIGURES = "Friction over load", 3, ("slips",)
DEPTHS = tuple(k / 10 for k in range(-3, 9))  # delta_bar of a sweep: from a pull to a firm press


def compose() -> list[Any]:
    tooltips = [("", "@label"), ("L", "@L{0.0} N/m"), ("Fₛ", "@F{0.0} N/m")]
    plot = blank("load_slips", "load L (N/m)", "friction Fₛ (N/m)")
    add_zero(plot)
    add(plot, "no load", Span(dimension="height", location=0.0, line_width=2, line_dash="dashed"), "--text")
    draw(plot, Line, "mark runs", "--repulsive", "L", "F", line_width=1.5)
    draw(plot, Line, "mark line", "--text", "L", "F", line_width=2, line_dash="dotted")
    draw(plot, Scatter, "mark now", "--cursor", "L", "F", marker="circle", size=18, fill_alpha=0.0, line_width=2)
    for name, node in CHANGES.items():
        look = {"tooltips": tooltips, "marker": node.marker, "size": node.size}
        draw(plot, Scatter, name, node.colour, "L", "F", "label", **look)
    return [plot]


class Page(Sheet):
    """The page of one visitor; see app/pages."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.swept: list[dict[str, Any]] = []  # points as in static/js/slips.js
        self.why = ""  # there is no sweep, or a run of it failed

    def scene_changed(self) -> None:
        """Publish what there is."""
        self._publish()

    def order(self, values: dict[str, Any]) -> None:
        """Sweep the press depth of the scene on screen, cancel that, or clear its points."""
        what = values.get("what")
        if what in ("sweep", "cancel", "clear"):
            self.sweep.cancel()
            self.swept, self.why = [], ""
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
        self.publish(busy=self.sweep.part, swept=self.swept, texts={"load-why": self.why})
