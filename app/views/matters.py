"""The page "What matters": by how much each parameter moves the first slip, and which nodes hold the contact.

A worker computes the run of the scene on screen and its derivatives (`solver.analysis.sensitivities`); the browser
draws both (static/js/pages/matters.js), the nodes in the hero.
"""

from app.service import tasks
from app.service.pool import HEAVY
from app.service.wanted import Wanted
from app.views.pages import Sheet

LONG = 120.0  # s that the run of a scene and its derivatives may take


def compose():
    """No figures of its own."""
    return []


class Page(Sheet):
    """See pages.py."""

    def __init__(self, *given):
        super().__init__(*given)
        self.wanted = Wanted(self.session)

    def scene_changed(self):
        """Another scene is on screen."""
        self.publish(matters=None, texts={"matters-said": "computing …"})
        self.wanted.ask((tasks.what_matters, self.session.scene), self._take, rank=HEAVY, seconds=LONG)

    def close(self):
        """Ask for nothing any longer."""
        self.wanted.forget()

    def _take(self, found):
        if found is None or isinstance(found, str):
            why = found or "it was not computed; change a parameter to try again"
            return self.publish(matters=None, texts={"matters-said": f"Nothing to say: {why}."})
        self.publish(matters=found, texts={"matters-said": ""})
