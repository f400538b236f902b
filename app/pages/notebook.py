"""The figures of a page for a notebook: computed in the calling process, in the colours of the light theme."""

import re
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache
from pathlib import Path
from typing import Any

from bokeh.layouts import gridplot
from bokeh.palettes import RdBu

from app.service.fair_queue import Task
from app.service.jobs import Jobs
from app.views.plots import view_of
from solver import Scene

STYLE = Path(__file__).parents[1] / "static" / "style.css"
SIZE = {"sizing_mode": "fixed", "width": 520, "height": 340}  # of a figure, px


class Session:
    """The parts of a session that a Sheet needs. `submit` runs a call at once."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.jobs = scene, Jobs(self)  # type: ignore[arg-type]

    def later(self, call: Any) -> None:
        """Call at once; see the session."""
        call()

    def submit(self, call: Any, *arguments: Any, **how: Any) -> Future:
        """Run a call and return its finished Future; see the pool."""
        done = Future()
        done.set_result(call(*arguments))
        return done

    def abandon(self, task: Task, end: bool = False) -> None:
        """Do nothing; see the pool."""


def page_of(compose: Callable[[], list], Page: Any, scene: Scene) -> Any:
    """Return the Page of a Scene with the figures of `compose`; `published` has its output."""
    views = {figure.name.split("_", 1)[1]: view_of(figure) for figure in compose()}
    page: Any = Page(Session(scene), lambda **news: page.published.update(news), views)
    return page


def shown(compose: Callable[[], list], Page: Any, scene: Scene) -> Any:
    """Return the figures of a page for a Scene side by side, as on the opened page."""
    page = page_of(compose, Page, scene)
    page.start()
    return laid_out(page)


def laid_out(page: Any) -> Any:
    """Return the coloured figures of a Sheet side by side."""
    for view in page.views.values():
        view.figure.update(**SIZE)
        for part in view.parts.values():
            if part.tags and part.tags[0]:
                tint(getattr(part, "glyph", part), colours()[part.tags[0]])
    for name, limits in page.published.get("images", {}).items():
        slot, label = name.split(".")
        most = max(map(abs, limits))
        mapper = page.views[slot.split("_", 1)[1]].parts[label].glyph.color_mapper
        mapper.update(palette=RdBu[11][::-1], low=-most, high=most)
    return gridplot([view.figure for view in page.views.values()], ncols=2, toolbar_location=None)


def tint(model: Any, colour: str) -> None:
    """Colour a line, a marker, a text or a band."""
    names = ("line_color", "fill_color", "text_color")
    model.update(**{name: colour for name in names if name in model.properties()})


@cache
def colours() -> dict[str, str]:
    """Return {variable of style.css: colour} of the light theme."""
    root = STYLE.read_text(encoding="utf-8").split(":root {", 1)[1].split("}", 1)[0]
    return dict(re.findall(r"(--[\w-]+): (#\w+)", root))
