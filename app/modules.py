"""Modules of static/js and of features as functions of one script: fewer requests, and as many instances as wanted.

`$get(name)` runs a module once and returns what it exports; `$later(name)` does so in a while; `$root` is the element
that holds what it draws. The page is such a script (`page`, and `later` for what is loaded when it is asked for); so is
the Stage of a layout (app/bundle.py). Imports and exports of a module are of one line each; tests/app/test_bundle.py
looks.
"""

import json
import re
from collections.abc import Collection

from app import assets

FROM = r' from "(\.[^"]+)"$'
IMPORT = re.compile(rf"^import (?:\* as (\w+)|\{{([^}}]+)\}}){FROM}", re.M)
LATER = re.compile(r"\bimport\(([\"`])(\.[^\"`]+)\1\)")
EXPORT = re.compile(r"^export (?=(?:const|(?:async )?function\*?|class) (\w+))", re.M)
ROOT = "export const root = document.documentElement"
NAMED = "import(name)"  # of a feature
OPENING = "static/js/opening.js"  # of the page, loaded before all others
PAGE, REST = "static/page.js", "static/later.js"


def functions(names: Collection[str]) -> str:
    """Return modules as the properties of an object: functions that return what they export."""
    return ",\n".join(f"{json.dumps(name)}() {{\n{_body(name)}\n}}" for name in sorted(names))


def _body(name):
    named = lambda other: assets.imported(name, other)  # noqa: E731
    text = assets.text(name).replace(ROOT, "const root = $root").replace(NAMED, "$later(name)")
    text = text.replace("import.meta.url", f'new URL("../{name}", import.meta.url)')  # scripts lie in static
    text = IMPORT.sub(lambda m: f"const {m[1] or _renamed(m[2])} = $get({json.dumps(named(m[3]))})", text)
    text = LATER.sub(lambda m: f"$later({m[1]}{named(m[2])}{m[1]})", text)
    exports = EXPORT.findall(text) + ["root"] * ("const root = $root" in text)
    return f"{EXPORT.sub('', text)}\nreturn {{ {', '.join(exports)} }}"


def _renamed(names):
    """Return what an import takes as the names of a record."""
    return f"{{{names.replace(' as ', ': ')}}}"


def page() -> str:
    """Return the script of the page of this server, which starts it."""
    return f"""import * as $opening from "./js/opening.js"
const $root = document.documentElement, $made = {{ {json.dumps(OPENING)}: $opening }}
const $get = (name) => ($made[name] ??= $modules[name]())
const $later = async (name) => {{
if (!$modules[name]) Object.assign($modules, (await import("./later.js")).modules($get, $later, $root))
return $get(name)
}}
const $modules = {{
{functions([name for name in assets.preloaded() if name != OPENING])}
}}
$root.module = $later // for tests
$get({json.dumps(assets.MAIN)}).start()
"""


def later() -> str:
    """Return the script with all other modules."""
    others = {name for name in assets.files() if name.endswith(".js")} - {*assets.preloaded()}
    return f"export const modules = ($get, $later, $root) => ({{\n{functions(others)}\n}})"


assets.MADE |= {PAGE: page, REST: later}
