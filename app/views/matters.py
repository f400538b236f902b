"""The page "What matters": by how much each parameter moves the first slip, and which nodes hold the contact.

A worker computes the run of the scene on screen and its derivatives (`solver.analysis.sensitivities`); the browser
draws both (static/js/pages/matters.js), the nodes in the hero.
"""

from app.service import tasks
from app.service.pool import HEAVY
from app.views.pages import Sheet

LONG = 120.0  # s that the run of a scene and its derivatives may take


def compose():
    """No figures of its own."""
    return []


class Page(Sheet):
    """See pages.py."""

    def __init__(self, *given):
        super().__init__(*given)
        self.task = None

    def scene_changed(self):
        """Another scene is on screen."""
        self.close()
        self.publish(matters=None, texts={"matters-said": "computing …"})
        call = (tasks.what_matters, self.session.scene)
        task = self.task = self.session.pool.submit(*call, owner=id(self.session), rank=HEAVY, seconds=LONG)
        self.session.when_done(task, self._take)

    def close(self):
        """Ask for nothing any longer."""
        if self.task is not None:
            self.session.pool.abandon(self.task)
            self.task = None

    def _take(self, task):
        if task is not self.task:
            return
        self.task = None
        lost = task.cancelled() or task.exception()
        found = "it was not computed; change a parameter to try again" if lost else task.result()
        if isinstance(found, str):
            return self.publish(matters=None, texts={"matters-said": f"Nothing to say: {found}."})
        self.publish(matters=found, texts={"matters-said": ""})
