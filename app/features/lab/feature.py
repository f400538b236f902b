"""Research pages: plain Panel apps at `app?lab=NAME`, with a scene in the address, and in a notebook.

    from app.features.NAME.research import view; view(Scene(E=140))

A page is a folder of app/features whose docstring says "Needs lab.", with

    feature.py     TITLE, ORDER   its name, and its place in the menu
    research.py    view(scene)    a Viewable of Panel; base.py and tasks.py have what pages share
"""

import json
import logging
from functools import cache
from html import escape
from importlib import import_module
from typing import Any
from urllib.parse import urlencode

import panel as pn
from bokeh.models import CustomJS

from app import interface
from app.features.lab.look import TEXT, css, theme
from app.limits import DEFAULT
from app.session.controls import CONTROLS, FOR_BROWSER, Control, address_of, scene_from_address
from app.session.orders import LARGEST
from solver import Scene

log = logging.getLogger("app")
BUG = "The page could not be opened. See the server's log, then reload the page."
BACK = "color: inherit; text-decoration: none; border: 1px solid; border-radius: 6px; padding: 4px 10px"
ICON = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg'/%3E"


def slider_name(control: Control) -> str:
    """Return the label of a slider, with its unit."""
    return f"{control.label} {control.symbol}" + f" ({control.unit})" * bool(control.unit)


# Panel's sliders have no names for screen readers, and the text of their values is a position. This gives them the
# label before them and the value at the position, again whenever Panel changes or renders one.
# A message of 5 MB closes the connection, so a browser refuses a larger file than the page reads, before it sends it.
MEND = f"""
    const positions = {json.dumps({slider_name(control): control.positions for control in CONTROLS})}
    const bounded = (input) => {{
        const said = input.parentNode.appendChild(document.createElement("p"))
        input.setAttribute("aria-label", "Measured curve")
        said.setAttribute("role", "alert")
        input.addEventListener("change", (event) => {{
            const [file] = input.files, large = file?.size > {LARGEST}
            said.textContent = large ? `${{file.name}} has ${{(file.size / 1e6).toFixed(1)}} MB, allowed: `
                + "{LARGEST // 10**6} MB. Thin it out." : ""
            if (!large) return
            event.stopImmediatePropagation()
            input.value = ""
        }}, true)
    }}
    const larger = new CSSStyleSheet()
    const sized = "input, select, textarea, table"
    larger.replaceSync(`:host {{ --font-size: {TEXT} }} ${{sized}} {{ font-size: {TEXT} !important }}`)
    let label = "", due = 0
    const mend = () => {{
        cancelAnimationFrame(due)
        due = requestAnimationFrame(() => visit(document))
    }}
    const seen = new WeakSet() // roots that are watched, and entries of files
    const changes = {{ childList: true, subtree: true, attributes: true, attributeFilter: ["aria-valuetext"] }}
    const first = (one) => !seen.has(one) && seen.add(one)
    const write = (e, name, text) => {{ if (e.getAttribute(name) !== text) e.setAttribute(name, text) }}
    const visit = (root) => {{
        if (first(root)) {{
            new MutationObserver(mend).observe(root, changes)
            root.adoptedStyleSheets.push(larger)
        }}
        for (const e of root.querySelectorAll("*")) {{
            if (e.matches("label")) label = e.textContent
            const sign = e.matches(".bk-spin-btn-up") ? " +" : e.matches(".bk-spin-btn-down") ? " −" : ""
            if (sign || e.matches(".noUi-handle")) write(e, "aria-label", label + sign)
            const value = positions[label]?.[Number(e.getAttribute("aria-valuenow"))]
            if (e.matches(".noUi-handle") && value !== undefined) write(e, "aria-valuetext", `${{value}}`)
            if (e.matches("progress")) write(e, "aria-label", "Progress")
            if (e.matches("input[type=file]") && first(e)) bounded(e)
            if (e.shadowRoot) visit(e.shadowRoot)
        }}
    }}
    visit(document)
"""


def back(scene: Scene) -> str:
    """Return the link to the experiment with a scene, as it was when it was left: its class, theme and view."""
    given = {name: pn.state.session_args[name][-1] for name in FOR_BROWSER if name in pn.state.session_args}
    values = address_of(scene, DEFAULT) | given
    return f'<a style="{BACK}" href="?{escape(urlencode(values))}">← Back to the experiment</a>'


@cache
def listed() -> dict[str, Any]:
    """Return {name: its feature.py} of all pages, in the order of the menu."""
    names = [name for name in interface.classes() if (interface.folder(name) / "research.py").exists()]
    modules = {name: import_module(f"app.features.{name}.feature") for name in names}
    return dict(sorted(modules.items(), key=lambda item: item[1].ORDER))


def research(name: str) -> Any:
    """Return the module of a page. The first call imports it, which takes a second."""
    return import_module(f"app.features.{name}.research")


class Feature(interface.Feature):
    """The pages have the address of the experiment, with a name more."""

    PAGE = True
    READS = frozenset({"lab"})

    @classmethod
    def templates(cls) -> dict[str, Any]:
        return {"labs": {name: page.TITLE for name, page in listed().items()}}

    @classmethod
    def load(cls) -> None:
        for name in listed():
            research(name)

    @classmethod
    def owns(cls, arguments: dict[str, list[bytes]]) -> bool:
        return "lab" in arguments

    @classmethod
    def serve(cls, arguments: dict[str, list[bytes]]) -> None:
        """Add the page that the address names to the current document."""
        _serve(pn.state.curdoc, arguments)


def _serve(doc, arguments):
    name, ground = (arguments.get(key, [b""])[-1].decode("utf-8", "replace") for key in ("lab", "theme"))
    dark = ground == "dark"
    doc.template_variables.update(app_favicon=ICON, apple_icon=ICON, dist_url="static/extensions/panel/")  # from here
    doc.js_on_event("document_ready", CustomJS(code=MEND))
    pn.extension(theme="dark" if dark else "default", browser_info=False, raw_css=[css(dark)])
    doc.theme = theme(dark)
    scene, _, notes = scene_from_address(arguments)
    page = pn.pane.HTML(back(scene))
    try:
        if name in listed():
            page = research(name).view(scene)
            log.info("a visitor opened the page %s", name)
        else:
            notes.append(f"There is no page “{name[:40]}”. The menu of the experiment lists all.")
    except Exception:
        log.exception("a research page could not be built")
        notes.append(BUG)
    alerts = [pn.pane.Alert(note, alert_type="warning") for note in notes]
    title = listed()[name].TITLE if name in listed() else "Research pages"
    pn.Column(*alerts, page, sizing_mode="stretch_width").servable(title=title, location=False)
