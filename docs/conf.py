"""The documentation: `python docs/build.py` executes tutorials and gallery, and builds all pages, links checked."""

import re
from pathlib import Path

project = "mixed-mode-contact"
author = "The mixed-mode-contact authors"
extensions = ["myst_nb", "sphinx.ext.autodoc"]
html_theme = "furo"
html_static_path = []
exclude_patterns = ["_build", "apps"]  # apps: files to copy, run by tests/browser/test_layouts.py
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300  # s; the first tutorial compiles the kernels, which takes up to a minute on a slow machine
autodoc_member_order = "bysource"
autodoc_typehints = "description"
nitpicky = False
suppress_warnings = ["mystnb.unknown_mime_type"]  # HoloViews adds a form for notebooks beside its HTML
linkcheck_anchors = False


def plain(app, what, name, obj, options, lines):
    """Keep docstrings as they are: they are plain text, in which | and * are no markup."""
    for k, line in enumerate(lines):
        lines[k] = re.sub(r"([|*\\])", r"\\\1", line)


SECTION = """
## {title}

{claim}

```{{code-cell}} ipython3
:tags: [remove-input]
show("{path}")
```

```{{literalinclude}} {path}
:start-at: "{code}"
```
"""


def gallery(app, page, source):
    """Append a section for each script to the page of the gallery: claim, number, picture, code."""
    if page == "gallery":
        for path in sorted(Path(app.srcdir, "gallery").glob("*.py")):
            _, doc, code = path.read_text(encoding="utf-8").split('"""', 2)
            title, _, claim = doc.partition(".\n\n")
            first = code.lstrip().partition("\n")[0]
            source[0] += SECTION.format(title=title, claim=claim, path=f"gallery/{path.name}", code=first)


def features(app, page, source):
    """List the features of the app by their own sentences, where a page asks for it."""
    if "<!-- features -->" in source[0]:
        from app.interface import found

        rows = [f"| `{name}` | {text.partition(chr(10))[0]} |" for name, text in sorted(found().items())]
        table = "\n".join(["| folder | feature |", "|---|---|", *rows])
        source[0] = source[0].replace("<!-- features -->", table)


def setup(app):
    """Connects the hooks; see https://www.sphinx-doc.org/en/master/extdev/event_callbacks.html."""
    app.connect("autodoc-process-docstring", plain)
    app.connect("source-read", gallery)
    app.connect("source-read", features)
