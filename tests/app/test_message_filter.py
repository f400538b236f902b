"""Messages from browsers: of a Stage only declared orders reach a session; all others change nothing."""

import asyncio
import base64
import gzip
import json
import logging
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from bokeh.core.serialization import Serializer
from bokeh.protocol import Protocol
from bokeh.protocol.receiver import Receiver
from bokeh.util.token import generate_jwt_token
from panel.reactive import Syncable
from tornado import locks
from tornado.websocket import WebSocketClosedError, WebSocketHandler
from visitor import OWN, say, waited

import app
from app.experiment import Experiment
from app.session import message_filter, orders
from app.stage import Wire

SCRIPTS = list(Path(app.__file__).parent.rglob("*.js"))
HELLO = {"do": "hello", "n": 0}


class Odd:
    """A part of a visitor with an order that has fields of all kinds."""

    taken = None

    @orders.order(
        "skip",
        run=orders.is_whole,
        content=orders.is_content,
        page=orders.is_text,
        link=orders.is_link,
        kind=("npz", "json").__contains__,
    )
    def take(self, run, **others):
        self.taken = others


@pytest.fixture
def odd(session, monkeypatch):
    """The part, whose order takes the place of one of the core, as parameters of the Stage are fixed."""
    part = Odd()
    monkeypatch.setattr(session, "orders", session.orders | orders.orders_of(part))
    return part


class Visit:
    """A MessageFilter as Tornado makes one, `obeyed`: orders that reach it, `closed`: codes of closing."""

    def __init__(self, session, monkeypatch):
        self.session, self.obeyed, self.closed = session, [], []
        self.filter = message_filter.MessageFilter.__new__(message_filter.MessageFilter)
        self.filter.parts, self.filter.name, self.filter.rejected, self.filter.written = 0, None, False, []
        self.filter.request = SimpleNamespace(remote_ip="192.0.2.9")
        self.filter.receiver = Receiver(Protocol())
        self.filter.connection = SimpleNamespace(
            session=SimpleNamespace(document=session.doc, patch=self._patch, request_expiration=lambda: None)
        )
        self.filter.application_context = SimpleNamespace(_cleanup_sessions=lambda age: None)
        root = session.stage.get_root(session.doc)
        session.doc.add_root(root)
        self.root, self.wire = root.id, root.data.id
        session.own = self.wire
        monkeypatch.setattr(message_filter, "connected", set())
        monkeypatch.setattr(self.filter, "close", self.closed.append)
        monkeypatch.setattr(session, "obey", lambda name, given: self.obeyed.append({"do": name} | given))

    async def _patch(self, message, connection):
        message.apply_to_document(self.session.doc)

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
        """The content of the message of an order."""
        fields = {name: value for name, value in given.items() if name != "do"}
        return self.patch(Serializer().encode(fields), given["do"])

    def patch(self, new, attr="scene", model=None):
        return {"events": [{"kind": "ModelChanged", "model": {"id": model or self.wire}, "attr": attr, "new": new}]}

    @property
    def notes(self):
        return self.session.status.get("notes")


@pytest.fixture
def visit(session, monkeypatch):
    say(session, HELLO)
    return Visit(session, monkeypatch)


def test_an_order_reaches_the_session_once_whatever_else_the_message_contains(visit):
    assert visit.say(visit.order(HELLO) | {"references": [1]}) == [HELLO]


def test_a_file_arrives_as_bytes_with_its_order_and_is_kept_by_nothing(visit, odd):
    head = json.dumps({"msgid": "1", "msgtype": "PATCH-DOC", "num_buffers": 1})
    entries = [["n", 5], ["run", 1], ["content", {"type": "bytes", "data": {"id": "b"}}]]
    content, table = json.dumps(visit.patch({"type": "map", "entries": entries}, "skip")), b"x,z\n" * 100_000
    (given,) = visit.parts(head, "{}", content, '{"id": "b"}', table)
    assert given == {"do": "skip", "n": 5, "run": 1, "content": table}
    Experiment.obey(visit.session, "skip", {"n": 5, "run": 1, "content": table})
    assert odd.taken == {"content": table} and visit.session.stage.skip == {}


