"""The websocket of a visitor. A browser may change the models of its own page, and add none.

Bokeh parses and applies the messages. It would also add roots, or change the title; this module rejects such messages.
Of the experiment a browser sets the parameters of the Stage that have an order, and nothing else. Undocumented in
Bokeh 3.9: the handler of "/ws" has the `receiver`, `handler` and `connection` of a session, `write_lock`, which Panel
looks at, and an `application_context`, which discards sessions.
"""

import asyncio
import logging
from contextlib import suppress
from math import inf
from typing import Any

from bokeh.util.token import get_session_id
from panel.io.server import WSHandler
from tornado.ioloop import IOLoop
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from app.environment import VISITORS
from app.experiment import visitors
from app.service import metrics

log = logging.getLogger("app")
PARTS = 5  # of a message: header, metadata, content; for a file also its header and bytes
TRY_LATER = 1013  # of RFC 6455
TOKEN = 8000  # characters of the token that a browser sends when it connects
ALIVE = 30.0  # s between two pings, and for the answer: a browser that sleeps keeps its place for twice that
SILENT = 30.0  # s without a valid message after which a new connection ends; a page sends one at once
CHANGES = {"ModelChanged", "MessageSent"}  # of the Stage, of widgets of features' own pages, and clicks

connected = set()  # ids of the sessions whose browsers are connected
# {id: ServerSession} of features' own pages that were sent, and whose browsers may still connect
opened = dict[str, Any]()
metrics.gauge("visitors", "browsers that are connected", lambda: len(connected))


def is_full(peer: str, coming: int = 0) -> bool:
    """Whether the maximum number of browsers is there, or coming; if so, count a rejection of this address."""
    if len(connected) + coming < VISITORS:
        return False
    metrics.count("rejected_visits")
    log.info("class full: a visitor was rejected", extra={"peer": peer})
    return True


def no_longer_opened(name: str) -> None:
    """Let the session of a feature's own page end from now on: its browser has connected, or has not come in time."""
    if session := opened.pop(name, None):
        session.unblock_expiration()


class MessageFilter(WSHandler):
    """The websocket of one visitor."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.parts, self.name, self.rejected, self.silent = 0, None, False, True
        self.written: list[Any] = []  # parts of a message

    def set_default_headers(self) -> None:
        self.clear_header("Server")

    @property
    def ping_interval(self) -> float:
        """Tornado ends a connection whose browser does not answer; Bokeh's own pings wait for no answer."""
        return ALIVE

    def open(self, *where: Any, **named: Any) -> Any:
        """Accept a browser with the token of its page, unless the server is full."""
        try:
            if not self._token or len(self._token) > TOKEN:
                raise ValueError("no token of this server")
            name = get_session_id(self._token)
            if name in connected:
                raise ValueError("a page has one browser")
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
        if (session := self._session) is not None:
            super().on_close()
            session.request_expiration()  # at once: Bokeh's next look is up to 32 s away, and workers would go on
            IOLoop.current().spawn_callback(self.application_context._cleanup_sessions, inf)

    def _give_up_place(self):
        connected.discard(self.name)
        self.name = None  # another connection may have the same token now

    async def _async_open(self, token):
        try:
            await super()._async_open(token)
            no_longer_opened(get_session_id(token))
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
        """Let Bokeh parse a part of a message, and apply the message when complete."""
        if self.rejected:
            return await asyncio.sleep(0)
        self.parts += 1
        try:
            if self.parts > PARTS:
                raise ValueError("a message of too many parts")
            message = await self.receiver.consume(fragment)
            if message is not None:
                self.parts = 0
                self._check(message)
                self.silent = False
                if self._session is not None:
                    await self._apply(message)
        except WebSocketClosedError:  # it has left
            pass
        except Exception as error:
            return self._reject(error)
        await asyncio.sleep(0)  # Tornado awaits this for its whole buffer: other visitors have a turn

    async def send_message(self, message: Any) -> None:
        """Send a message, unless the browser has left meanwhile. Bokeh would log a warning for each one that waits."""
        with suppress(WebSocketClosedError):
            try:
                await message.send(self)
            finally:
                written, self.written = self.written, []
                await asyncio.gather(*written)

    async def write_message(self, message: Any, binary: bool = False, locked: bool = True) -> None:
        """Write a part of a message; `send_message` waits until all are on their way.

        While a message is written no other can be, and Panel 1.9 may keep such a one until the next.
        """
        if locked:
            await super().write_message(message, binary)
        else:
            self.written.append(WebSocketHandler.write_message(self, message, binary))

    def _check(self, message):
        """Raise ValueError for a message that no page sends. Changes of what is gone are dropped: it was replaced."""
        if message.msgtype not in ("PATCH-DOC", "PULL-DOC-REQ") or not isinstance(message.header["msgid"], str):
            raise ValueError("a message that no page sends")
        events = message.content.get("events", ())
        if {event["kind"] for event in events} - CHANGES:
            raise ValueError("a message that adds to the document")
        if not events or self._session is None:
            return
        visitor, known = self._visitor(), self._session.document.get_model_by_id
        changes = [event for event in events if event["kind"] == "ModelChanged"]
        if visitor and not all(visitor.may_change(change["model"]["id"], change["attr"]) for change in changes):
            raise ValueError("a change of what the server tells")
        gone = [change for change in changes if known(change["model"]["id"]) is None]
        message.content["events"] = [event for event in events if event not in gone]

    async def _apply(self, message):
        """Let Bokeh apply changes, or send the document: Bokeh 3.10 sends it, 3.9 returns the message to send."""
        if message.msgtype == "PULL-DOC-REQ":
            reply = await self.handler.handle(message, self.connection)
        else:
            reply = await self._session.patch(message, self.connection)
        if reply is not None:
            await self.send_message(reply)

    def _visitor(self):
        """The Experiment of this browser, or None."""
        if self._session is None:
            return None
        here = tuple(visitors)  # under Bokeh 3.10 a thread may add one
        return next((each for each in here if each.doc is self._session.document), None)
