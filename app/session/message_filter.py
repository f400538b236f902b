"""The websocket of a visitor. Of all messages of a browser, only changes of `wire.order` reach the Session.

Bokeh parses the messages. It would also apply patches of any model, add roots, and answer errors with a traceback; this
module rejects such messages. It also sends the document, which is the same for all. Undocumented in Bokeh 3.9: the
handler of "/ws" has the `receiver`, `handler` and `connection` of a session, and a document must know the models of a
browser.
"""

import asyncio
import json
import logging
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from bokeh.util.token import get_session_id
from panel.io.server import WSHandler
from tornado.ioloop import IOLoop
from tornado.websocket import WebSocketClosedError

from app.environment import VISITORS
from app.on_loop import on_loop
from app.page import shared
from app.service import metrics
from app.session import orders
from app.session.session import visitors

log = logging.getLogger("app")
LONGEST = 2 * orders.SMALL  # characters of a text in a message, such as an order without its file
PARTS = 5  # of a message: header, metadata, content; for a file also its header and bytes
TRY_LATER = 1013  # of RFC 6455
TOKEN = 8000  # characters of the token that a browser sends when it connects
SILENT = 30.0  # s without a valid message after which a new connection ends; a page sends one at once
CHANGES = {"ModelChanged", "MessageSent"}  # of widgets, and clicks
CHANGE = {"kind": "ModelChanged", "model": {"id": "wire"}, "attr": "order"}  # an event with an order

connected = set()  # ids of the sessions whose browsers are connected
opened = set()  # ids of the sessions of research pages that were sent, and whose browsers may still connect
metrics.gauge("visitors", "browsers that are connected", lambda: len(connected))


def is_full(peer: str) -> bool:
    """Whether the maximum number of browsers is there; if so, count a rejection of this address."""
    if len(connected) + len(opened) < VISITORS:
        return False
    metrics.count("rejected_visits")
    log.info("class full: a visitor was rejected", extra={"peer": peer})
    return True


