"""The page "What matters": by how much each parameter moves the first slip, and which nodes hold the contact.

A worker computes the run of the scene on screen and its derivatives (`solver.analysis.sensitivities`); the browser
draws both (page.js), the nodes in the hero. On request, what is known of the curves if each
parameter has a spread: a band, and intervals of the first slip, by derivatives and by runs (`solver.analysis.spread`).
"""

from app.pages import Sheet
from app.service import tasks
from app.service.pool import HEAVY
from app.service.requests import Requests

TITLE, ORDER, FIGURES = "What matters", 5, ()
WIDEST, DRAWS = 50.0, 100  # per cent, and runs, at most
LOST = "it was not computed; change a parameter to try again"
LONG = 120.0  # s that the run of a scene and its derivatives may take


def compose():
    """No figures of its own."""
    return []


class Page(Sheet):
    """See pages.py."""

    def __init__(self, *given):
        super().__init__(*given)
        self.known = Requests(self.session)

    def scene_changed(self):
        """Another scene is on screen."""
        self.known.cancel()
        self.publish(matters=None, band=None, busy=None, texts={"matters-said": "computing …"})
        self.wanted.ask((tasks.what_matters, self.session.scene), self._take, rank=HEAVY, seconds=LONG)

    def order(self, values):
        """A band for a spread in per cent, checked by so many runs; or none."""
        self.known.cancel()
        percent, draws = values.get("percent", 0.0), int(min(values.get("draws", 0), DRAWS))
        if not 0.0 < percent <= WIDEST:
            return self.publish(band=None, busy=None)
        self.publish(busy=0.0)
        call = tasks.spread_band, self.session.scene, percent, max(draws, 0)
        self.known.ask(call, self._take_band, rank=HEAVY, seconds=LONG)

    def close(self):
        """Ask for nothing any longer."""
        super().close()
        self.known.cancel()

    def _take_band(self, found):
        if found is None or isinstance(found, str):
            return self.publish(band=None, busy=None, texts={"matters-said": f"No band: {found or LOST}."})
        scene = self.session.scene
        self.publish(band=found | {"force": scene.width * scene.E, "width": scene.width}, busy=None)

    def _take(self, found):
        if found is None or isinstance(found, str):
            return self.publish(matters=None, texts={"matters-said": f"Nothing to say: {found or LOST}."})
        self.publish(matters=found, texts={"matters-said": ""})
