#!/usr/bin/env bash
# A parameter of a Panel JSComponent that the browser sets reaches its watcher in Python 50 ms late, and of several
# values set within that time only the last one, without a word. Bokeh's own model has each of them at once. So a
# parameter is no queue of orders: orders that must all arrive need model.send_msg, or one parameter each.
set -euo pipefail
folder=$(mktemp -d)
trap 'kill "${server:-}" 2>/dev/null || true; rm -rf "$folder"' EXIT
for python in "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.13*/bin/python python3.13; do
    if "$python" -c '' 2>/dev/null; then break; fi
done
cat > "$folder/component.py" <<'PY'
import panel as pn
import param


class Part(pn.custom.JSComponent):
    order = param.Integer(0)
    _esm = "export const render = () => document.createElement('div')"
PY
cat > "$folder/served.py" <<'PY'
import time

import panel as pn
from component import Part

came = []  # (what heard it, value, s)
part = Part()
part.param.watch(lambda event: came.append(("parameter", event.new, time.monotonic())), "order")
root = part.get_root(pn.state.curdoc)
root.data.on_change("order", lambda _, old, new: came.append(("model", new, time.monotonic())))
pn.state.curdoc.add_root(root)


async def report():
    if any(value == 3 and what == "parameter" for what, value, _ in came):
        first = next(at for what, value, at in came if what == "model" and value == 1)
        late = next(at for what, value, at in came if what == "parameter") - first
        heard = {name: [value for what, value, _ in came if what == name] for name in ("model", "parameter")}
        print(heard, f"{1000 * late:.0f} ms", "late" if late > 0.04 else "soon", flush=True)

pn.state.curdoc.add_periodic_callback(report, 100)
PY
cat > "$folder/visit.py" <<'PY'
import sys
import time

import component  # so that the model is known here
from bokeh.client import pull_session

session = pull_session(url=sys.argv[1])
(part,) = session.document.roots
for order in (1, 2, 3):  # as a browser does that sets model.order three times in a row
    part.data.order = order
session.force_roundtrip()
time.sleep(2)
PY
for version in 1.9.4 1.10.0; do
    "$python" -m venv "$folder/$version"
    "$folder/$version/bin/pip" install --quiet panel==$version
    PYTHONPATH="$folder" "$folder/$version/bin/panel" serve "$folder/served.py" --port 5199 > "$folder/log" 2>&1 & server=$!
    until grep -q "running at" "$folder/log"; do sleep 0.2; done
    PYTHONPATH="$folder" "$folder/$version/bin/python" "$folder/visit.py" http://localhost:5199/served > /dev/null 2>&1 || true
    kill $server; wait $server 2>/dev/null || true
    echo "panel $version: $(grep -m1 parameter "$folder/log")"
    grep -q "'model': \[1, 2, 3\], 'parameter': \[3\]} .* late" "$folder/log"
done
echo "as found: of three orders the parameter has the last one, 50 ms late"
