"""The pages beside the experiment. A page exists only while it is open, so closed pages cost nothing.

A page is a folder here with a page.py:

    TITLE, ORDER, FIGURES    its name, its place in the menu, the slots of its figures
    compose()                the Bokeh figures, each named page_slot, if there are any
    Page                     a Sheet: the page of one visitor

page.html is its section of the document, where `modules` has all page.py by name. Without it, the section has a title
and the figures. page.js is its script. A page publishes one dictionary. The browser shows these entries of it, and
page.js receives all:

    texts {element: text}, hidden {element: whether}, busy (share done or None), images {view.label: (low, high)}
"""

import logging
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.models import Column

from app.document import frozen
from app.service.requests import Requests
from app.views.plots import View, view_of
from solver import Scene
from solver.following.skeleton import Skeleton

log = logging.getLogger("app")
HERE = Path(__file__).parent


@cache
def listed() -> dict[str, Any]:
    """Return {name: module} of all pages, in the order of the menu."""
    modules = {
        path.parent.name: import_module(f"{__name__}.{path.parent.name}.page") for path in HERE.glob("*/page.py")
    }
    return dict(sorted(modules.items(), key=lambda item: item[1].ORDER))


def section(name: str) -> str:
    """Return the section of a page in the document, as a template."""
    own = HERE / name / "page.html"
    if own.exists():
        return own.read_text(encoding="utf-8")
    figures = "".join(f'{{% call plot("{name}_{slot}") %}}{{% endcall %}}' for slot in listed()[name].FIGURES)
    return f'{{% call sheet("{name}") %}}<div class="figures">{figures}</div>{{% endcall %}}'


def places() -> dict[str, Column]:
    """Return {page_slot: empty Column for the figure}."""
    names = [f"{name}_{slot}" for name, page in listed().items() for slot in page.FIGURES]
    return {name: Column(sizing_mode="stretch_both") for name in names}


class Sheet:
    """The page of one visitor, with its views {slot: View}. Subclasses override the handlers; the defaults do nothing.

    `sweep` requests many calls from the workers, `single` one at a time.
    """

    def __init__(self, session: Any, publish: Callable[..., None], views: dict[str, View]) -> None:
        self.session, self.publish, self.views = session, publish, views
        self.published = {}
        self.sweep, self.single = Requests(session, self.take), Requests(session)

    def start(self) -> None:
        """Called when the page opens."""
        self.scene_changed()

    def scene_changed(self) -> None:
        """The experiment shows another scene from now on."""

    def order(self, values: dict[str, Any]) -> None:
        """Called with the values of the page's own controls."""

    def nearer(self, scene: Scene, origin: Scene | None) -> Skeleton | None:
        """Return a Skeleton nearer to a scene than the Scene `origin` (or None), if the page has one."""

    def take(self, call: Any, result: Any) -> None:
        """Called with the result of a call of `sweep`."""

    def close(self) -> None:
        """Cancel all calls."""
        self.sweep.cancel()
        self.single.cancel()

    def draw(self, slot: str, part: str, **columns: Any) -> None:
        """Replace data columns of a part of a figure. Nothing is sent if they are the same."""
        source = self.views[slot].parts[part].data_source
        before = dict(source.data)
        if not all(name in before and np.array_equal(before[name], values) for name, values in columns.items()):
            source.data = before | columns


class Pages:
    """The open page of one visitor, if any. Every method runs under the lock of the visitor's document."""

    def __init__(self, session: Any) -> None:
        self.session = session
        self.slots = places()
        self.name = ""
        self.page: Any = None

    def open(self, page: str) -> bool:
        """Show the page of this name instead of the open one, '' for none; return whether there is such a page."""
        self._leave()
        if page not in listed():
            return page == ""
        self.name, self.page = page, self._made(page)
        with frozen(self.session.doc):
            for slot, view in self.page.views.items():
                self.slots[f"{page}_{slot}"].children = [view.figure]
        self.page.start()
        self._publish(self.page, {})
        log.info("a visitor opened the page %s", page)
        return True

    def _made(self, name):
        figures = listed()[name].compose() if listed()[name].FIGURES else []
        views = {figure.name.removeprefix(f"{name}_"): view_of(figure) for figure in figures}
        page = listed()[name].Page(self.session, lambda **news: self._publish(page, news), views)
        page.published = {"open": name, "figures": [figure.name for figure in figures]}
        return page

    def _leave(self):
        """Remove the models and cancel the calls of the open page."""
        if self.page is not None:
            page, self.page = self.page, None
            page.close()
            for slot in page.views:
                self.slots[f"{self.name}_{slot}"].children = []
            self.name = ""
            self._tell()

    def close(self) -> None:
        """Cancel all calls: the visitor left."""
        self._leave()

    def scene_changed(self) -> None:
        """The experiment shows another scene from now on."""
        if self.page is not None:
            self.page.scene_changed()

    def order(self, **values: Any) -> None:
        """Pass an order from the browser to the open page."""
        if self.page is not None:
            self.page.order(values)

    def _publish(self, page, news):
        """Send the news of a page, unless it is closed."""
        before, page.published = page.published, page.published | news
        if page is self.page and (page.published != before or not news):
            self._tell()

    def _tell(self):
        """Send the state of the open page. Later, as Panel sends it at once, but Bokeh its figures after this call."""
        content = self.page.published if self.page else {}
        self.session.later(lambda: self.session.send("beside", **content))
