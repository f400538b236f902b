"""Messages from browsers: only declared orders reach a session; all others change nothing."""

import asyncio
import base64
import gzip
import inspect
import json
import logging
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest
from bokeh.core.serialization import Serializer
from bokeh.protocol import Protocol
from bokeh.protocol.receiver import Receiver
from bokeh.util.token import generate_jwt_token
from tornado import locks
from tornado.websocket import WebSocketClosedError
from visitor import say

from app import pages
from app.session import message_filter, orders

SCRIPTS = list(Path(pages.__file__).parents[1].rglob("*.js"))
HELLO = {"do": "hello", "n": 0}


def encoded(value):
    """A value as BokehJS writes it."""
    return Serializer().encode(value)


def waited(coroutine):
    """Its result; in a thread, as Playwright leaves a running loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result(60.0)


class Visit:
    """A MessageFilter as Tornado makes one, `obeyed`: orders that reach it, `closed`: codes of closing."""

    def __init__(self, session, monkeypatch):
        self.session, self.obeyed, self.closed = session, [], []
        self.filter = message_filter.MessageFilter.__new__(message_filter.MessageFilter)
        self.filter.parts, self.filter.name, self.filter.rejected = 0, None, False
        self.filter.request = SimpleNamespace(remote_ip="192.0.2.9")
        self.filter.receiver = Receiver(Protocol())
        server = SimpleNamespace(document=session.doc, with_document_locked=self._locked)
        self.filter.connection = SimpleNamespace(session=server)
        session.wire._id = "wire"
        session.doc.add_root(session.wire)
        monkeypatch.setattr(message_filter, "connected", set())
        monkeypatch.setattr(self.filter, "close", self.closed.append)
        monkeypatch.setattr(session, "obey", self.obeyed.append)

    async def _locked(self, call, *arguments):
        result = call(*arguments)
        return await result if inspect.isawaitable(result) else result

    def parts(self, *fragments):
        """Send the parts of a message; return the orders that reached the session."""

        async def send():
            for fragment in fragments:
                await self.filter.on_message(fragment)

        self.obeyed.clear()
        waited(send())
        return self.obeyed

    def say(self, content, kind="PATCH-DOC"):
        """Send a message; return the orders that reached the session."""
        return self.parts(json.dumps({"msgid": "1", "msgtype": kind}), '{"mine": 1}', json.dumps(content))

    def order(self, given):
        return self.patch(encoded(given))

    def patch(self, new, attr="order", **more):
        return {"events": [{"kind": "ModelChanged", "model": {"id": "wire"}, "attr": attr, "new": new} | more]}

    @property
    def notes(self):
        return self.session.status.get("notes")


@pytest.fixture
def visit(session, monkeypatch):
    say(session, HELLO)
    return Visit(session, monkeypatch)


def test_an_order_reaches_the_session_once_whatever_else_the_message_contains(visit):
    assert visit.say(visit.patch(encoded(HELLO), more="x" * 100) | {"references": [1]}) == [HELLO]


def test_a_file_arrives_as_bytes_with_its_order(visit):
    head = json.dumps({"msgid": "1", "msgtype": "PATCH-DOC", "num_buffers": 1})
    file = {"type": "bytes", "data": {"id": "b"}}
    entries = [["do", "file"], ["n", 5], ["entry", "profile"], ["content", file]]
    content, table = json.dumps(visit.patch({"type": "map", "entries": entries})), b"x,z\n" * 100_000
    (given,) = visit.parts(head, "{}", content, '{"id": "b"}', table)
    assert given == {"do": "file", "n": 5, "entry": "profile", "content": table}
    fields = {"entry": "profile", "content": table}
    assert orders.read(given, visit.session.orders) == (visit.session.read_file, fields)
    (given,) = visit.parts(head, "{}", content, '{"id": "b"}', table * 6)
    assert given["content"] == b""  # too large: read as empty
    content = json.dumps(visit.patch({"type": "map", "entries": [[f"{k}", file] for k in range(250)]}))
    (given,) = visit.parts(head, "{}", content, '{"id": "b"}', table)
    assert len({id(text) for text in given.values()}) == 1  # a file named often takes memory once


def test_patches_of_bokeh_figures_are_dropped(visit):
    ready = {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": {"event_name": "document_ready"}}
    assert visit.say({"events": [ready, visit.patch(400, "inner_width")["events"][0]]}) == []
    large = visit.patch("x" * 50_000, "text")
    assert visit.say(large) == [] and not visit.closed
    assert visit.say(visit.order(HELLO)) == [HELLO]  # the next message is understood


@pytest.mark.parametrize("token", [None, "", "x" * 9000, "e30", "W10", "eyJzZXNzaW9uX2lkIjogM30", "é"])
def test_a_connection_without_a_valid_token_is_rejected_without_a_traceback(visit, caplog, token):
    caplog.set_level(logging.INFO, "app")
    visit.filter._token = token
    visit.filter.open()
    assert visit.closed == [message_filter.TRY_LATER] and "rejected" in caplog.text and "Traceback" not in caplog.text


@pytest.mark.slow
def test_a_browser_receives_the_shared_document(visit, monkeypatch):
    visit.session.doc.models.recompute()
    visit.filter.application_context = SimpleNamespace(url="/app")
    visit.filter.write_lock, sent = locks.Lock(), []

    async def write(self, text, locked=True):
        sent.append(json.loads(text))

    monkeypatch.setattr(message_filter.MessageFilter, "write_message", write)
    assert visit.say({}, "PULL-DOC-REQ") == []
    assert sent[0] | {"msgid": ""} == {"msgid": "", "msgtype": "PULL-DOC-REPLY", "reqid": "1"}
    roots = [*visit.session.pages.slots]
    assert sent[2]["doc"]["title"] and len(sent[2]["doc"]["roots"]) == len(roots)
    assert visit.session.wire in visit.session.doc.models.synced_references  # a later patch refers to it


@pytest.fixture
def connected(visit, monkeypatch):
    """A filter that has a token, without the session behind it; what was opened."""
    opened = []
    monkeypatch.setattr(message_filter.WSHandler, "open", lambda self: opened.append(self))
    monkeypatch.setattr(message_filter.WSHandler, "on_close", lambda self: None)
    visit.filter._token = generate_jwt_token("a page of mine")
    return visit.filter, opened


def test_a_page_accepts_one_connection_at_a_time(visit, connected):
    own, opened = connected
    own.open()
    assert len(opened) == 1 and not visit.closed
    own.open()
    assert len(opened) == 1 and visit.closed == [message_filter.TRY_LATER]
    own.on_close()
    own.open()
    assert len(opened) == 2


def test_connections_beyond_the_visitor_limit_are_rejected(visit, connected, monkeypatch):
    own, opened = connected
    monkeypatch.setattr(message_filter, "VISITORS", 2)
    message_filter.connected.update({"one", "other"})
    own.open()
    assert opened == [] and visit.closed == [message_filter.TRY_LATER]
    message_filter.connected.discard("one")
    own.open()
    assert opened == [own]


def test_messages_of_a_closed_connection_are_ignored_without_a_traceback(visit, monkeypatch):
    """Bokeh removes the session of a closed connection, while its earlier messages still arrive."""

    class Detached:
        @property
        def session(self):
            raise AssertionError

    monkeypatch.setattr(visit.filter, "connection", Detached())
    monkeypatch.setattr(message_filter.WSHandler, "on_close", lambda self: self.connection.session)
    assert visit.say(visit.order(HELLO)) == visit.say({}, "PULL-DOC-REQ") == []
    visit.filter.on_close()


def test_messages_that_wait_when_a_browser_leaves_are_dropped_without_a_word(visit, caplog, monkeypatch):
    async def refused(*_, **__):
        raise WebSocketClosedError

    monkeypatch.setattr(visit.filter, "write_message", refused)
    visit.filter.write_lock, visit.filter.application_context = locks.Lock(), SimpleNamespace(url="/app")
    monkeypatch.setattr(message_filter, "shared", lambda url: SimpleNamespace(document="{}"))
    with caplog.at_level(logging.INFO):
        waited(visit.filter.send_message(Protocol().create("ACK")))
        visit.say({}, "PULL-DOC-REQ")
    assert not caplog.records and not visit.closed


def test_other_visitors_are_served_during_a_flood_of_messages(visit):
    """Tornado awaits on_message for its whole buffer: without a pause no other visitor would be served."""
    turns = []

    async def flood():
        other = asyncio.create_task(count())
        for k in range(50):
            await visit.filter.on_message(json.dumps({"msgid": f"{k}", "msgtype": "PATCH-DOC"}))
            await visit.filter.on_message("{}")
            await visit.filter.on_message(json.dumps(visit.order(HELLO)))
        other.cancel()

    async def count():
        while True:
            turns.append(len(visit.obeyed))
            await asyncio.sleep(0)

    waited(flood())
    assert len(turns) >= 150 and {*turns} >= {*range(1, 50)}


BOMB = {"type": "bytes", "data": base64.b64encode(gzip.compress(bytes(10**6))).decode()}


def test_only_patches_of_the_order_property_are_accepted(visit):
    for attr in ("chunk", "status", "picture", "name", "tags"):
        assert visit.say(visit.patch(BOMB, attr)) == []
    for kind in ("RootAdded", "RootRemoved", "TitleChanged", "ColumnDataChanged", "ColumnsStreamed"):
        assert visit.say(visit.patch("x", kind=kind)) == []
    figure = next(iter(visit.session.pages.slots.values()))
    for model in (figure.id, "p1", None, {"id": 1}):
        assert visit.say(visit.patch(encoded(HELLO), model={"id": model})) == []


STRANGE = [{"type": kind, "name": "os.system", "id": "x"} for kind in ("object", "number", "ndarray", "set")]


@pytest.mark.parametrize("new", [BOMB, None, 3, "hello", '{"do": "hello"}', {"do": "hello"}, ["x"], *STRANGE])
def test_orders_that_are_no_objects_of_plain_values_are_rejected(visit, new):
    assert visit.say(visit.patch(new)) == [] and visit.closed == [message_filter.TRY_LATER]


PATCH = '{"msgid":"1","msgtype":"PATCH-DOC"}'


@pytest.mark.parametrize(
    "parts",
    [
        ('{"msgid":"1","msgtype":"PUSH-DOC"}', "{}", "{}"),
        ('{"msgid":"1","msgtype":"SERVER-INFO-REQ"}', "{}", "{}"),
        ('{"msgid":"1","msgtype":"NONE"}', "{}", "{}"),
        ('{"msgid":1,"msgtype":"PATCH-DOC"}', "{}", "{}"),
        ('{"msgtype":"PATCH-DOC"}', "{}", "{}"),
        ("[]", "{}", "{}"),
        ("x" * 100_000, "{}", "{}"),
        (PATCH, "{}", "{"),
        (PATCH, "{}", "[" * 7000),
        (PATCH, "{}", "[]"),
        (PATCH, "{}", '{"events": [3]}'),
        (PATCH, "{}", f'{{"events": [{"9" * 5000}]}}'),
        (b"\x00" * 100,),
        ('{"msgid":"1","msgtype":"PATCH-DOC","num_buffers":9}', "{}", "{}", '{"id":"1"}', b"1", '{"id":"2"}'),
    ],
)
def test_malformed_messages_close_the_connection_and_are_logged_in_one_line(visit, caplog, parts):
    caplog.set_level(logging.INFO, "app")
    assert visit.parts(*parts) == []
    assert visit.closed == [message_filter.TRY_LATER]
    assert visit.say(visit.order(HELLO)) == [] and visit.say([]) == []  # nothing is heard any longer
    (line,) = [record.message for record in caplog.records if record.name == "app"]
    assert "rejected" in line and len(line) < 120


@pytest.mark.parametrize(
    "text",
    [
        '{"do": "scene", "values": {"__class__": "1"}}',
        '{"do": "scene", "values": {"E": [1]}}',
        '{"do": "scene", "values": {"E": {"a": 1}}}',
        '{"do": "scene", "values": {"E": 80}, "after": [1, 5]}',
        '{"do": "scene", "values": {"E": 80}, "held": 1}',
        '{"do": "scene", "values": {"E": "' + "9" * 8001 + '"}}',
        '{"do": "scene", "values": [1]}',
        '{"do": "film", "run": 1}',
        '{"do": "film", "run": 1, "frame": 2, "other": 3}',
        '{"do": "film", "run": 1, "frame": NaN}',
        '{"do": "page", "page": ["law"]}',
        '{"do": "page", "page": {}}',
        '{"do": "ask", "draws": "many"}',
        '{"do": "restore", "values": "fig6"}',
        '{"do": "restore", "values": {"E": 80}}',
        '{"do": "close"}',
        '{"do": ["hello"]}',
        '{"do": {}}',
        "{}",
    ],
)
def test_orders_with_undeclared_fields_or_wrong_types_are_rejected(session, text):
    with pytest.raises(orders.Refused):
        orders.read(json.loads(text), session.orders)


def test_a_field_of_an_order_may_be_missing_only_if_its_method_has_a_default():
    class Part:
        @orders.order("move", far=orders.is_number, held=orders.is_flag)
        def shift(self, far, held=False):
            return far, held

    methods = orders.orders_of(Part())
    for given, expected in (({"far": 2}, (2, False)), ({"far": 2, "held": True}, (2, True))):
        method, values = orders.read({"do": "move", "n": 1} | given, methods)
        assert method(**values) == expected
    for given in ({}, {"held": True}, {"far": "2"}, {"far": 2, "n": 3, "fast": True}):
        with pytest.raises(orders.Refused):
            orders.read({"do": "move"} | given, methods)


def test_every_order_that_the_scripts_give_is_declared(session):
    scripts = "".join(path.read_text(encoding="utf-8") for path in SCRIPTS)
    given = set(re.findall(r'\border\((?:on \? )?"(\w+)"', scripts))
    assert given <= session.orders.keys() and len(given) > 10


@pytest.mark.parametrize("text", ['{"do":"close","n":7}', '{"do":"film","run":-1,"n":7}'])
def test_a_rejected_order_is_acknowledged_with_advice(session, text):
    say(session, HELLO)
    say(session, text)
    status = session.status
    assert status["acknowledged"] == 7 and "Reload the page" in status["notes"][0]


@pytest.mark.parametrize("text", ["1" * 65, "x" * 7000, "1," * 3000, "-" * 7000, "1e" * 3000])
def test_a_long_entry_is_rejected_at_its_field_and_acknowledged(session, text):
    say(session, HELLO)
    say(session, {"do": "scene", "values": {"E": text}, "n": 3})
    status = session.status
    assert status["acknowledged"] == 3 and "Stiffness" in status["errors"]["E"] and len(status["errors"]["E"]) < 300


def test_every_order_is_acknowledged(session):
    for number, order in enumerate([HELLO, {"do": "release"}, {"do": "layer", "rows": 1, "modes": 1, "depth": 1}]):
        say(session, order | {"n": number})
        assert session.status["acknowledged"] == number


def test_a_programming_error_is_logged_but_not_shown_to_visitors(session, caplog, monkeypatch):
    say(session, HELLO)
    monkeypatch.setattr("app.session.controls.changed_scene", lambda *_: 1 / 0)
    say(session, '{"do":"scene","values":{"E":"80"}}')
    assert "ZeroDivisionError" in caplog.text and "Traceback" in caplog.text
    why = session.status["why"]
    assert "its log" in why and "division" not in why and "Error" not in why


@pytest.mark.parametrize(
    ("kind", "accepted"), [("ModelChanged", True), ("MessageSent", True), ("RootAdded", False), ("TitleChanged", False)]
)
def test_a_research_page_accepts_changes_of_widgets_and_clicks_only(kind, accepted):
    message = SimpleNamespace(msgtype="PATCH-DOC", content={"events": [{"kind": kind}]})
    if accepted:
        assert message_filter.is_change(message)
    else:
        with pytest.raises(ValueError, match="adds to the document"):
            message_filter.is_change(message)
