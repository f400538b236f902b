#!/usr/bin/env bash
# Bokeh: an error while a callback is announced (here of a document that was destroyed, as when a visitor has left) leaves
# that document as the current one of the whole process. From then on curdoc() raises "Patched curdoc has been
# previously destroyed" in code that has nothing to do with it: the stack of current documents is popped on success only.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet bokeh==3.9.2 2>/dev/null
cd "$folder"
venv/bin/python - <<'PY'
import bokeh
from bokeh.document import Document
from bokeh.io import curdoc

doc = Document()
assert curdoc() is not None
doc.callbacks.destroy()
try:
    doc.add_next_tick_callback(lambda: None)
    raise SystemExit("no error: as expected no longer")
except AttributeError as error:
    print("bokeh", bokeh.__version__, "-", error)
assert curdoc() is doc  # not the default document
del doc
import gc

gc.collect()
try:
    curdoc()
    raise SystemExit("the current document was restored: changed")
except RuntimeError as error:
    print("then:", error)
print("as found: the current document of the process stays the destroyed one")
PY
