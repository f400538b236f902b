"""The figures of a page without the app: computed where they are asked for, in the colours of the light page."""

import re
from concurrent.futures import Future
from functools import cache
from pathlib import Path
from types import SimpleNamespace

from bokeh.layouts import gridplot
from bokeh.palettes import RdBu

from app.service.tasks import Part
from app.views.plots import view_of

STYLE = Path(__file__).parents[1] / "static" / "style.css"
SIZE = {"sizing_mode": "fixed", "width": 520, "height": 340}  # px, of a figure


class Session:
    """What a Sheet needs of a session: the scene, and workers; here a call is made at once."""

    def __init__(self, scene):
        self.scene, self.bench = scene, SimpleNamespace(told={}, hear=None)
        self.doc = self.pool = self

    def add_next_tick_callback(self, call):
        """As of a document."""
        call()

    def submit(self, call, *arguments, **how):
        """As of the pool: the Future of a call, done."""
        done, made = Future(), call(*arguments)
        while isinstance(made, Part):
            made = call(*arguments, made.kept)
        done.set_result(made)
        return done

    def abandon(self, task):
        """As of the pool."""


def page_of(module, scene):
    """A Sheet of a page for a Scene; what it publishes is in `published`."""
    views = {figure.name.split("_", 1)[1]: view_of(figure) for figure in module.compose()}
    page = module.Page(Session(scene), lambda **news: page.published.update(news), views)
    return page


def shown(module, scene):
    """The figures of a page for a Scene, side by side, as the page draws them when it is opened."""
    page = page_of(module, scene)
    page.start()
    return laid_out(page)


def laid_out(page):
    """The figures of a Sheet side by side, in colours."""
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


def tint(model, colour):
    """Give a line, a mark, a word or a band its colour."""
    names = ("line_color", "fill_color", "text_color")
    model.update(**{name: colour for name in names if name in model.properties()})


@cache
def colours():
    """{variable of style.css: colour} of the light page."""
    root = STYLE.read_text(encoding="utf-8").split(":root {", 1)[1].split("}", 1)[0]
    return dict(re.findall(r"(--[\w-]+): (#\w+)", root))
