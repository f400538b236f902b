"""What the pages share: publishing to the browser, and calls to the workers."""

from typing import Any

from app.service.requests import Requests
from solver import Scene
from solver.following.skeleton import Skeleton


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
        if news and self.session.features["pages"].page is self:
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
