"""A computed run on the page of the app, in one HTML file that plays without a server and without a network.

    from app.stage import Stage
    from solver import Scene, simulate

    Stage(simulate(Scene())).save("punch.html")

A notebook shows a Stage as an output. Scripts are in the file as an import map of data addresses: browsers import no
scripts beside a local file.
"""

import base64
import html
import json
import re
from pathlib import Path
from typing import Any

from jinja2 import Environment

from app import assets, page
from app.service import packing, worker
from solver import Scene
from solver.scene import LIMITS, PARAMETERS

EMPTY = "{% macro embed(root) %}{% endmacro %}"  # of the live page, which has no figures of Bokeh
BASE = """<!DOCTYPE html>
<html lang="en" data-embed data-alone>
<head><meta charset="utf-8"><title>{{ title }}</title>
<script type="importmap">{{ imports }}</script>
<style>{{ style }}</style>
{% block postamble %}{% endblock %}
<link id="stored" href="{{ run }}">
</head>
<body>{% block contents %}{% endblock %}
<script type="module">
import { start } from "static/js/main.js"
const wire = { document: { on_message() {} } } // nobody sends orders on
start({ wire, slots: {}, declarations: {{ declarations }}, index: null })
</script></body></html>
"""
FRAME = '<iframe title="{}" srcdoc="{}" width="960" height="600" style="border: 0; max-width: 100%"></iframe>'


class Stage:
    """A Result of `simulate` to be seen, played and scrubbed, with its failure and cautions; read-only."""

    def __init__(self, result: Any, title: str = page.TITLE) -> None:
        """result: a Result; title: of the file. Raises ValueError for a result without frames."""
        if not len(result.frames):
            raise ValueError("result has no frames; allowed: at least one; compute a longer run")
        self.result, self.title = result, title

    def save(self, path: str | Path) -> None:
        """Write the file. Raises OSError where it cannot be written."""
        Path(path).write_text(self.html(), encoding="utf-8")

    def html(self) -> str:
        """Return the file as text."""
        scene, frames = self.result.scene, list(self.result.frames)
        (block,) = packing.packed(scene, list(zip(frames, worker.works(scene, frames)[0], strict=True)), True)
        alone = {"stored": {}, "alone": {"scene": _words(scene), "notes": " ".join(self.result.notes)}}
        values = page.values("") | {
            "title": html.escape(self.title),
            "imports": json.dumps({"imports": _scripts()}),
            "style": "\n".join(path.read_text(encoding="utf-8") for path in sorted(assets.STATIC.glob("*.css"))),
            "styles": [],
            "scripts": [],
            "values": {control.name: "" for control in page.CONTROLS},  # of sliders, which the file does not show
            "places": {control.name: 0 for control in page.CONTROLS},
            "run": _address("application/octet-stream", block),
            "declarations": json.dumps(json.dumps(page.declarations("") | alone)).replace("<", "\\u003c"),
        }
        jinja = Environment(trim_blocks=True, lstrip_blocks=True)
        jinja.globals["base"] = jinja.from_string(BASE)
        jinja.globals["macros"] = jinja.from_string(EMPTY)
        template = "{% extends base %}\n" + page.template("").replace('"macros"', "macros")
        text = jinja.from_string(template).render(values).replace(page.MARK.format("stored"), "")
        return re.sub(r'<script type="module" src=[^>]*></script>', "", text)

    def _repr_html_(self) -> str:
        """Return the file in a frame of a notebook."""
        return FRAME.format(html.escape(self.title), html.escape(self.html()))


def _address(kind, content):
    """Return bytes as a data address."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _scripts():
    """Return {name: data address} of all scripts that the page needs at once. Their imports are by these names."""
    made = {}
    for path in assets.needed(assets.STATIC / "js" / "main.js"):
        named = lambda match, path=path: f'"{assets.named((path.parent / match[1]).resolve())}"'  # noqa: E731
        text = re.sub(
            r'(?<=from )"(\.[^"]+)"|(?<=^import )"(\.[^"]+)"', named, path.read_text(encoding="utf-8"), flags=re.M
        )
        made[assets.named(path)] = _address("text/javascript", text.encode())
    return made


def _words(scene):
    """Return the parameters of a Scene that are not the usual ones, in words."""
    usual, given = vars(Scene()), vars(scene)
    names = [name for name in PARAMETERS if str(given[name]) != str(usual[name])]
    return ", ".join(f"{name} = {_value(name, given[name])}" for name in names) or "the default scene"


def _value(name, value):
    """Return the value of a parameter with its unit."""
    number = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{number} {LIMITS[name].unit}".rstrip() if name in LIMITS else number
