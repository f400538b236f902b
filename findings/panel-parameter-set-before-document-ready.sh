#!/usr/bin/env bash
# What a Panel 1.9.4 server sets between the moment a browser has pulled the document and the browser's event
# document_ready never reaches it: the change is held, and dropped when the event comes, as if the document were still to
# be pulled. The browser keeps the old value until the parameter changes again. Panel 1.10.0 sends it. Under 1.9 a
# component that answers what its script asks while it renders has to wait for pn.state.onload.
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
    asked, early, late = param.Integer(0), param.Integer(0), param.Integer(0)
    _esm = "export const render = () => document.createElement('div')"
PY
cat > "$folder/served.py" <<'PY'
import panel as pn
from component import Part

part = Part()


def answer(event):
    if event.new == 1:
        part.early = 7
    else:
        part.late = 8

part.param.watch(answer, "asked")
part.servable()
PY
cat > "$folder/visit.py" <<'PY'
import asyncio
import json
import re
import sys
import urllib.request

from bokeh.protocol import Protocol
from bokeh.protocol.receiver import Receiver
from tornado.websocket import websocket_connect

sent = 0


async def send(socket, kind, content):  # as BokehJS does
    global sent
    sent += 1
    for part in ({"msgid": str(sent), "msgtype": kind}, {}, content):
        await socket.write_message(json.dumps(part))


async def heard(socket, receiver, seconds=1.5):
    """The messages of so many seconds."""
    found, end = [], asyncio.get_running_loop().time() + seconds
    while (left := end - asyncio.get_running_loop().time()) > 0:
        try:
            part = await asyncio.wait_for(socket.read_message(), left)
        except asyncio.TimeoutError:
            break
        message = await receiver.consume(part)
        if message is not None:
            found.append(message)
    return found


async def visit(address):
    page = urllib.request.urlopen(address).read().decode()
    token = re.search(r'"token":"([^"]+)"', page)[1]
    socket = await websocket_connect(address.replace("http", "ws") + "/ws", subprotocols=["bokeh", token])
    receiver, seen = Receiver(Protocol()), []
    await heard(socket, receiver)
    await send(socket, "PULL-DOC-REQ", {})
    (reply,) = await heard(socket, receiver)
    part = next(root["attributes"]["data"]["id"] for root in reply.content["doc"]["roots"] if "Part" in str(root))
    for step in (1, "ready", 2):
        event = {"kind": "ModelChanged", "model": {"id": part}, "attr": "asked", "new": step}
        if step == "ready":
            ready = {"type": "event", "name": "document_ready", "values": {"type": "map", "entries": []}}
            event = {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": ready}
        await send(socket, "PATCH-DOC", {"events": [event]})
        for message in await heard(socket, receiver):
            seen += [change["attr"] for change in message.content.get("events", ()) if "attr" in change]
    print(*seen)

asyncio.run(visit(sys.argv[1]))
PY
for version in 1.9.4 1.10.0; do
    expected=$([[ $version == 1.9.4 ]] && echo late || echo early late)
    "$python" -m venv "$folder/$version"
    "$folder/$version/bin/pip" install --quiet panel==$version
    PYTHONPATH="$folder" "$folder/$version/bin/panel" serve "$folder/served.py" --port 5198 > "$folder/log" 2>&1 & server=$!
    until grep -q "running at" "$folder/log"; do sleep 0.2; done
    seen=$(PYTHONPATH="$folder" "$folder/$version/bin/python" "$folder/visit.py" http://localhost:5198/served 2>/dev/null)
    kill $server; wait $server 2>/dev/null || true
    echo "panel $version, set and sent: $seen"
    [[ $seen == "$expected" ]]
done
echo "as found: 1.9.4 loses what is set before document_ready, 1.10.0 sends it"
