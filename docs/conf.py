"""The documentation: `python docs/build.py` executes the tutorials and builds all pages, links checked."""

import re

project = "mixed-mode-contact"
author = "The mixed-mode-contact authors"
extensions = ["myst_nb", "sphinx.ext.autodoc"]
html_theme = "furo"
html_static_path = []
exclude_patterns = ["_build"]
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


def setup(app):
    """Connects the hook; see https://www.sphinx-doc.org/en/master/extdev/event_callbacks.html."""
    app.connect("autodoc-process-docstring", plain)
