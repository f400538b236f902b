"""The pages beside the experiment: one is made when a visitor opens it and unmade when it is closed; no other costs.

A page is a module with compose() -> {name: View} and the class `Page`, made with the Session and a function
`publish(**news)`; it has views {slot: View} named page_slot, start(), scene_changed(), order(values) and close(). What
is published reaches the browser as one dictionary, of which it knows texts {element: text}, busy (part done or None)
and images {view.label: limits}; the rest is for the page's own script.
"""

import json
import logging
from importlib import import_module

from bokeh.models import Column

from app.views.plots import views

log = logging.getLogger("app")
TITLES = {
    "": "Experiment",
    "law": "Interface law",
    "stickslip": "Stick-slip",
    "arealaws": "Area laws",
    "solid": "Inside the solid",
}
# page: where its figures go
SLOTS = {
    "law": ("shear_map", "normal_map", "shear_law", "normal_law"),
    "stickslip": ("forces", "mean", "map"),
    "arealaws": ("runs", "threshold"),
    "solid": ("field",),
}


def compose_all():
    """Compose the figures of every page once, for all visitors: done when the server starts, as it takes a while."""
    for name in SLOTS:
        views(import_module(f"app.views.{name}").compose)


class Pages:
    """The page that one visitor has open, if any; every method runs under the lock of the visitor's document."""

    def __init__(self, session):
        self.session = session
        self.slots = {f"{page}_{slot}": Column(sizing_mode="stretch_both") for page in SLOTS for slot in SLOTS[page]}
        self.name, self.page, self.published = "", None, {}

    def open(self, name):
        """Show page `name` instead of the one that is open; '' for none."""
        self.close()
        if name not in SLOTS:
            return
        page = import_module(f"app.views.{name}").Page(self.session, lambda **news: self._publish(page, news))
        self.name, self.page = name, page
        for slot, view in page.views.items():
            self.slots[f"{name}_{slot}"].children = [view.figure]
        self.published = {
            "open": name,
            "figures": [view.name for view in page.views.values()],
        }
        page.start()
        self._publish(page, {})
        log.info("a visitor opened the page %s", name)

    def close(self):
        """Leave nothing behind of the page that is open, neither models nor work."""
        if self.page is not None:
            page, self.page = self.page, None
            page.close()
            for slot in SLOTS[self.name]:
                self.slots[f"{self.name}_{slot}"].children = []
            self.name, self.published = "", {}
            self.session.wire.page = "{}"

    def scene_changed(self):
        """The experiment shows another scene from now on."""
        if self.page is not None:
            self.page.scene_changed()

    def order(self, values):
        """An order from the browser to the page that is open."""
        if self.page is not None:
            self.page.order(values)

    def _publish(self, page, news):
        """Tell the browser, unless the visitor has left the page meanwhile."""
        if page is self.page:
            self.published = self.published | news
            self.session.wire.page = json.dumps(self.published)
