"""Features: whatever the page offers beside punch, curves, sliders and player. Each is a folder of app/features.

Delete a folder, and the app works without it. APP_FEATURES leaves features out, APP_FEATURES_PATH adds folders of
yours. This is the whole manual. All files of a folder but the first are optional:

    feature.py    begins with a docstring: one sentence, and "Needs NAME, NAME." if it imports other features. It may
                  have a class `Feature`, a subclass of the one below: the part of one visitor on the server. Without
                  one it may set ORDER, ALONE and KEEPS, which are explained there.
    tasks.py      pure functions for workers; imports nothing of the server
    index.js      the part of the page; exports connect(), called once
    SLOT.html     a Jinja template for a place of the page. Slots: head, header, run, help, display, menu, above,
                  narration, reasons, key, stage, punch, curves, main, beside, controls, player, keys, foot
    style.css     styles; they follow those of the core

In index.js, the modules of static/js offer:

    store.js      declare({field: value}) a field of `me`; view([fields], draw), frame([fields], draw)
    channel.js    order(name, fields) to the server; take(name, call, unpack) what it sends
    charts.js     addChart(name, made); addPart(chart, name, part, before); CURVES.push(name)
    inputs.js     KEYS[key] = call
    hover.js      connectChart(name) after addChart
    curves.js     more[quantity] = lists of values that the axis must hold

Words and numbers of the page are read from `me`; pictures are drawn in a `frame`. Scripts of features may come after
the first message of the server, so a feature looks at `me` when it connects.
"""

import ast
import logging
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import param

from app import environment, features
from app.service.requests import Requests
from solver import Scene
from solver.following.skeleton import Skeleton

log = logging.getLogger("app")
PLAIN = "ORDER", "ALONE", "PAGE", "KEEPS"  # what a feature.py without a class may set itself
PAGE = "page"  # the first of the kinds of `used`
NEEDS = re.compile(r"\bNeeds ([\w, ]+)\.")


class Feature(Requests):
    """The part of one visitor. Every method runs under the lock of the visitor's document; each may be left out.

    A method with `@order("name", field=test)` receives what the browser asks for; `self.session.send(name, ...)`
    answers. PARAMS names both. `ask`, `add_one` and `cancel` of Requests call functions in the workers.
    """

    ORDER = 50  # among the features of a slot: lower ones come first
    ALONE = False  # whether it is part of a Result that is played without a server, too
    PAGE = False  # whether it is part of the page only, not of a Stage in a layout of somebody else's
    PARAMS: dict[str, str] = {}  # {parameter of the Stage: what it carries}
    READS: frozenset[str] = frozenset()  # names in an address that the server reads
    KEEPS: frozenset[str] = frozenset()  # names in an address that the page reads

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        """Return what scripts and templates know from the beginning; root: address of scripts and styles."""
        return {}

    @classmethod
    def templates(cls) -> dict[str, Any]:
        """Return what templates know besides."""
        return {}

    @classmethod
    def head(cls, root: str, scene: Scene, preset: str) -> str:
        """Return what the head of the page has for a visitor with this scene and preset; root: as in `declared`."""
        return ""

    @classmethod
    def begin(cls, several: bool) -> None:
        """Called once per server on its loop, when it has started its workers; several: it is one of --num-procs."""

    @classmethod
    def load(cls) -> None:
        """Load code and compute results that later visitors need, once per server, in a thread."""

    @classmethod
    def scene_of(cls, scene: Scene, entries: dict[str, str], notes: list[str]) -> Scene:
        """Return a scene with what the entries {name: text} of an address change of it; notes get what fails."""
        return scene

    @classmethod
    def address(cls, scene: Scene) -> dict[str, str]:
        """Return further entries {name: text} of the address of a scene."""
        return {}

    @classmethod
    def owns(cls, arguments: dict[str, list[bytes]]) -> bool:
        """Whether the page at an address {name: values} is this feature's own, made by `serve`."""
        return False

    @classmethod
    def serve(cls, arguments: dict[str, list[bytes]]) -> None:
        """Put the page of an address of its own into the current document, by plain Panel."""

    def replaced(self) -> None:
        """Called when the scene of an address or a preset replaces what the visitor has chosen."""

    def requested(self, scene: Scene) -> None:
        """Called when another scene is computed or predicted from now on."""

    def predicted(self, skeleton: Skeleton) -> None:
        """Called when a predicted run has been sent to the browser, while a slider is held."""

    def ended(self, run: Any, skeleton: Skeleton | None) -> None:
        """Called when an exact run has ended; skeleton: predictions start from it, if it can be continued."""

    def nearer(self, scene: Scene, origin: Scene | None) -> Skeleton | None:
        """Return a Skeleton nearer to a scene than the Scene `origin`, if this feature has one."""

    def status(self) -> dict[str, Any]:
        """Return further entries of the status of the run."""
        return {}

    def close(self) -> None:
        """Called when the visitor has left."""
        self.cancel()


