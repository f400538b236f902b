"""The page, composed once for all visitors. Each visitor gets it with marks replaced, and has only few own models.

A visitor's document on the server has the wire and the slots for figures of pages, with the same ids for all visitors.
All other models exist only in the browser, which receives the document as text (session/message_filter.py).
Undocumented in Bokeh 3.9: the id `_id` of a model, and the functions of `bokeh.embed` that write the page.
"""

import json
import logging
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import panel as pn
from bokeh.document import Document
from bokeh.embed.elements import html_page_for_render_items
from bokeh.embed.util import RenderItem
from bokeh.models import CustomJS, Div
from bokeh.settings import settings

from app import assets, lab, pages, schema
from app.document import frozen
from app.server_log import reach
from app.session.controls import ALSO, CONTROLS, applies, drawer, meaning, scene_from_address, values_of, words
from app.session.orders import Wire
from app.session.session import Session
from solver.presets import presets
from solver.scene import CHOICES, LIMITS

log = logging.getLogger("app")
HERE = Path(__file__).parent
TITLE = "Why does it stick, peel and slip?"
SPEEDS = {1: "1 nm/s", 2: "2 nm/s", 4: "4 nm/s", 8: "8 nm/s", 20: "20 nm/s"}  # of the top during playback
PLAIN_SPEED = 4
PRELOAD = '<link rel="preload" id="stored" as="fetch" crossorigin="anonymous" href="{}">'
MARK = "@{}@"  # a placeholder in the page for a value of the visitor


@dataclass(frozen=True)
class Shared:
    """The texts that all visitors share: the page in HTML with MARKs, and the document in JSON."""

    page: str
    document: str
    stored: dict  # {preset: address of its stored run}

    def page_for(self, arguments: Any, **own: Any) -> str:
        """Return the page for an address with these arguments {name: [bytes]}; own: {mark: text}."""
        scene, preset, _ = scene_from_address(arguments)
        values, page = values_of(scene), self.page
        shown = preset in self.stored and scene == presets()[preset].scene
        own |= {"stored": PRELOAD.format(self.stored[preset]) if shown else ""}
        for control in CONTROLS:
            near = [abs(position - values[control.name]) for position in control.positions]
            own |= {control.name: f"{values[control.name]:g}", f"{control.name}-at": str(near.index(min(near)))}
        for name, text in own.items():
            page = page.replace(MARK.format(name), text)
        return page


def open_page() -> None:
    """Add a visitor's own models to the current document."""
    doc = pn.state.curdoc
    try:
        session = Session(doc, pages.Pages, pn.state.session_args)
        doc.on_session_destroyed(lambda session_context: session.close())
        with frozen(doc):
            for model in _own(session.wire, session.pages.slots):
                doc.add_root(model)
    except Exception:  # otherwise the visitor would wait forever
        log.exception("the page could not be built")
        doc.clear()
        doc.add_root(Div(text="The experiment could not be opened. See the server's log, then reload the page."))


def _own(wire, slots):
    """Yield the models that a visitor's document also has on the server.

    Their ids are constant, as the text of the document, which names them, is composed once for all visitors.
    """
    for name, model in {"wire": wire, **slots}.items():
        model.name, model._id = name, name
        yield model


def shared(address: str) -> Shared:
    """Return the Shared for a page at this address, with the current scripts and styles."""
    return _composed(assets.root(address))


@lru_cache(2)
def _composed(root):
    doc, wire, slots = Document(), Wire(), pages.places()
    (*_,) = _own(wire, slots)
    next(iter(slots.values())).tags = [wire]  # Bokeh synchronises only models that a root refers to
    with frozen(doc):
        for name, model in slots.items():
            model.name = name
            doc.add_root(model)
    doc.title = TITLE
    doc.config.update(reconnect_session=False, notifications=None, notify_connection_status=False)
    doc.js_on_event("document_ready", _player(wire, slots, root))
    doc.js_on_event("connection_lost", CustomJS(code="document.dispatchEvent(new Event('connection-lost'))"))
    text = json.dumps(doc.to_json(deferred=False), separators=(",", ":"), allow_nan=False)
    page = re.sub(r"<script(?=[ >])", f'<script nonce="{MARK.format("nonce")}"', _html(doc, root))
    return Shared(page, text, _stored(root))


