#!/usr/bin/env bash
# pn.extension() of Panel 1.9.4 counts for the document that is current as it is called. In a module that a server
# imports once, it counts for the first visitor: the pages of all later ones load the scripts of every model that any
# page of this server has imported, here of a table that they do not show. So it is called for each document, which
# takes a sixth of what a document with one component takes, or for the one from which the page is composed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet panel==1.9.4
cat > "$folder/pages.py" <<'PY'
import panel as pn
import panel.models.tabulator  # as another page of this server does
from bokeh.document import Document
from panel.io.resources import Resources, bundle_resources
from panel.io.state import set_curdoc


class Empty(pn.custom.JSComponent):
    _esm = "export const render = () => document.createElement('div')"


pn.extension()  # when the module is imported
for again in (False, True):
    document = Document()
    with set_curdoc(document):
        if again:
            pn.extension()
        Empty().server_doc(document, location=False)
        scripts = bundle_resources(document.roots, Resources(mode="server")).js_files
    print("for this document, too:" if again else "at import only:", sum("tabulator" in str(name) for name in scripts))
PY
seen=$("$folder/venv/bin/python" "$folder/pages.py")
echo "$seen"
[[ $(tr '\n' ' ' <<< "$seen") =~ ^"at import only: "[1-9].*"for this document, too: 0" ]]
echo "as found: scripts of a table are loaded by pages of documents for which pn.extension was not called"
