"""What of a browser's messages reaches the server: orders on the wire of its own document, and nothing else.

Bokeh would apply any patch of any model, unpack compressed bytes, add roots, and answer what fails with a traceback.
Here a message is looked at before Bokeh sees it: orders are read and obeyed, all else is refused; the document, the
same for all, is sent from here. Undocumented in Bokeh 3.9: that the handler of "/ws" has the `connection` of a session,
that a message is header, metadata and content, each a fragment, and that a document has to be told what a browser knows
of it.
"""

import asyncio
import json
import logging
import re
from time import perf_counter

from bokeh.util.token import get_session_id
from panel.io.server import WSHandler

from app.door import door, turned_away
from app.page import shared
from app.service import metrics
from app.session import orders
from app.session.allowance import Allowance
from app.session.session import visitors
from app.session.wire import Wire

log = logging.getLogger("app")
HEAD = 500  # characters of a header
MANY = 100  # events in a message
TRY_LATER = 1013  # of RFC 6455
TOKEN = 8000  # characters of what a browser shows when it comes
SAID = 10  # refusals of one connection that are logged; then every hundredth
LARGE = re.compile(r'\{"events":\[\{"kind":"ModelChanged","model":\{"id":"([\w-]{1,64})"\},"attr":"order","new":(?=")')

here = set()  # ids of the sessions whose browsers are connected


class Gate(WSHandler):
    """The websocket of one visitor."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self.parts, self.refused, self.allowance, self.name = [], 0, Allowance(), None

    def open(self, *where, **named):
        """Let a browser in that shows the token of its page, if there is room."""
        try:
            if not self._token or len(self._token) > TOKEN:
                raise ValueError("no token of this server")
            name = get_session_id(self._token)
            if name in here:
                raise ValueError("a page has one browser")
            if door.lets_in(name):
                self.name = name
                here.add(name)
                return super().open(*where, **named)
            turned_away()
        except Exception as error:  # whatever a stranger has forged; a traceback for each would fill the log
            log.info("a browser was turned away: %s", type(error).__name__)
        self.close(TRY_LATER)

    def on_close(self):
        """The browser has gone; Bokeh may have found that out before, by a ping, while its messages still waited."""
        here.discard(self.name)
        if self._session is not None:
            super().on_close()

    @property
    def _session(self):
        """The session of the browser; None before there is one, and when the browser has gone."""
        try:
            return self.connection and self.connection.session
        except AssertionError:
            return None

    async def _async_open(self, token):
        try:
            await super()._async_open(token)
        except Exception as error:  # as above
            log.info("a browser was turned away: %s", type(error).__name__)
            self.close(TRY_LATER)

    async def on_message(self, fragment):
        """Take in a fragment; a message that is none of ours changes nothing, and costs its sender a little time."""
        begun = perf_counter()
        try:
            number, kind, given = self._message(fragment)
            if kind == "PULL-DOC-REQ" and self._wire("wire"):
                await self._session.with_document_locked(self._give_document, number)
            elif kind == "PULL-DOC-REQ":
                for part in ({"msgid": number, "msgtype": kind}, {}, {}):
                    await super().on_message(json.dumps(part))
            for order in given:
                if self._visitor:
                    await self._session.with_document_locked(self._visitor.obey, order)
        except orders.Refused as refused:
            self.parts = []
            await self._refuse(refused)
            await asyncio.sleep(0.001)
        await asyncio.sleep(self.allowance.spend(perf_counter() - begun))

    def _message(self, fragment):
        """(number, kind, [Order]) of a message once it is whole, until then (None, None, []); raises Refused."""
        if not isinstance(fragment, str) or self._session is None:
            raise orders.Refused("A message came in a form that is not used here.")
        if len(fragment) > (HEAD, HEAD, 2.3 * orders.LARGEST)[len(self.parts)]:
            raise orders.Refused("A message was too long.")
        self.parts.append(fragment)
        if len(self.parts) < 3:
            return None, None, []
        (header, _, content), self.parts = self.parts, []
        head = orders.plain_json(header)
        kind = head.get("msgtype") if isinstance(head, dict) else None
        number = head.get("msgid") if isinstance(head, dict) else None
        if kind not in ("PULL-DOC-REQ", "PATCH-DOC") or not isinstance(number, str) or head.get("num_buffers"):
            raise orders.Refused("A message was of a kind that is not used here.")
        return number, kind, self._orders(content) if kind == "PATCH-DOC" else []

    async def _give_document(self, number):
        """Answer a browser that asks for its document, with the text that is the same for all."""
        head = {"msgid": f"{number}-document", "msgtype": "PULL-DOC-REPLY", "reqid": number}
        text = shared(self.application_context.url).document
        with await self.write_lock.acquire():
            for part in (json.dumps(head), "{}", f'{{"doc":{text}}}'):
                await self.write_message(part, locked=False)
        self._session.document.models.flush_synced()

    def _orders(self, content):
        """Of all that a browser says about its models, the Orders; raises Refused."""
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
        wire, text, rest = orders.one_text(content, LARGE)
        if rest != "}]}":
            raise orders.Refused("A message was too long.")
        return [self._checked(wire, text)]

    def _checked(self, wire, text):
        if not self._wire(wire) or not isinstance(text, str):
            raise orders.Refused("A message was not an order.")
        return orders.read(text)

    @property
    def _visitor(self):
        session = self._session
        return session and next((each for each in visitors if each.doc is session.document), None)

    def _wire(self, name):
        """Whether that is the id of the visitor's wire."""
        return isinstance(name, str) and isinstance(self._session.document.get_model_by_id(name), Wire)

    async def _refuse(self, refused):
        """One line for the log, one sentence for the visitor."""
        self.refused += 1
        metrics.count("refused_messages")
        if self.refused <= SAID or self.refused % 100 == 0:
            log.info("refused message %d of a browser: %s", self.refused, refused)
        if self._visitor:
            await self._session.with_document_locked(self._visitor.refuse, refused)
