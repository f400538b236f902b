"""A computed run on the page of the app, in one HTML file that plays without a server and without a network.

Scripts are in the file as an import map of data addresses: browsers import no scripts beside a local file.
"""

import base64
import html
import json
import re
from typing import Any

from jinja2 import Environment

from app import assets, page
from app.service import packing, worker
from app.session.controls import NAMES
from app.session.orders import HALF
from solver.scene import LIMITS

BASE = """<!DOCTYPE html>
<html lang="en" data-embed data-alone>
<head><meta charset="utf-8"><title>{{ title }}</title>
<script type="importmap">{{ imports }}</script>
<style>{{ style }}</style>
{% block postamble %}{% endblock %}
<link id="stored" href="{{ run }}">
</head>
<body>{% block contents %}{% endblock %}</body></html>
"""


def page_of(result: Any, title: str = page.TITLE) -> str:
    """Return the file of a Result as text; raises ValueError without frames, or for a title that no file can hold."""
    scene, frames = result.scene, list(result.frames)
    if not frames:
        raise ValueError("result has no frames; allowed: at least one; compute a longer run")
    if HALF.search(title):
        raise ValueError(f"title = {title!r} has half of a character; allowed: text that UTF-8 can write; correct it")
    (block,) = packing.packed(scene, list(zip(frames, worker.works(scene, frames)[0], strict=True)), True)
    features = assets.scripts("alone")
    alone = {"alone": {"scene": _words(scene), "notes": " ".join(result.notes)}, "features": features}
    values = page.values("") | {
        "title": html.escape(title),
        "imports": json.dumps({"imports": _scripts([assets.MAIN, *features])}),
        "style": "\n".join(assets.content(name)[0].decode() for name in assets.styles()),
        "styles": [],
        "scripts": [],
        "main": assets.MAIN,
        "values": dict.fromkeys(NAMES, ""),  # of sliders, which the file does not show
        "places": dict.fromkeys(NAMES, 0),
        "run": _address("application/octet-stream", block),
        "declarations": page.declarations("") | alone,
    }
    jinja = Environment(trim_blocks=True, lstrip_blocks=True)
    jinja.globals["base"] = jinja.from_string(BASE)
    jinja.globals["macros"] = jinja.from_string("{% macro embed(root) %}{% endmacro %}")
    text = jinja.from_string("{% extends base %}\n" + page.template("alone")).render(values)
    return re.sub(r'<script type="module" src=[^>]*></script>', "", text)


def _address(kind, content):
    """Return bytes as a data address."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _scripts(wanted):
    """Return {name: data address} of all scripts that the page needs at once. Their imports are by these names."""
    made = {}
    for name in assets.needed(*wanted):
        named = lambda match, name=name: f'"{assets.imported(name, match[1] or match[2])}"'  # noqa: E731
        text = assets.content(name)[0].decode()
        text = re.sub(r'(?<=from )"(\.[^"]+)"|(?<=^import )"(\.[^"]+)"', named, text, flags=re.M)
        made[name] = _address("text/javascript", text.encode())
    return made


def _words(scene):
    """Return the parameters of a Scene that are not the usual ones, in words."""
    return (
        ", ".join(f"{name} = {_value(name, value)}" for name, value in scene.differences().items())
        or "the default scene"
    )


def _value(name, value):
    """Return the value of a parameter with its unit."""
    number = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{number} {LIMITS[name].unit}".rstrip() if name in LIMITS else number
