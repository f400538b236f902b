"""A Result as one HTML file that plays without Bokeh, a server and a network: the script of a Stage, and one run."""

import base64
import html
import json
from typing import Any

from app import bundle

FILE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>html, body {{ margin: 0; height: 100% }}</style>
<script>
  const theme = new URLSearchParams(location.search).get("theme")
  const dark = theme ? theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches
  document.documentElement.style.background = dark ? "#14171b" : "#ffffff"
</script></head>
<body>
<script type="module">{script}
const {{ body, ...run }} = {run}, bytes = Uint8Array.from(atob(body), (c) => c.charCodeAt(0))
const given = {{ live: false, height: 1, on() {{}}, run: {{ ...run, body: bytes.buffer }}, status: {status} }}
render({{ model: new Proxy(given, {{ get: (of, name) => of[name] ?? {{}} }}), data: given, el: document.body }})
</script></body></html>
"""


def file_of(given: dict[str, Any], title: str) -> str:
    """Return the file of a Result as text; given: the parameters of a Stage that plays it (`stage.played`)."""
    run = given["run"] | {"body": base64.b64encode(given["run"]["body"]).decode()}
    script = bundle.script(bundle.PLAYED).replace("</script", "<\\/script").replace("<!--", "<\\!--")
    run, status = (json.dumps(each).replace("</", "<\\/") for each in (run, given["status"]))
    return FILE.format(title=html.escape(title), script=script, run=run, status=status)