class MessageFilter(WSHandler):
    """The websocket of one visitor."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.parts, self.name, self.rejected, self.silent = 0, None, False, True

    def set_default_headers(self) -> None:
        self.clear_header("Server")

    def open(self, *where: Any, **named: Any) -> Any:
        """Accept a browser with the token of its page, unless the server is full."""
        try:
            if not self._token or len(self._token) > TOKEN:
                raise ValueError("no token of this server")
            name = get_session_id(self._token)
            if name in connected:
                raise ValueError("a page has one browser")
            opened.discard(name)
            if not is_full(self.request.remote_ip):
                self.name = name
                connected.add(name)
                IOLoop.current().call_later(SILENT, self._end_if_silent)
                return super().open(*where, **named)
            self.close(TRY_LATER)
        except Exception as error:  # a forged token may raise anything
            self._reject(error)

    def on_close(self) -> None:
        """Handle the end of the connection. Bokeh may have noticed it before, by a ping, while messages waited."""
        self._give_up_place()
        if self._session is not None:
            if visitor := self._visitor():
                visitor.attendance.leave()  # its class need not wait until Bokeh discards the session
            super().on_close()

    def _give_up_place(self):
        connected.discard(self.name)
        self.name = None  # another connection may have the same token now

    async def _async_open(self, token):
        try:
            await super()._async_open(token)
        except Exception as error:
            self._reject(error)

    def _reject(self, error):
        """Close the connection and log one line, without a traceback."""
        self.rejected = True  # further messages are ignored
        self._give_up_place()  # at once: a client that does not answer ends the connection only seconds later
        metrics.count("rejected_messages")
        log.info("a browser was rejected: %s", type(error).__name__, extra={"peer": self.request.remote_ip})
        self.close(TRY_LATER)

    def _end_if_silent(self):
        """Give up a browser without a message: it must not keep others out."""
        if self.silent and self.name in connected:
            self._reject(TimeoutError())

    @property
    def _session(self):
        """The session of the browser; None before it exists and after the browser left."""
        try:
            return self.connection and self.connection.session
        except AssertionError:
            return None

    async def on_message(self, fragment: str | bytes) -> None:
        """Let Bokeh parse a part of a message, and obey the message when complete."""
        if self.rejected:
            return await asyncio.sleep(0)
        self.parts += 1
        try:
            if self.parts > PARTS:
                raise ValueError("a message of too many parts")
            plain = self._is_plain()
            message = await self.receiver.consume(fragment if plain else _bounded(fragment))
            if message is not None:
                self.parts = 0
                given = [] if plain and is_change(message) else _orders(message)
                self.silent = False
        except Exception as error:
            return self._reject(error)
        if message is not None and self._session is not None:
            with suppress(WebSocketClosedError):  # it has left
                await (self._apply(message) if plain else self._answer(message, given))
        await asyncio.sleep(0)  # Tornado awaits this for its whole buffer: other visitors have a turn

    async def send_message(self, message: Any) -> None:
        """Send a message, unless the browser has left meanwhile. Bokeh would log a warning for each one that waits."""
        with suppress(WebSocketClosedError):
            await message.send(self)

    def _is_plain(self) -> bool:
        """Whether the document is a page of app/lab, whose widgets Bokeh keeps up to date."""
        context = self._session and self._session.document.session_context
        return bool(context and context.request) and "lab" in context.request.arguments

    async def _apply(self, message: Any) -> None:
        """Let Bokeh apply changes of the widgets, or send the document. An error ends the connection."""
        session = self._session
        if message.msgtype == "PULL-DOC-REQ":
            return await self._give_own_document(message)
        try:
            await self.send_message(await session.patch(message, self.connection))
        except Exception as error:
            self._reject(error)

    def _visitor(self):
        """The Session of this browser, or None."""
        here = tuple(visitors)  # under Bokeh 3.10 a thread may add one
        return next((each for each in here if each.doc is self._session.document), None)

    async def _answer(self, message, given):
        session, visitor = self._session, self._visitor()
        if message.msgtype != "PULL-DOC-REQ":
            for order in given if visitor else ():
                await session.with_document_locked(on_loop(visitor.obey, order))
        elif isinstance(session.document.get_model_by_id("wire"), orders.Wire):
            await session.with_document_locked(self._give_document, message.header["msgid"])
        else:  # the document shows the error
            await self._give_own_document(message)

    async def _give_own_document(self, message):
        """Let Bokeh answer the request for a document: Bokeh 3.10 sends it, 3.9 returns the message to send."""
        reply = await self.handler.handle(message, self.connection)
        if reply is not None:
            await self.send_message(reply)

    async def _give_document(self, number):
        """Answer the request for a document with the text that all visitors share."""
        head = {"msgid": f"{number}-document", "msgtype": "PULL-DOC-REPLY", "reqid": number}
        text = shared(self.application_context.url).document
        with await self.write_lock.acquire():
            for part in (json.dumps(head), "{}", f'{{"doc":{text}}}'):
                await self.write_message(part, locked=False)
        self._session.document.models.flush_synced()


def _bounded(fragment):
    """Return a part of a message, or an empty one if it is too long."""
    if isinstance(fragment, str):
        return fragment if len(fragment) <= LONGEST else "{}"
    return fragment if len(fragment) <= orders.LARGEST else b""


def _orders(message):
    """Return the new values {name: value} of `wire.order` in a message; raises ValueError for other messages."""
    if message.msgtype not in ("PATCH-DOC", "PULL-DOC-REQ") or not isinstance(message.header["msgid"], str):
        raise ValueError("a message that no page sends")
    events = message.content.get("events", ()) if message.msgtype == "PATCH-DOC" else ()
    files = [buffer.to_bytes() for buffer in message.buffers]
    given = [decoded(event["new"], files) for event in events if event.items() >= CHANGE.items()]
    if not all(isinstance(order, dict) for order in given):
        raise ValueError("an order without fields")
    return given


def is_change(message: Any) -> bool:
    """Whether a message only changes models, or asks for the document; raises ValueError for any other."""
    if message.msgtype not in ("PATCH-DOC", "PULL-DOC-REQ"):
        raise ValueError("a message that no page sends")
    kinds = {event["kind"] for event in message.content.get("events", ())}
    if kinds - CHANGES:
        raise ValueError("a message that adds to the document")
    return True


def decoded(value: Any, files: Sequence[Any] = ()) -> Any:
    """Return a value that BokehJS has encoded, from plain values, lists, objects and one file of `files`, bytes."""
    if isinstance(value, list):
        return [decoded(each, files) for each in value]
    if not isinstance(value, dict):
        return value
    if value["type"] == "map":
        return {str(name): decoded(each, files) for name, each in value.get("entries", ())}
    if value["type"] == "bytes":
        return files[0]
    return float(value["value"])  # of type "number": nan or infinite