@pytest.mark.parametrize("token", [None, "", "x" * 9000, "e30", "W10", "eyJzZXNzaW9uX2lkIjogM30", "é"])
def test_a_connection_without_a_valid_token_is_rejected_without_a_traceback(visit, caplog, token):
    caplog.set_level(logging.INFO, "app")
    visit.filter._token = token
    visit.filter.open()
    assert visit.closed == [message_filter.TRY_LATER] and "rejected" in caplog.text and "Traceback" not in caplog.text


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
    visit.filter.write_lock = locks.Lock()
    with caplog.at_level(logging.INFO):
        waited(visit.filter.send_message(Protocol().create("ACK")))
    assert not caplog.records and not visit.closed


def test_no_message_waits_while_the_parts_of_another_are_on_their_way(visit, monkeypatch):
    """Panel 1.9 may keep what has to wait until the next message."""
    written, handler = [], visit.filter
    handler.write_lock = locks.Lock()

    def write(_, part, binary=False):
        written.append(part)
        return asyncio.get_running_loop().create_future()  # until the browser has read it

    monkeypatch.setattr(WebSocketHandler, "write_message", write)

    async def send():
        message = asyncio.ensure_future(handler.send_message(Protocol().create("ACK")))
        await asyncio.sleep(0)
        free = handler.write_lock._block._value != 0  # as Panel looks
        message.cancel()
        return free

    assert waited(send())
    assert len(written) == 3  # header, metadata, content


def test_other_visitors_are_served_during_a_flood_of_messages(visit):
    """Tornado awaits on_message for its whole buffer: without a pause no other visitor would be served."""
    turns = []

    async def flood():
        other = asyncio.create_task(count())
        for k in range(50):
            await visit.filter.on_message(json.dumps({"msgid": f"{k}", "msgtype": "PATCH-DOC"}))
            await visit.filter.on_message("{}")
            await visit.filter.on_message(json.dumps(visit.order({"do": "hello", "n": k})))
        other.cancel()

    async def count():
        while True:
            turns.append(len(visit.obeyed))
            await asyncio.sleep(0)

    waited(flood())
    assert len(turns) >= 150 and {*turns} >= {*range(1, 50)}


BOMB = {"type": "bytes", "data": base64.b64encode(gzip.compress(bytes(10**6))).decode()}


@pytest.mark.parametrize(
    ("model", "attr", "new"),
    [
        *(("wire", attr, BOMB) for attr in ("run", "status", "opened", "name", "tags")),
        *(("root", attr, "x") for attr in ("data", "esm", "children")),
        *((other, "text", "x") for other in ("p1", "x")),
    ],
)
def test_a_browser_sets_nothing_but_parameters_of_the_stage_by_their_orders(visit, model, attr, new):
    assert visit.say(visit.patch(new, attr, getattr(visit, model, model))) == []
    assert visit.closed == [message_filter.TRY_LATER]


@pytest.mark.parametrize("kind", ["RootAdded", "RootRemoved", "TitleChanged", "ColumnDataChanged", "ColumnsStreamed"])
def test_a_message_that_adds_to_the_document_ends_the_connection(visit, kind):
    assert visit.say({"events": [visit.order(HELLO)["events"][0] | {"kind": kind}]}) == []
    assert visit.closed == [message_filter.TRY_LATER]


def test_a_change_of_a_model_that_is_gone_changes_nothing_and_the_rest_of_its_message_counts(visit, monkeypatch):
    """On a research page a figure tells its size while it is being replaced."""
    monkeypatch.setattr(message_filter, "visitors", set())
    events = [visit.patch("x", "text", "p1")["events"][0], visit.order(HELLO)["events"][0]]
    assert visit.say({"events": events}) == [HELLO] and not visit.closed


STRANGE = [{"type": kind, "name": "os.system", "id": "x"} for kind in ("object", "number", "ndarray", "set")]


@pytest.mark.parametrize("new", [3, "hello", '{"do": "hello"}', ["x"], *STRANGE])
def test_orders_that_are_no_objects_are_rejected(visit, new):
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
        '{"do": "skip", "page": "law"}',
        '{"do": "skip", "run": 1, "other": 3}',
        '{"do": "skip", "run": NaN}',
        '{"do": "skip", "run": 1, "page": ["law"]}',
        '{"do": "skip", "run": 1, "page": {}}',
        '{"do": "restore", "values": "fig6"}',
        '{"do": "restore", "values": {"E": 80}}',
        '{"do": "restore", "values": {"name": "x"}}',
        '{"do": "restore", "values": {"preset": "' + "1" * 9000 + '"}}',
        '{"do": "skip", "run": 1, "kind": "py"}',
        '{"do": "skip", "run": 1, "link": 5}',
        '{"do": "skip", "run": 1, "link": "' + "x" * 6000 + '"}',
    ],
)
@pytest.mark.usefixtures("odd")
def test_orders_with_undeclared_fields_or_wrong_types_are_rejected(session, text):
    given = json.loads(text)
    with pytest.raises(orders.Refused):
        orders.read(session.orders[given.pop("do")], given)


