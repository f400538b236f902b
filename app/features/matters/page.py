"""The page "What matters": sensitivities of the first slip to each parameter and to the strength of each node.

A worker computes the run of the scene on screen and its derivatives (`solver.analysis.sensitivities`). The browser
draws both (page.js); it colours the nodes in the view of the punch.
"""

from app.features.matters import tasks
from app.features.pages.sheet import Sheet
from app.service.job import HEAVY

TITLE, ORDER = "What matters", 5
LOST = "it could not be computed. Change a parameter to try again"
LONG = 120.0  # s, time limit of a run with its derivatives


class Page(Sheet):
    """The page of one visitor; see app/features/pages."""

    def scene_changed(self) -> None:
        """Request the derivatives of the scene on screen."""
        self.publish(matters=None, texts={"matters-text": "Computing the derivatives …"})
        self.single.ask((tasks.what_matters, self.session.scene), self._take, rank=HEAVY, seconds=LONG)

    def _take(self, found):
        if found is None or isinstance(found, str):
            return self.publish(matters=None, texts={"matters-text": f"No result: {found or LOST}."})
        self.publish(matters=found, texts={"matters-text": ""})
