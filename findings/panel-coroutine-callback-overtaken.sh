#!/usr/bin/env bash
# Two coroutine functions are given to add_next_tick_callback one after the other, the first by a thread, as when a
# computation is done, the second by a callback of the browser. Each sets the same parameter. Under Panel 1.9.4
# with Bokeh 3.9 the first value is applied last: the parameter has the newer one, its model and the browser keep the
# older. Bokeh 3.9 forgets the current document before it awaits a coroutine. Panel's own variable for it comes along
# from a callback of the browser, but not from a thread; there Panel puts the change off until the next callback.
# Changes within `panel.io.state.set_curdoc(document)` keep their order, as do all with Panel 1.10.0 and Bokeh 3.10.
set -euo pipefail
folder=$(mktemp -d)
trap 'kill "${server:-}" 2>/dev/null || true; rm -rf "$folder"' EXIT
for python in "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.13*/bin/python python3.13; do
    if "$python" -c '' 2>/dev/null; then break; fi
done
cat > "$folder/served.py" <<'PY'
import os
from contextlib import nullcontext
from threading import Thread

import panel as pn
from panel.io.state import set_curdoc

document = pn.state.curdoc
asked, shown = pn.widgets.IntInput(value=0), pn.widgets.IntInput(value=0, name="shown")


def setting(value):
    async def called():
        with set_curdoc(document) if os.environ["CONTEXT"] == "set_curdoc" else nullcontext():
            shown.value = value

    return called


def answer(event):
    thread = Thread(target=document.add_next_tick_callback, args=(setting(1),))
    thread.start()
    thread.join()
    document.add_next_tick_callback(setting(2))


asked.param.watch(answer, "value")
pn.Column(asked, shown).servable()
PY
cat > "$folder/visit.py" <<'PY'
import asyncio
import json
import re
import sys
import urllib.request

from tornado.websocket import websocket_connect


def spinners(part):
    if isinstance(part, dict) and part.get("name", "").endswith("Spinner") and "id" in part:
        yield part
    for each in part.values() if isinstance(part, dict) else part if isinstance(part, list) else ():
        yield from spinners(each)


async def visit(address):
    page = urllib.request.urlopen(address).read().decode()
    socket = await websocket_connect(
        address.replace("http", "ws") + "/ws", subprotocols=["bokeh", re.search(r'"token":"([^"]+)"', page)[1]]
    )

    async def until(word):
        while word not in (part := str(await asyncio.wait_for(socket.read_message(), 20))):
            pass
        return json.loads(part)

    async def send(number, kind, content):
        for part in ({"msgid": str(number), "msgtype": kind}, {}, content):
            await socket.write_message(json.dumps(part))

    await until('"ACK"')
    await send(1, "PULL-DOC-REQ", {})
    inputs = {model["attributes"].get("title"): model["id"] for model in spinners(await until('"roots"'))}
    shown = inputs.pop("shown")
    (asked,) = inputs.values()
    ready = {"type": "event", "name": "document_ready", "values": {"type": "map", "entries": []}}
    await send(2, "PATCH-DOC", {"events": [{"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": ready}]})
    await asyncio.sleep(2)
    await send(3, "PATCH-DOC", {"events": [{"kind": "ModelChanged", "model": {"id": asked}, "attr": "value", "new": 5}]})
    seen = []
    while len(seen) < 2:
        events = (await until('"events"'))["events"]
        seen += [e["new"] for e in events if e.get("attr") == "value" and e["model"]["id"] == shown]
    print(*seen)


asyncio.run(visit(sys.argv[1]))
PY
for version in 1.9.4 1.10.0; do
    "$python" -m venv "$folder/$version"
    "$folder/$version/bin/pip" install --quiet panel==$version
    for context in none set_curdoc; do
        expected=$([[ $version$context == 1.9.4none ]] && echo 2 1 || echo 1 2)
        rm -f "$folder/log"
        CONTEXT=$context "$folder/$version/bin/panel" serve "$folder/served.py" --port 5197 > "$folder/log" 2>&1 & server=$!
        until grep -qs "running at" "$folder/log"; do sleep 0.2; done
        seen=$("$folder/$version/bin/python" "$folder/visit.py" http://localhost:5197/served 2> "$folder/errors") || cat "$folder/errors" "$folder/log"
        kill $server; wait $server 2>/dev/null || true
        echo "panel $version, context $context: set 1 2, arrived $seen"
        [[ $seen == "$expected" ]]
    done
done
echo "as found: under 1.9.4 the value set first arrives last, unless the document is made the current one"
