"""The page, composed once for all visitors; each gets it with marks replaced by what is his.

Undocumented in Bokeh 3.9: the functions of `bokeh.embed` that write a page.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from bokeh.document import Document
from bokeh.embed.elements import html_page_for_render_items
from bokeh.embed.util import RenderItem
from bokeh.resources import Resources
from panel.io.resources import Resources as PanelResources
from panel.io.resources import bundle_resources

from app import assets, interface, modules, schema
from app.document import current
from app.server_log import reach
from app.session.controls import CONTROLS, FOR_BROWSER, FOR_SERVER, scene_from_address, values_of
from solver.presets import presets

HERE = Path(__file__).parent
TITLE = "Why does it stick, peel and slip?"
SPEEDS = {1: "1 nm/s", 2: "2 nm/s", 4: "4 nm/s", 8: "8 nm/s", 20: "20 nm/s"}  # of the top during playback
PLAIN_SPEED = 4


MARK = "@{}@"  # a placeholder in the page for a value of the visitor


@dataclass(frozen=True)
class Shared:
    """The page in HTML with MARKs, for all visitors; root: address of its scripts and styles."""

    page: str
    root: str

    def page_for(self, arguments: Any, **own: Any) -> str:
        """Return the page for an address with these arguments {name: [bytes]}; own: {mark: text}."""
        scene, preset, _ = scene_from_address(arguments)
        values, page = values_of(scene), self.page
        own |= {"head": "".join(made.head(self.root, scene, preset) for made in interface.classes().values())}
        for control in CONTROLS:
            near = [abs(position - values[control.name]) for position in control.positions]
            own |= {control.name: f"{values[control.name]:g}", f"{control.name}-at": str(near.index(min(near)))}
        for name, text in own.items():
            page = page.replace(MARK.format(name), text)
        return page


@cache
def shared(document: Callable[[Document], None]) -> Shared:
    """Return the Shared of a page around the roots that document(doc) adds to a Document, as it does for a visitor.

    The browser finds roots by their order, so that these of an example may stand for them.
    """
    doc, root = Document(), assets.root(HERE.name)
    with current(doc):
        document(doc)
        resources = PanelResources.from_bokeh(Resources(mode="server", root_url="./"))
        resources.components = ["bokeh", "bokeh-widgets", "bokeh-tables"]  # needed by those of Panel
        item = RenderItem(token=MARK.format("token"), roots=doc.roots, use_for_title=True)
        given = values(root) | {"values": {control.name: MARK.format(control.name) for control in CONTROLS}}
        given |= {"places": {control.name: MARK.format(f"{control.name}-at") for control in CONTROLS}}
        given |= {"preload": MARK.format("head")}
        page = template()
        html = html_page_for_render_items(bundle_resources(doc.roots, resources), {}, [item], TITLE, page, given)
    return Shared(re.sub(r"<script(?=[ >])", f'<script nonce="{MARK.format("nonce")}"', html), root)


def template(kind: str = interface.PAGE) -> str:
    """Return the page as a template of Jinja with the blocks postamble and contents; kind: as of `interface.used`."""
    page, dialogs = ((HERE / "html" / name).read_text(encoding="utf-8") for name in ("page.html", "dialogs.html"))
    page = page.replace("<!-- dialogs -->", dialogs)
    return interface.filled(page, kind)


def values(root: str) -> dict[str, Any]:
    """Return what the template takes; root: address of scripts and styles."""
    return {
        "style": f"{root}/{assets.STYLE}",
        "opening": f"{root}/{modules.OPENING}",
        "script": f"{root}/{modules.PAGE}",
        "declarations": declarations(root) | {"reach": reach()._asdict()},  # not in a file that is given away
        "controls": CONTROLS,
        "schema": schema,
        "speeds": SPEEDS,
        "plain_speed": PLAIN_SPEED,
        **interface.declared(root),
        **interface.templates(),
    }


def declarations(root: str) -> dict[str, Any]:
    """Return the declarations of presets, marks and sliders that the browser needs."""
    return {
        "titles": {preset.name: preset.title for preset in presets().values()},
        "nodes": {name: vars(node) for name, node in schema.NODES.items()},
        "usual": {preset.name: values_of(preset.scene) for preset in presets().values()},
        "positions": {control.name: list(control.positions) for control in CONTROLS},
        "scene": sorted(FOR_SERVER),
        "viewed": sorted(FOR_BROWSER),  # names in an address
        **interface.declared(root),
        "features": assets.scripts(),
    }
