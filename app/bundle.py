"""The Stage as one script, for layouts, notebooks and files of others: app/static/js and the features' scripts in it.

Every module is a function of it, and `makeStage(root)` runs each where it is imported first: so each Stage has a store,
charts and a connection of its own, and its elements below its own root. Bokeh's servers serve the script as that of an
extension; files and notebooks have its text. `page.py` makes the page of this server from the same modules.
"""

import json
import logging
import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from bokeh.embed.bundle import extension_dirs
from jinja2 import Environment

from app import assets, modules, page
from app.session.controls import NAMES

NAME = "mixed-mode-contact"  # of the extension
PLAYED, LIVE = "alone", "placed"  # kinds of a Stage: see `interface.used`
PLACED = """
.root[data-alone] :is(header, #above, #lost, .controls, #grab) { display: none; }
.root { container: stage / inline-size; font-size: 1rem; }
.root { background: var(--page); color: var(--text); text-align: start; }
.root .page { height: 44rem; } .root[data-sized], .root[data-sized] .page { height: 100%; min-height: 0; }
.root[data-sized] { overflow: auto; container-type: size; }
@container stage (width <= 899px) { .root .page { height: auto; min-height: 0; } }
"""
log = logging.getLogger("app")
_folders = list[TemporaryDirectory]()  # which end with this process


@cache
def path() -> Path | None:
    """Return the path of the script, whose name has a hash of its content; None where no folder can be written."""
    text = script(PLAYED, LIVE)
    try:
        _folders.append(TemporaryDirectory(prefix="stage-"))
        made = Path(_folders[-1].name) / f"stage-{assets.hashed(text.encode())}.js"
        made.write_text(text, encoding="utf-8")
    except OSError as error:
        log.warning("a Stage in a layout stays empty: its script cannot be written: %s", error)
        return None
    extension_dirs[NAME] = made.parent
    return made


@cache
def script(*kinds: str) -> str:
    """Return the text of the script; kinds: of the Stages that it draws, PLAYED or LIVE."""
    contents = json.dumps({kind: _content(kind) for kind in kinds} | {"style": _style()}).replace("</", "<\\/")
    return f"""const contents = {contents}
function makeStage($root) {{
const $made = {{}}, $get = (name) => ($made[name] ??= $modules[name]()), $later = async (name) => $get(name)
const $modules = {{
{modules.functions(_modules(kinds))}
}}
return $get({json.dumps(assets.MAIN)})
}}
{(assets.HERE / "stage.js").read_text(encoding="utf-8").replace("export const renderer", "const renderer")}
export const render = renderer(contents, makeStage)
"""


def _modules(kinds):
    """Return the names of all scripts that Stages of these kinds may need, at once or later."""
    found, left = set[str](), {assets.MAIN}.union(*map(assets.scripts, kinds))
    while left:
        found |= (needed := assets.needed(*left))
        named = ((by, name) for by in needed for _, name in modules.LATER.findall(assets.text(by)) if "$" not in name)
        later = {assets.imported(by, name) for by, name in named}
        left = later - found
    return sorted(found)


def _content(kind):
    """Return the elements of a Stage of this kind."""
    values = page.values("") | {"values": dict.fromkeys(NAMES, ""), "places": dict.fromkeys(NAMES, 0)}
    jinja = Environment(trim_blocks=True, lstrip_blocks=True)
    jinja.globals["base"] = jinja.from_string("{% block contents %}{% endblock %}")
    jinja.globals["macros"] = jinja.from_string("{% macro embed(root) %}{% endmacro %}")
    text = jinja.from_string("{% extends base %}\n" + page.template(kind)).render(values)
    declared = page.declarations("") | {"features": assets.scripts(kind)}
    text = re.sub(r"<(script|noscript)\b.*?</\1>\n?", "", text, flags=re.S)
    return f'{text}<script type="application/json" id="declarations">{json.dumps(declared)}</script>'


def _style():
    """Return the styles, whose sizes are those of the Stage in place of the window's."""
    text = assets.text(assets.STYLE).replace("dvh", "cqh").replace(":root", ".root").replace("html, body {", ".root {")
    text = re.sub(r"@media \(max-width: (\d+px)\)[^{]*", r"@container stage (width <= \1) ", text)
    return f"<style>{text}{PLACED}</style>"