def _html(doc, root):
    bundle = Path(settings.bokehjs_path()) / "js" / "bokeh.min.js"  # the only one
    script = f'<script src="./static/js/bokeh.min.js?v={assets.content(bundle)[2]}"></script>'
    item = RenderItem(token=MARK.format("token"), roots=doc.roots, use_for_title=True)
    sections = "".join(map(pages.section, pages.listed()))
    return html_page_for_render_items((script, ""), {}, [item], TITLE, template(sections), values(root))


def template(sections: str) -> str:
    """Return the page as a template of Jinja with the blocks postamble and contents; sections: its pages in HTML."""
    page, dialogs = ((HERE / "html" / name).read_text(encoding="utf-8") for name in ("page.html", "dialogs.html"))
    return page.replace("<!-- pages -->", sections).replace("<!-- dialogs -->", dialogs)


def values(root: str) -> dict[str, Any]:
    """Return what the template takes; root: address of scripts and styles."""
    return {
        "root": root,
        "styles": assets.styles(),
        "scripts": sorted(map(assets.named, assets.needed(assets.STATIC / "js" / "main.js"))),
        "controls": CONTROLS,
        "values": {control.name: MARK.format(control.name) for control in CONTROLS},
        "places": {control.name: MARK.format(f"{control.name}-at") for control in CONTROLS},
        "drawer": drawer(),
        "meaning": meaning,
        "also": ALSO,
        "words": words,
        "applies": applies,
        "unit": lambda name: LIMITS[name].unit if name in LIMITS else "",
        "choices": CHOICES,
        "presets": _grouped(),
        "row": [preset for preset in presets().values() if preset.short],
        "pictures": {path.stem: path.read_text(encoding="utf-8") for path in (HERE / "html" / "row").glob("*.svg")},
        "modules": pages.listed(),
        "labs": lab.PAGES,
        "pages": {"": "Experiment"} | {name: page.TITLE for name, page in pages.listed().items()},
        "schema": schema,
        "speeds": SPEEDS,
        "plain_speed": PLAIN_SPEED,
    }


def _grouped():
    """Return {group: presets} for the menu."""
    groups = {}
    for preset in presets().values():
        groups.setdefault(preset.group, []).append(preset)
    return groups


def _stored(root):
    """Return {preset: address of its stored run}."""
    runs = sorted((assets.STATIC / "runs").glob("*.bin"))
    return {path.stem: f"{root}/{assets.named(path)}" for path in runs}


def declarations(root: str) -> dict[str, Any]:
    """Return the declarations of presets, nodes and sliders that the browser needs."""
    return {
        "looks": {preset.name: preset.look for preset in presets().values()},
        "stored": _stored(root),
        "nodes": {name: vars(node) for name, node in schema.NODES.items()},
        "usual": {preset.name: values_of(preset.scene) for preset in presets().values()},
        "positions": {control.name: list(control.positions) for control in CONTROLS},
        "reach": reach()._asdict(),
        "scripts": [name for name in pages.listed() if (pages.HERE / name / "page.js").exists()],
    }


def _player(wire, slots, root):
    """Return the callback that starts the browser's part of the app, with the models it changes."""
    return CustomJS(
        args={
            "wire": wire,
            "slots": slots,
            "declarations": json.dumps(declarations(root)),
            "main": f"{root}/static/js/main.js",
        },
        code="""
            const given = { wire, slots, declarations, index: cb_context.index }
            import(new URL(main, document.baseURI)).then(({ start }) => start(given))
        """,
    )
