"""The pages beside the experiment. A page exists only while it is open, so closed pages cost nothing.

A page is a folder here with a page.py:

    TITLE, ORDER    its name, and its place in the menu
    Page            a Sheet: the page of one visitor

page.html is its section of the document, where `modules` has all page.py by name. page.js is its script, which draws
its charts. A page publishes one dictionary. The browser shows these entries of it, and page.js receives all; what
has not changed is not sent again:

    texts {element: text}, hidden {element: whether}, busy (share done or None)
"""

import logging
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from app.service.requests import Requests
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
    return f'{{% call sheet("{name}") %}}{{% endcall %}}'


class Sheet:
    """The page of one visitor. Subclasses override the handlers; the defaults do nothing.

    `sweep` requests many calls from the workers, `single` one at a time.
    """

    def __init__(self, session: Any, name: str) -> None:
        """name: of its folder."""
        self.session, self.name = session, name
        self.published = {}
        self.sweep, self.single = Requests(session, self.take), Requests(session)

    def publish(self, **news: Any) -> None:
        """Send what has changed of the news, unless the page is closed."""
        news = {name: value for name, value in news.items() if self.published.get(name, self) != value}
        self.published |= news
        if news and self.session.pages.page is self:
            self.session.send("opened", **{"open": self.name} | news)

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


class Pages:
    """The open page of one visitor, if any. Every method runs under the lock of the visitor's document."""

    def __init__(self, session: Any) -> None:
        self.session = session
        self.page: Any = None  # the open one

    def open(self, page: str) -> bool:
        """Show the page of this name instead of the open one, '' for none; return whether there is such a page."""
        self.close()
        if page not in listed():
            return page == ""
        self.page = listed()[page].Page(self.session, page)
        self.page.start()
        self.page.publish(open=page)
        log.info("a visitor opened the page %s", page)
        return True

    def close(self) -> None:
        """Cancel the calls of the open page."""
        if self.page is not None:
            page, self.page = self.page, None
            page.close()
            self.session.send("opened")

    def scene_changed(self) -> None:
        """The experiment shows another scene from now on."""
        if self.page is not None:
            try:
                self.page.scene_changed()
            except Exception:  # the run goes on without the page
                log.exception("the page %s failed", self.page.name)

    def order(self, **values: Any) -> None:
        """Pass an order from the browser to the open page."""
        if self.page is not None:
            self.page.order(values)
