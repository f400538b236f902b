"""What a browser may say: orders on the wire of its own document, of known names; all else changes nothing."""

import asyncio
import base64
import gzip
import inspect
import json
import logging
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
from bokeh.util.token import generate_jwt_token
from tornado import locks
from visitor import NoPool, say

from app.pages import Pages
from app.service.finished import Shelf
from app.session import allowance, gate, orders
from app.session.allowance import Allowance
from app.session.session import Session

HELLO = '{"do":"hello","n":0}'


def waited(coroutine):
    """Its result; in a thread, as Playwright leaves a running loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result(60.0)


class Visit:
    """A Gate as Tornado would make one, for a session; `passed` is what it obeys, and what Bokeh would get to see."""

    def __init__(self, session, monkeypatch):
        self.session, self.passed = session, []
        self.gate = gate.Gate.__new__(gate.Gate)
        self.gate.parts, self.gate.refused, self.gate.allowance = [], 0, Allowance()
        self.gate.name = None
        server = SimpleNamespace(document=session.doc, with_document_locked=self._locked)
        self.gate.connection = SimpleNamespace(session=server)
        session.doc.add_root(session.wire)

        async def take(gate, fragment):
            self.passed.append(fragment)

        monkeypatch.setattr(gate.WSHandler, "on_message", take)
        monkeypatch.setattr(session, "obey", self.passed.append)

    async def _locked(self, call, *arguments):
        result = call(*arguments)
        return await result if inspect.isawaitable(result) else result

    def say(self, content, kind="PATCH-DOC", header=None):
        """Send a message; what passed of it."""
        self.passed.clear()
        head = header or json.dumps({"msgid": "1", "msgtype": kind})
        text = content if isinstance(content, str) else json.dumps(content, separators=(",", ":"))
        for fragment in (head, '{"mine": 1}', text):
            waited(self.gate.on_message(fragment))
        return self.passed

    def patch(self, new, attr="order", **more):
        event = {"kind": "ModelChanged", "model": {"id": self.session.wire.id}, "attr": attr, "new": new}
        return {"events": [event | more]}

    @property
    def notes(self):
        return json.loads(self.session.wire.status).get("notes")


@pytest.fixture
def visit(session, monkeypatch):
    say(session, HELLO)
    return Visit(session, monkeypatch)


def test_an_order_is_read_once_and_obeyed_and_bokeh_sees_nothing_of_it(visit):
    assert visit.say(visit.patch(HELLO, more="x" * 100) | {"references": [1]}) == [orders.Order("hello", n=0)]


def test_a_page_may_ask_for_its_document(visit):
    assert json.loads(visit.say({"x": 1}, "PULL-DOC-REQ")[0])["msgtype"] == "PULL-DOC-REQ"


def test_what_bokeh_says_about_its_figures_is_dropped_without_a_word(visit):
    before = visit.notes
    ready = {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": {"event_name": "document_ready"}}
    assert visit.say({"events": [ready, visit.patch(400, "inner_width")["events"][0]]}) == []
    assert visit.notes == before and visit.gate.refused == 0


@pytest.mark.parametrize("token", [None, "", "x" * 9000, "e30", "W10", "eyJzZXNzaW9uX2lkIjogM30", "é"])
def test_who_shows_no_token_of_a_page_is_turned_away_without_a_traceback(visit, monkeypatch, caplog, token):
    caplog.set_level(logging.INFO, "app")
    closed = []
    monkeypatch.setattr(visit.gate, "close", closed.append)
    visit.gate._token = token
    visit.gate.open()
    assert closed == [gate.TRY_LATER] and "turned away" in caplog.text and "Traceback" not in caplog.text


@pytest.mark.slow
def test_a_browser_is_given_the_document_that_all_have(visit, monkeypatch):
    visit.session.wire._id = "wire"
    visit.session.doc.models.recompute()
    visit.gate.application_context = SimpleNamespace(url="/app")
    visit.gate.write_lock, sent = locks.Lock(), []

    async def write(gate, text, locked=True):
        sent.append(json.loads(text))

    monkeypatch.setattr(gate.Gate, "write_message", write)
    assert visit.say({}, "PULL-DOC-REQ") == []
    assert sent[0] | {"msgid": ""} == {"msgid": "", "msgtype": "PULL-DOC-REPLY", "reqid": "1"}
    assert sent[2]["doc"]["title"] and len(sent[2]["doc"]["roots"]) == 5 + len(visit.session.pages.slots)
    assert visit.session.wire in visit.session.doc.models.synced_references  # a later patch refers to it


def test_a_page_has_one_browser(visit, monkeypatch, caplog):
    caplog.set_level(logging.INFO, "app")
    opened, closed = [], []
    monkeypatch.setattr(gate.WSHandler, "open", lambda gate: opened.append(gate))
    monkeypatch.setattr(gate.WSHandler, "on_close", lambda gate: closed.append(gate))
    monkeypatch.setattr(visit.gate, "close", closed.append)
    visit.gate._token = generate_jwt_token("a page of mine")
    visit.gate.open()
    assert len(opened) == 1 and not closed
    visit.gate.open()
    assert len(opened) == 1 and closed == [gate.TRY_LATER]
    closed.clear()
    visit.gate.on_close()
    assert len(closed) == 1
    visit.gate.open()
    assert len(opened) == 2
    visit.gate.on_close()


def test_a_browser_that_has_gone_is_not_heard_any_more_and_leaves_no_traceback(visit, monkeypatch):
    """Bokeh takes the session away from a connection that a ping finds closed; what it said before is still there."""

    class Detached:
        @property
        def session(self):
            raise AssertionError

    monkeypatch.setattr(visit.gate, "connection", Detached())
    monkeypatch.setattr(gate.WSHandler, "on_close", lambda gate: gate.connection.session)
    assert visit.say(visit.patch(HELLO)) == visit.say({}, "PULL-DOC-REQ") == []
    visit.gate.on_close()


def test_who_costs_much_waits_and_the_more_visitors_are_active_the_longer(monkeypatch):
    now = [1000.0]
    monkeypatch.setattr(allowance, "monotonic", lambda: now[0])
    monkeypatch.setattr(allowance, "active", {})
    waits = []
    for others in (0, 9):
        mine, *all_others = [Allowance() for _ in range(1 + others)]
        for each in all_others:
            each.spend(0.0)
        assert mine.spend(allowance.PURSE) == 0.0
        waits.append(mine.spend(0.03))
        now[0] += waits[-1]
        assert mine.spend(0.0) == pytest.approx(0.0, abs=1e-12)  # it has waited for it
        now[0] += 2.0 * allowance.LATELY  # those who say nothing do not count
    assert waits == pytest.approx([0.03 / allowance.MOST, 0.03 / (allowance.ALL / 10)])
    mine.spend(0.0)
    assert list(allowance.active) == [mine]


BOMB = {"type": "bytes", "data": base64.b64encode(gzip.compress(bytes(10**6))).decode()}


def test_no_patch_of_anything_but_the_order_passes(visit):
    for attr in ("chunk", "status", "picture", "name", "tags"):
        assert visit.say(visit.patch(BOMB, attr)) == []
    for kind in ("RootAdded", "RootRemoved", "TitleChanged", "ColumnDataChanged", "ColumnsStreamed"):
        assert visit.say(visit.patch("x", kind=kind)) == []


@pytest.mark.parametrize("new", [BOMB, None, 3, {"do": "hello"}, ["x"]])
def test_an_order_is_text(visit, new):
    assert visit.say(visit.patch(new)) == [] and visit.gate.refused == 1
    assert "stays" in visit.notes[0]


def test_another_model_than_the_own_wire_is_refused(visit):
    figure = next(iter(visit.session.pages.slots.values()))
    for model in (figure.id, "p1", None, {"id": 1}):
        event = {"kind": "ModelChanged", "model": {"id": model}, "attr": "order", "new": HELLO}
        assert visit.say({"events": [event]}) == []
    assert visit.gate.refused == 4


@pytest.mark.parametrize(
    ("content", "kind", "header"),
    [
        ("{}", "PUSH-DOC", None),
        ("{}", "SERVER-INFO-REQ", None),
        ("{", "PATCH-DOC", None),
        ("[" * 7000, "PATCH-DOC", None),
        ('{"events": [1e999, NaN]}', "PATCH-DOC", None),
        ("x" * 10_000, "PATCH-DOC", None),
        ('{"events":' + json.dumps([{}] * 200) + "}", "PATCH-DOC", None),
        ("{}", None, "[]"),
        ("{}", None, '{"msgid":"1","msgtype":"PATCH-DOC","num_buffers":1}'),
        ("{}", None, '{"msgid":1,"msgtype":"PATCH-DOC"}'),
        ("{}", None, "x" * 1000),
    ],
)
def test_what_is_no_message_of_ours_is_one_line_and_one_sentence(visit, caplog, content, kind, header):
    caplog.set_level(logging.INFO, "app")
    assert visit.say(content, kind, header) == []
    lines = [record.message for record in caplog.records if "refused" in record.message]
    assert len(lines) >= 1 and all(len(line) < 120 for line in lines)
    (note,) = visit.notes
    assert note.endswith("The run on screen stays.") and "Error" not in note
    visit.gate.parts.clear()
    assert visit.say(visit.patch(HELLO))  # the next one is understood


def test_binary_messages_and_large_ones_are_refused_unread(visit):
    for fragment in (b"\x00" * 100, "x" * 5_000_000):
        waited(visit.gate.on_message(fragment))
    assert visit.gate.refused == 2 and visit.gate.parts == []


def test_a_large_order_is_a_profile_and_nothing_else(visit):
    profile = json.dumps({"do": "profile", "values": {"text": "x,z\n" * 100_000}, "n": 5}, separators=(",", ":"))
    (order,) = visit.say(visit.patch(profile))
    assert order.do == "profile" and len(order.values["text"]) == 400_000
    assert visit.say(visit.patch(profile.replace("profile", "scene"))) == []
    assert visit.say(visit.patch(profile.replace("x,z", "x,z" + 30 * ","))) == []
    assert "2 MB" in json.loads(visit.session.wire.status)["errors"]["profile"]


@pytest.mark.parametrize(
    "text",
    [
        '{"do": "scene", "values": {"__class__": "1"}}',
        '{"do": "scene", "values": {"E": [1]}}',
        '{"do": "scene", "values": {"E": {"a": 1}}}',
        '{"do": "scene", "values": {"E": "' + "1" * 100 + '"}}',
        '{"do": "scene", "values": {"E": 80}, "from": [1, -5]}',
        '{"do": "scene", "values": {"E": 80}, "from": "11"}',
        '{"do": "scene", "values": {"E": 80}, "from": [1, 1e99]}',
        '{"do": "scene", "values": {"E": ' + "9" * 5000 + "}}",
        '{"do": "scene", "values": []}',
        '{"do": "preset", "values": {"preset": "fig99"}}',
        '{"do": "page", "values": {"page": ["law"]}}',
        '{"do": "ask", "values": {"half": "wide"}}',
        '{"do": "ask", "values": {"half": NaN}}',
        '{"do": "close"}',
        '{"do": ["hello"]}',
        '{"do": {}}',
        "[1]",
        "[" * 5000,
    ],
)
def test_orders_hold_known_names_short_texts_and_finite_numbers(text):
    with pytest.raises(orders.Refused):
        orders.read(text)


def test_a_mistake_of_the_program_is_logged_and_not_shown(session, caplog, monkeypatch):
    say(session, HELLO)
    monkeypatch.setattr(Session, "change", lambda *_: 1 / 0)
    say(session, '{"do":"scene","values":{"E":"80"}}')
    assert "ZeroDivisionError" in caplog.text and "Traceback" in caplog.text
    why = json.loads(session.wire.status)["why"]
    assert "its log" in why and "division" not in why and "Error" not in why


def test_a_run_goes_on_only_from_where_one_has_been():
    """A frame far beyond the run would keep a worker busy for ever."""

    class Doc:
        def add_next_tick_callback(self, call):
            call()

    visit = Session(Doc(), Pages, {}, NoPool(), Shelf())
    visit.hello()
    for after in ([1, 10**8], [7, 0], [1, 0]):
        say(visit, {"do": "scene", "values": {"delta_bar": 0.3 + 0.01 * after[0]}, "from": after})
        assert visit.run.history == ()
    visit.close()
