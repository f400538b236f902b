"""The page "What matters": sensitivities of the first slip to each parameter and to the strength of each node.

A worker computes the run of the scene on screen and its derivatives (`solver.analysis.sensitivities`). The browser
draws both (page.js); it colours the nodes in the view of the punch.
"""

from typing import Any

from bokeh import plotting

from app.pages import Sheet
from app.service import tasks
from app.service.pool import HEAVY
from solver import Scene

TITLE, ORDER, FIGURES = "What matters", 5, ()
LOST = "it could not be computed. Change a parameter to try again"
LONG = 120.0  # s, time limit of a run with its derivatives


def figure(scene: Scene) -> Any:
    """Return the change of the force of the first slip per parameter as bars, for a notebook."""
    found = tasks.what_matters(scene)
    if isinstance(found, str):
        raise ValueError(found)
    bars = {name: values[1] for name, values in found["bars"].items() if values[1] is not None}
    names = sorted(bars, key=lambda name: abs(bars[name]))
    label = "change of the force of the first slip for 1 % more (%)"
    made = plotting.figure(y_range=names, x_axis_label=label, width=640, height=400, toolbar_location=None)
    made.hbar(y=names, right=[bars[name] for name in names], height=0.7)
    return made


class Page(Sheet):
    """The page of one visitor; see app/pages."""

    def scene_changed(self) -> None:
        """Request the derivatives of the scene on screen."""
        self.publish(matters=None, texts={"matters-text": "Computing the derivatives …"})
        self.single.ask((tasks.what_matters, self.session.scene), self._take, rank=HEAVY, seconds=LONG)

    def _take(self, found):
        if found is None or isinstance(found, str):
            return self.publish(matters=None, texts={"matters-text": f"No result: {found or LOST}."})
        self.publish(matters=found, texts={"matters-text": ""})
