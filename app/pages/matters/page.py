"""The page "What matters": by how much each parameter moves the first slip, and which nodes hold the contact.

A worker computes the run of the scene on screen and its derivatives (`solver.analysis.sensitivities`); the browser
draws both (page.js), the nodes in the picture of the punch.
"""

from bokeh import plotting

from app.pages import Sheet
from app.service import tasks
from app.service.pool import HEAVY

TITLE, ORDER, FIGURES = "What matters", 5, ()
LOST = "it could not be computed. Change a parameter to try again"
LONG = 120.0  # s that the run of a scene and its derivatives may take


def compose():
    """No figures of its own."""
    return []


def figure(scene):
    """Change of the force of the first slip by each parameter, as bars: what a notebook shows."""
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
    """See app/pages."""

    def scene_changed(self):
        """Another scene is on screen."""
        self.publish(matters=None, texts={"matters-said": "Computing the derivatives …"})
        self.wanted.ask((tasks.what_matters, self.session.scene), self._take, rank=HEAVY, seconds=LONG)

    def _take(self, found):
        if found is None or isinstance(found, str):
            return self.publish(matters=None, texts={"matters-said": f"No result: {found or LOST}."})
        self.publish(matters=found, texts={"matters-said": ""})