@cache
def found() -> dict[str, str]:
    """Return {name: docstring} of all features in the folders, also of those that are left out."""
    files = [path for folder in features.__path__ for path in Path(folder).glob("*/feature.py")]
    return {path.parent.name: ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "" for path in files}


def needed(name: str) -> list[str]:
    """Return the names of the features that a feature needs."""
    claim = NEEDS.search(found()[name].split("\n")[0])
    return re.split(r"[, ]+", claim[1]) if claim else []


@cache
def classes() -> dict[str, type[Feature]]:
    """Return {name: class} of the features of this server, in the order of the page.

    What cannot be imported, or needs a feature that is not there, is left out with a line in the log.
    """
    made: dict[str, Any] = {}
    for name in sorted(environment.chosen("APP_FEATURES", found())):
        try:
            module = import_module(f"app.features.{name}.feature")
            plain = {of: value for of in PLAIN if (value := getattr(module, of, None)) is not None}
            made[name] = getattr(module, "Feature", None) or type("Feature", (Feature,), plain)
        except Exception:
            log.exception("the feature %s is left out", name)
    while missing := {name: gone for name in made if (gone := [other for other in needed(name) if other not in made])}:
        for name, gone in missing.items():
            log.info("the feature %s is left out: it needs %s", name, ", ".join(gone))
            del made[name]
    return dict(sorted(made.items(), key=lambda item: (item[1].ORDER, item[0])))


def owner(arguments: dict[str, list[bytes]]) -> type[Feature] | None:
    """Return the feature whose own page is at an address {name: values}, or None: there is the experiment."""
    return next((made for made in classes().values() if made.owns(arguments)), None)


def folder(name: str) -> Path:
    """Return the folder of a feature."""
    return next(path for parent in features.__path__ if (path := Path(parent) / name / "feature.py").exists()).parent


def used(kind: str) -> list[str]:
    """Return the names of the features in "page", "placed" (in a layout of somebody else's), or "alone" (a Result)."""
    has = {PAGE: lambda made: True, "placed": lambda made: not made.PAGE, "alone": lambda made: made.ALONE}[kind]
    return [name for name in classes() if all(has(classes()[each]) for each in [name, *needed(name)])]


def files(name: str, kind: str = PAGE) -> Iterator[Path]:
    """Yield the files of this name of all features in their order; kind: as of `used`."""
    for feature in used(kind):
        path = folder(feature) / name
        if path.exists():
            yield path


def filled(template: str, kind: str = PAGE) -> str:
    """Return a template with <!-- SLOT --> replaced by what features add there; kind: as of `used`."""

    def slot(match):
        return "".join(filled(path.read_text(encoding="utf-8"), kind) for path in files(f"{match[1]}.html", kind))

    return re.sub(r"<!-- (\w+) -->\n?", slot, template)


def params() -> dict[str, param.Dict]:
    """Return the parameters that features add to the Stage."""
    return {name: param.Dict({}, doc=doc) for made in classes().values() for name, doc in made.PARAMS.items()}


def declared(root: str) -> dict[str, Any]:
    """Return what all features declare."""
    return {name: value for made in classes().values() for name, value in made.declared(root).items()}


def names(of: str) -> set[str]:
    """Return the names in an address that features read on the server (READS) or in the page (KEEPS)."""
    return {name for made in classes().values() for name in getattr(made, of)}


def templates() -> dict[str, Any]:
    """Return what only templates know of all features."""
    return {name: value for made in classes().values() for name, value in made.templates().items()}
