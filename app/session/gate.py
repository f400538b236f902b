"""The websocket of a visitor: of a browser's messages, changes of `wire.order` reach the Session, and nothing else.

Bokeh reads the messages. It would also apply any patch of any model, add roots, and answer errors with a traceback: a
stranger's messages never get there. The document, the same for all, is sent from here. Undocumented in Bokeh 3.9: that
the handler of "/ws" has the `receiver`, `handler` and `connection` of a session, and that a document needs to know
which models a browser has.
"""

import asyncio
import json
import logging
from time import monotonic, thread_time

from bokeh.util.token import get_session_id
from panel.io.server import WSHandler

from app.hosts import NamedHost
from app.page import shared
from app.service import metrics
from app.session import orders
from app.session.session import VISITORS, visitors
from app.session.wire import Wire

log = logging.getLogger("app")
LONGEST = 2 * orders.SMALL  # characters of a text in a message: an order within JSON
AT_ONCE = 0.5  # s of the server's loop that a visitor's messages may take before they wait: to open a few pages
LONGEST_WAIT = 5.0  # s, less than after which a page counts its connection as lost
SHARE = 0.5  # of the loop's time for all visitors who send more than that
PARTS = 5  # of a message: header, metadata, content; and of a file its header and bytes
TRY_LATER = 1013  # of RFC 6455
TOKEN = 8000  # characters of what a browser shows when it connects
CHANGE = {"kind": "ModelChanged", "model": {"id": "wire"}, "attr": "order"}  # an event that brings an order

here = set()  # ids of the sessions whose browsers are connected
metrics.gauge("visitors", "browsers that are connected", lambda: len(here))


def is_full():
    """Whether as many browsers are connected as may be; counts a refusal."""
    if len(here) < VISITORS:
        return False
    metrics.count("turned_away")
    log.info("class full: a visitor was turned away")
    return True


class Gate(NamedHost, WSHandler):
    """The websocket of one visitor."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self.parts, self.name, self.turned_away = 0, None, False
        self.spent, self.since = 0.0, monotonic()

    def open(self, *where, **named):
        """Let a browser in that shows the token of its page, if there is room."""
        try:
            if not self._token or len(self._token) > TOKEN:
                raise ValueError("no token of this server")
            name = get_session_id(self._token)
            if name in here:
                raise ValueError("a page has one browser")
            if not is_full():
                self.name = name
                here.add(name)
                return super().open(*where, **named)
            self.close(TRY_LATER)
        except Exception as error:  # whatever a stranger has forged
            self._turn_away(error)

    def on_close(self):
        """The browser has gone; Bokeh may have found that out before, by a ping, while its messages still waited."""
        here.discard(self.name)
        if self._session is not None:
            super().on_close()

    async def _async_open(self, token):
        try:
            await super()._async_open(token)
        except Exception as error:
            self._turn_away(error)

    def _turn_away(self, error):
        """Close the connection, with one line in the log: a stranger's traceback helps nobody."""
        self.turned_away = True  # what is on its way is not read
        metrics.count("refused_messages")
        log.info("a browser was turned away: %s", type(error).__name__)
        self.close(TRY_LATER)

    @property
    def _session(self):
        """The session of the browser; None before there is one, and when the browser has gone."""
        try:
            return self.connection and self.connection.session
        except AssertionError:
            return None

    async def on_message(self, fragment):
        """Let Bokeh read a part of a message, and obey the message once it is whole."""
        if self.turned_away:
            return await asyncio.sleep(0)
        self.parts += 1
        try:
            if self.parts > PARTS:
                raise ValueError("a message of too many parts")
            message = await self.receiver.consume(_bounded(fragment))
            if message is not None:
                self.parts = 0
                found = _orders(message)
        except Exception as error:
            return self._turn_away(error)
        begun = thread_time()  # of the loop alone: other processes may be busy
        if message is not None and self._session is not None:
            await self._answer(message, found)
        await asyncio.sleep(self._wait(thread_time() - begun))  # also of 0 s: then it is the turn of other visitors

    def _wait(self, seconds):
        """Seconds until the next message is read, after one that took so many: AT_ONCE is free, then a share."""
        share, now = SHARE / max(1, len(here)), monotonic()
        self.spent = max(0.0, self.spent - share * (now - self.since)) + seconds
        self.since = now
        return min(LONGEST_WAIT, max(0.0, self.spent - AT_ONCE) / share)

    async def _answer(self, message, found):
        session = self._session
        visitor = next((each for each in visitors if each.doc is session.document), None)
        if message.msgtype != "PULL-DOC-REQ":
            for order in found if visitor else ():
                await session.with_document_locked(visitor.obey, order)
        elif isinstance(session.document.get_model_by_id("wire"), Wire):
            await session.with_document_locked(self._give_document, message.header["msgid"])
        else:  # the document says why there is no experiment
            await self.send_message(await self.handler.handle(message, self.connection))

    async def _give_document(self, number):
        """Answer a browser that asks for its document, with the text that is the same for all."""
        head = {"msgid": f"{number}-document", "msgtype": "PULL-DOC-REPLY", "reqid": number}
        text = shared(self.application_context.url).document
        with await self.write_lock.acquire():
            for part in (json.dumps(head), "{}", f'{{"doc":{text}}}'):
                await self.write_message(part, locked=False)
        self._session.document.models.flush_synced()


def _bounded(fragment):
    """A part of a message; in place of one that is too long, an empty one."""
    if isinstance(fragment, str):
        return fragment if len(fragment) <= LONGEST else "{}"
    return fragment if len(fragment) <= orders.SMALL + orders.LARGEST else b""


def _orders(message):
    """What a message gives as values of `wire.order`, texts or bytes; raises ValueError if no page sends such."""
    if message.msgtype not in ("PATCH-DOC", "PULL-DOC-REQ") or not isinstance(message.header["msgid"], str):
        raise ValueError("a message that no page sends")
    events = message.content.get("events", ()) if message.msgtype == "PATCH-DOC" else ()
    new = [event["new"] for event in events if event.items() >= CHANGE.items()]
    return [value if isinstance(value, str) else bytes(message.buffers[0].data) for value in new]
