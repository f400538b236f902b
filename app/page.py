"""The page: views, controls and player put together for one visitor, or a message when that is impossible."""

import html
import json
import logging
from functools import cache
from pathlib import Path

import panel as pn
from bokeh.models import CustomJS

from app import schema
from app.assets import assets
from app.session.controls import CONTROLS, applies, drawer, meaning, values_of, words
from app.session.session import VISITORS, Session, visitors
from app.views.live import live_figures
from app.views.pages import PAGES, section
from solver.presets import presets
from solver.scene import CHOICES, LIMITS

log = logging.getLogger("app")
HERE = Path(__file__).parent
SPEEDS = {1: "1 nm/s", 2: "2 nm/s", 4: "4 nm/s", 8: "8 nm/s", 20: "20 nm/s"}  # of the top, when played
PLAIN_SPEED = 4


@cache
def _file(name):
    return (HERE / name).read_text(encoding="utf-8")


def open_page():
    """Serve the experiment to the visitor of the current document."""
    doc = pn.state.curdoc
    if len(visitors) >= VISITORS:
        log.warning("class full: a visitor was turned away")
        _say(doc, f"The class is full: {VISITORS} visitors are here. Reload the page when one has left.")
        return
    try:
        session = Session(doc, pn.state.session_args)
        doc.on_session_destroyed(lambda session_context: session.close())
        with doc.models.freeze():  # the models are counted once, not after every view
            _page(session).servable(title="Why does it stick, peel and slip?")
    except Exception as error:  # otherwise the visitor would see a blank page
        log.exception("the page could not be built")
        why = html.escape(f"{type(error).__name__}: {error}")
        _say(doc, f"The experiment could not be opened: {why}. Reload the page.")


def _say(doc, text):
    """A page with nothing but a message."""
    pn.pane.HTML(f'<p role="alert" style="font: 18px system-ui; margin: 2em">{text}</p>').server_doc(doc)


def _page(session):
    """The template with the five figures, and the player that connects them with the session's wire."""
    figures = live_figures()
    figures["punch"].tags = [session.wire]  # a model is synchronised only if a root of the document refers to it
    template = pn.Template(_file("html/page.html").replace("<!-- pages -->", "".join(map(section, PAGES))))
    roots = figures | session.pages.slots
    for name, model in roots.items():  # as they are: a pane around each would cost a visitor 4 ms
        model.name = name
        pn.state.curdoc.add_root(model)
    template.add_variable("assets", assets(pn.state.app_url))
    template.add_variable("controls", CONTROLS)
    template.add_variable("values", values_of(session.scene))
    template.add_variable("drawer", drawer())
    template.add_variable("meaning", meaning)
    template.add_variable("words", words)
    template.add_variable("applies", applies)
    template.add_variable("unit", lambda name: LIMITS[name].unit if name in LIMITS else "")
    template.add_variable("choices", CHOICES)
    template.add_variable("presets", _grouped())
    template.add_variable("pages", {"": "Experiment"} | {name: title for name, (title, _) in PAGES.items()})
    template.add_variable("schema", schema)
    template.add_variable("speeds", SPEEDS)
    template.add_variable("plain_speed", PLAIN_SPEED)
    pn.state.curdoc.js_on_event("document_ready", _player(session, figures))
    lost = CustomJS(code="document.dispatchEvent(new Event('connection-lost'))")
    pn.state.curdoc.js_on_event("connection_lost", lost)
    return template


def _grouped():
    """{group: presets} for the menu."""
    groups = {}
    for preset in presets().values():
        groups.setdefault(preset.group, []).append(preset)
    return groups


def _player(session, figures):
    """The browser's half of the app, with the models it changes."""
    return CustomJS(
        args={
            "wire": session.wire,
            "figures": figures,
            "slots": session.pages.slots,
            "looks": {preset.name: preset.look for preset in presets().values()},
            "nodes": {name: vars(node) for name, node in schema.NODES.items()},
            "usual": json.dumps({preset.name: values_of(preset.scene) for preset in presets().values()}),
            "positions": {control.name: list(control.positions) for control in CONTROLS},
            "main": next(name for name in assets(pn.state.app_url) if name.endswith("/main.js")),
        },
        code="""
            const given = { wire, figures, slots, looks, nodes, usual, positions, index: cb_context.index }
            import(new URL(main, document.baseURI)).then(({ start }) => start(given))
        """,
    )
