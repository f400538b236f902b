"""Pages beside the experiment: one at a time is open, and only the open one costs anything.

A page is a folder of app/features whose docstring says "Needs pages.", with a page.py:

    TITLE, ORDER    its name, and its place in the menu
    Page            a Sheet (sheet.py): the page of one visitor

beside.html is its section of the document, with the macros of pages/beside.html. page.js is its script, which draws
its charts. A page publishes one dictionary. The browser shows these entries of it, and page.js receives all; what has
not changed is not sent again:

    texts {element: text}, hidden {element: whether}, busy (share done or None)
"""

import logging
from functools import cache
from importlib import import_module
from typing import Any

from app import interface
from app.session import orders
from app.session.orders import order
from solver import Scene
from solver.following.skeleton import Skeleton

log = logging.getLogger("app")


@cache
def listed() -> dict[str, Any]:
    """Return {name: module} of all pages, in the order of the menu."""
    names = [name for name in interface.classes() if (interface.folder(name) / "page.py").exists()]
    modules = {name: import_module(f"app.features.{name}.page") for name in names}
    return dict(sorted(modules.items(), key=lambda item: item[1].ORDER))


class Feature(interface.Feature):
    """The open page of one visitor, if any."""

    PAGE = True
    ORDER = 10
    PARAMS = {
        "page": "opens a page beside the experiment: page",
        "ask": "controls of the page that is open: what, of, x, y",
        "opened": "of the page that is open beside the experiment, what has changed; or {}",
    }
    KEEPS = frozenset({"page"})

    def __init__(self, session: Any) -> None:
        super().__init__(session)
        self.page: Any = None  # the open one

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        has = lambda name, file: (interface.folder(name) / file).exists()  # noqa: E731
        return {
            "pages": {"": "Experiment"} | {name: page.TITLE for name, page in listed().items()},
            "blank": [name for name in listed() if not has(name, "beside.html")],
            "scripts_of": [name for name in listed() if has(name, "page.js")],
        }

    @order("page", page=orders.is_text)
    def open(self, page: str) -> None:
        """Show the page of this name instead of the open one, '' for none. A note names an unknown page."""
        self.close()
        if page in listed():
            self.page = listed()[page].Page(self.session, page)
            self.page.start()
            self.page.publish(open=page)
            log.info("a visitor opened the page %s", page)
        elif page:
            self.session.notes = [f"There is no page “{page}”: Menu lists all. The experiment is shown."]

    def close(self) -> None:
        """Cancel the calls of the open page."""
        if self.page is not None:
            page, self.page = self.page, None
            page.close()
            self.session.send("opened")

    def requested(self, scene: Scene) -> None:
        if self.page is not None:
            try:
                self.page.scene_changed()
            except Exception:  # the run goes on without the page
                log.exception("the page %s failed", self.page.name)

    def nearer(self, scene: Scene, origin: Scene | None) -> Skeleton | None:
        return self.page and self.page.nearer(scene, origin)

    @order("ask", **dict.fromkeys(("what", "of", "x", "y"), orders.is_text))
    def ask(self, **values: Any) -> None:
        """Pass the values of a page's own controls to the open page."""
        if self.page is not None:
            self.page.order(values)