@pytest.mark.usefixtures("odd")
@pytest.mark.parametrize("text", ["\ud800", "fig6\udfff", "\ude00\ud83d"])
def test_a_text_that_no_encoding_can_write_is_rejected_in_every_field_of_every_order(session, text):
    tried = 0
    for method in session.orders.values():
        for test in (method.order.needs | method.order.takes).values():
            names = {orders.are_entries: "E", orders.is_address: "preset"}
            for value in (text, {names.get(test, "E"): text}, {text: "1"}):
                assert not test(value)
                tried += 1
    assert tried > 20
    say(session, HELLO)
    say(session, {"do": "restore", "values": {"preset": text}, "n": 3})
    assert session.status["acknowledged"] == 3 and "Reload the page" in session.status["notes"][0]
    assert orders.is_text("θ 😀")  # one character, and no half of it


def test_a_field_of_an_order_may_be_missing_only_if_its_method_has_a_default():
    class Part:
        @orders.order("move", far=orders.is_number, held=orders.is_flag)
        def shift(self, far, held=False):
            return far, held

    move = orders.orders_of(Part())["move"]
    for given, expected in (({"far": 2}, (2, False)), ({"far": 2, "held": True}, (2, True))):
        method, values = orders.read(move, {"n": 1} | given)
        assert method(**values) == expected
    for given in ({}, {"held": True}, {"far": "2"}, {"far": 2, "n": 3, "fast": True}):
        with pytest.raises(orders.Refused):
            orders.read(move, given)


def test_every_order_that_the_scripts_give_is_declared_and_a_parameter_of_the_stage(session):
    scripts = "".join(path.read_text(encoding="utf-8") for path in SCRIPTS)
    given = set(re.findall(r'\border\((?:on \? )?"(\w+)"', scripts))
    assert given == session.orders.keys() and given <= {*Wire.param} and len(given) >= 5


def test_every_message_that_the_scripts_take_is_a_parameter_of_the_stage(session):
    scripts = "".join(path.read_text(encoding="utf-8") for path in SCRIPTS)
    own = {name for name, parameter in Wire.param.objects().items() if parameter.owner in OWN}
    own -= {"name"}
    assert set(re.findall(r'\btake\("(\w+)"', scripts)) == own - session.orders.keys()


def test_orders_that_panel_must_not_delay_are_parameters_of_the_stage():
    """`_priority_changes` is Panel's own; without it each slider step would wait 50 ms more."""
    assert Syncable._priority_changes == [] and {*Wire._priority_changes} <= {*Wire.param}


@pytest.mark.parametrize("text", ['{"do":"hello","at":1,"n":7}', '{"do":"release","exact":-1,"n":7}'])
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
    for number, order in enumerate([HELLO, {"do": "release"}, {"do": "skip"}]):
        say(session, order | {"n": number})
        assert session.status["acknowledged"] == number


def test_an_error_of_an_order_beside_the_run_is_a_note_and_leaves_the_run(session, caplog, monkeypatch):
    class Failing:
        @orders.order("beside")
        def fail(self):
            return 1 / 0

    say(session, HELLO)
    monkeypatch.setattr(session, "orders", session.orders | orders.orders_of(Failing()))
    say(session, '{"do":"beside"}')
    assert "ZeroDivisionError" in caplog.text and session.run.state != "failed"
    assert "its log describes. The run on screen stays." in session.status["notes"][0]


@pytest.mark.usefixtures("odd")
def test_nothing_keeps_the_file_of_an_order_that_is_refused(session):
    session.stage.skip = {"n": 1, "content": b"1,2", "unit": 3}
    session.obey("skip", session.stage.skip)
    assert session.stage.skip == {}


def test_a_programming_error_is_logged_but_not_shown_to_visitors(session, caplog, monkeypatch):
    say(session, HELLO)
    monkeypatch.setattr("app.session.controls.changed_scene", lambda *_: 1 / 0)
    say(session, '{"do":"scene","values":{"E":"80"}}')
    assert "ZeroDivisionError" in caplog.text and "Traceback" in caplog.text
    why = session.status["why"]
    assert "its log" in why and "division" not in why and "Error" not in why
