"""What of a browser's messages reaches the server: orders on the wire of its own document, and nothing else.

Bokeh would apply any patch of any model, unpack compressed bytes, add roots, and answer what fails with a traceback.
Here a message is looked at before Bokeh sees it, and what passes is written anew. Undocumented in Bokeh 3.9: that
`bokeh.server.urls.per_app_patterns` names the handler of "/ws" (Panel replaces its entries in the same way), that its
`connection` is that of a session, and that a message comes as header, metadata and content, each a fragment.
"""

import asyncio
import json
import logging
import re
from time import perf_counter

from bokeh.server import urls
from panel.io.server import WSHandler  # puts its own handlers into the patterns when it is imported

from app.session import orders
from app.session.session import visitors
from app.session.wire import Wire

log = logging.getLogger("app")
HEAD = 500  # characters of a header
MANY = 100  # events in a message
SAID = 10  # refusals of one connection that are logged; then every hundredth
LARGE = re.compile(r'\{"events":\[\{"kind":"ModelChanged","model":\{"id":"([\w-]{1,64})"\},"attr":"order","new":(?=")')


class Gate(WSHandler):
    """The websocket of one visitor."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self.parts, self.refused = [], 0

    async def on_message(self, fragment):
        """Take in a fragment; a message that is none of ours changes nothing, and costs its sender a little time."""
        begun = perf_counter()
        try:
            message = self._message(fragment)
            for part in message:
                await super().on_message(part)
        except orders.Refused as refused:
            self.parts = []
            await self._refuse(refused)
            await asyncio.sleep(0.001)
        await asyncio.sleep(min(perf_counter() - begun, 0.5))  # half of the server's time at most for one visitor

    def _message(self, fragment):
        """The fragments of a message to hand on, once it is whole; raises Refused."""
        if not isinstance(fragment, str) or self.connection is None:
            raise orders.Refused("A message came in a form that is not used here.")
        if len(fragment) > (HEAD, HEAD, 2.3 * orders.LARGEST)[len(self.parts)]:
            raise orders.Refused("A message was too long.")
        self.parts.append(fragment)
        if len(self.parts) < 3:
            return ()
        (header, _, content), self.parts = self.parts, []
        head = orders.plain_json(header)
        kind = head.get("msgtype") if isinstance(head, dict) else None
        number = head.get("msgid") if isinstance(head, dict) else None
        if kind not in ("PULL-DOC-REQ", "PATCH-DOC") or not isinstance(number, str) or head.get("num_buffers"):
            raise orders.Refused("A message was of a kind that is not used here.")
        body = {}
        if kind == "PATCH-DOC":
            body = {"events": [_event(wire, text) for wire, text in self._orders(content)]}
            if not body["events"]:
                return ()
        return json.dumps({"msgid": number, "msgtype": kind}), "{}", json.dumps(body)

    def _orders(self, content):
        """[(id of a wire, order)]: of all that a browser says about its models, the orders; raises Refused."""
        if len(content) > orders.SMALL:
            return self._upload(content)
        patch = orders.plain_json(content)
        events = patch.get("events") if isinstance(patch, dict) else None
        if not isinstance(events, list) or len(events) > MANY:
            raise orders.Refused("A message could not be read.")
        found = []
        for event in events:
            if isinstance(event, dict) and event.get("kind") == "ModelChanged" and event.get("attr") == "order":
                model = event.get("model")
                found.append(self._checked(model.get("id") if isinstance(model, dict) else None, event.get("new")))
        return found

    def _upload(self, content):
        """The one long message there is: an order that brings a profile."""
        start = LARGE.match(content)
        if start is None:
            raise orders.Refused("A message was too long.")
        try:
            text, end = json.JSONDecoder().raw_decode(content, start.end())
        except ValueError:
            raise orders.Refused("A message could not be read.") from None
        if content[end:] != "}]}":
            raise orders.Refused("A message was too long.")
        return [self._checked(start[1], text)]

    def _checked(self, wire, text):
        known = isinstance(wire, str) and self.connection.session.document.get_model_by_id(wire)
        if not isinstance(known, Wire) or not isinstance(text, str):
            raise orders.Refused("A message was not an order.")
        orders.read(text)
        return wire, text

    async def _refuse(self, refused):
        """One line for the log, one sentence for the visitor."""
        self.refused += 1
        if self.refused <= SAID or self.refused % 100 == 0:
            log.info("refused message %d of a browser: %s", self.refused, refused)
        session = self.connection and self.connection.session
        visitor = session and next((each for each in visitors if each.doc is session.document), None)
        if visitor:
            await session.with_document_locked(visitor.refuse, refused)


def _event(wire, text):
    return {"kind": "ModelChanged", "model": {"id": wire}, "attr": "order", "new": text}


def install():
    """Have every websocket of this server go through the gate: before the server is made."""
    urls.per_app_patterns[:] = [(p[0], Gate, *p[2:]) if p[0] == "/ws" else p for p in urls.per_app_patterns]
