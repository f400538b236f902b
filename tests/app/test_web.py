"""Answers to plain HTTP requests: page, files, headers, metrics, liveness, refusals."""

import asyncio
import gzip
import http.client
import json
import logging
import random
import re
import socket
import sys
import threading
import time
import urllib.error
import urllib.request
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.document import Document
from bokeh.server import server, urls
from bokeh.server.views.ws import WSHandler
from bokeh.util.token import get_token_payload
from panel.io.server import get_static_routes
from panel.io.state import set_curdoc
from prometheus_client import CollectorRegistry
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.testing import bind_unused_port
from tornado.websocket import websocket_connect
from visitor import waited

from app import assets, experiment, interface, page, routes, server_log, web
from app.service import metrics
from app.service.pool import Pool
from app.session import message_filter

LONG = {"unused_session_lifetime_milliseconds": 3_600_000}  # no test waits so long for the end of a session


def opened(doc):
    """A document with the page of a visitor."""
    with set_curdoc(doc):
        experiment.serve()
    return doc


@pytest.fixture(scope="module")
def address():
    """Of a server in this process, as app_hooks.py installs it."""
    before = urls.per_app_patterns[:], urls.toplevel_patterns[:], server.BokehTornado
    routes.install()
    pages = {"/app": Application(FunctionHandler(opened))}
    application = server.BokehTornado(pages, extra_patterns=get_static_routes({}), **LONG)  # as `panel serve` does
    urls.per_app_patterns[:], urls.toplevel_patterns[:], server.BokehTornado = before
    socket, port = bind_unused_port()
    ready, loops = threading.Event(), []

    async def serve():
        application.initialize(IOLoop.current())
        HTTPServer(application).add_socket(socket)
        loops.append(asyncio.get_running_loop())
        over.append(asyncio.Event())
        ready.set()
        await over[0].wait()

    over = []
    thread = threading.Thread(target=asyncio.run, args=(serve(),))
    thread.start()
    assert ready.wait(60)
    yield f"http://127.0.0.1:{port}"
    loops[0].call_soon_threadsafe(over[0].set)
    thread.join(60)


def get(address, **headers):
    """(status, headers, body) of an answer."""
    try:
        answer = urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=60)
    except urllib.error.HTTPError as error:
        answer = error
    with answer:
        return answer.status, answer.headers, answer.read()


def tokens(body):
    return re.search(rb'"token":"([^"]+)"', body)[1].decode()


def test_served_pages_differ_only_in_token_and_address_values(address):
    pages = [get(f"{address}/app?{query}")[2].decode() for query in ("E=80", "E=80", "E=90&delta_bar=0.3")]
    assert pages[0] != pages[1]
    known = [re.sub(r'nonce="[^"]+"|"token":"[^"]+"', "", text) for text in pages]
    assert known[0] == known[1] != known[2]
    assert 'id="E-entry" value="80"' in pages[0] and 'id="delta_bar-entry" value="0.3"' in pages[2]
    assert "@" not in re.sub(r"[\w.]+@[\w.]+", "", known[0].split("<body")[1].split("<script")[0])  # no mark is left


def test_token_holds_parameters_and_a_few_names_of_other_arguments(address):
    query = "?E=80&theme=dark&a=1&b=1&secret=" + 5000 * "x" + "&" + 500 * "y" + "=1"
    payload = get_token_payload(tokens(get(f"{address}/app{query}", Cookie="a=b")[2]))
    assert payload["arguments"] == {"E": [b"80"], "a": [], "b": [], "secret": []}
    assert payload["headers"] == payload["cookies"] == {}


def test_a_failed_document_shows_a_message(monkeypatch, caplog):
    monkeypatch.setattr(experiment, "Experiment", lambda **_: 1 / 0)
    doc = opened(Document())
    assert "could not be opened" in doc.roots[0].text and "ZeroDivisionError" in caplog.text


def test_a_failed_page_shows_a_message_without_internal_details(address, monkeypatch, caplog):
    monkeypatch.setattr(web, "shared", lambda _: 1 / 0)
    status, _, body = get(f"{address}/app")
    assert status == 500 and b"could not be opened" in body and b"division" not in body
    assert "ZeroDivisionError" in caplog.text


def test_a_full_class_answers_503_with_automatic_retry(address, monkeypatch):
    monkeypatch.setattr(message_filter, "connected", {"one", "two"})
    monkeypatch.setattr(message_filter, "VISITORS", 2)
    status, headers, body = get(f"{address}/app")
    assert status == 503 and headers["Retry-After"] == "10"
    assert b"class is full" in body and b'http-equiv="refresh" content="10"' in body


def test_plain_requests_do_not_count_as_visitors(address, monkeypatch):
    monkeypatch.setattr(message_filter, "VISITORS", 1)
    assert [get(f"{address}/app")[0] for _ in range(5)] == [200] * 5


@pytest.fixture
def own(monkeypatch):
    """A feature that has the pages at ?own= is there."""
    made = type("Own", (interface.Feature,), {"owns": staticmethod(lambda arguments: "own" in arguments)})
    features = interface.classes() | {"own": made}
    monkeypatch.setattr(interface, "classes", lambda: features)


@pytest.mark.usefixtures("own")
@pytest.mark.parametrize("query", ["", "?own=1"])
def test_requests_without_a_browser_bound_pages_of_features_and_keep_nobody_out_of_the_class(
    address, monkeypatch, query
):
    """Their sessions begin with the request; forty of them took 19 s of the loop of a class of five."""
    monkeypatch.setattr(message_filter, "VISITORS", 2)
    monkeypatch.setattr(message_filter, "connected", set())
    message_filter.opened.clear()
    found = [get(f"{address}/app{query}")[0] for _ in range(4)]
    assert found == ([200, 200, 503, 503] if query else [200] * 4)
    assert get(f"{address}/app")[0] == 200
    message_filter.opened.clear()  # as CONNECTS ends
    assert get(f"{address}/app?own=1")[0] == 200
    message_filter.opened.clear()


def test_a_too_long_address_is_answered_with_414(address):
    status, _, body = get(f"{address}/app?E=80&preset={random.Random(0).randbytes(3500).hex()}")  # not compressible
    assert status == 414 and b"address is too long" in body and b'href="./app"' in body


def logged(caplog, text):
    """Return the log records with a text once there is one: a request is logged after its answer."""
    until = time.monotonic() + 60.0
    while not (found := [each for each in caplog.records if text in each.getMessage()]) and time.monotonic() < until:
        time.sleep(0.01)
    return found


FOREIGN = "rebound.example:5006"


def test_a_page_under_a_foreign_host_name_explains_how_to_allow_it(address, monkeypatch, caplog):
    caplog.set_level(logging.INFO, "app")
    status, _, body = get(f"{address}/app", Host=FOREIGN)
    assert status == 403 and b"token" not in body
    (record,) = logged(caplog, f"the host {FOREIGN} was refused")
    assert all(f"--allow-websocket-origin={FOREIGN}" in text for text in (body.decode(), record.message))
    for allowed in (FOREIGN, "rebound.example"):
        monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", allowed)
        assert get(f"{address}/app", Host=FOREIGN)[0] == 200


@pytest.mark.parametrize("site", [{}, {"Sec-Fetch-Site": "same-origin"}])
def test_a_websocket_under_a_foreign_host_name_is_rejected_even_with_a_valid_token(address, monkeypatch, site):
    token = tokens(get(f"{address}/app")[2])

    def status(host, origin):
        headers = {"Host": host, "Origin": f"http://{origin}", "Sec-WebSocket-Protocol": f"bokeh, {token}"} | site
        return waited(connected(f"{address.replace('http', 'ws')}/app/ws", headers))

    assert status(FOREIGN, FOREIGN) == status("localhost:5006", FOREIGN) == 403
    monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", FOREIGN)
    assert status(FOREIGN, FOREIGN) == 101


async def connected(address, headers):
    """The status with which a server answers who asks for a websocket."""
    try:
        socket = await websocket_connect(HTTPRequest(address, headers=headers), subprotocols=["bokeh", "x"])
    except HTTPClientError as error:
        return error.code
    socket.close()
    return 101


@pytest.mark.parametrize("name", ["app", "app/static/style.css", "metrics", "liveness", "static/js/bokeh.min.js", "no"])
def test_no_route_answers_under_a_foreign_host_name(address, name, caplog):
    caplog.set_level(logging.INFO, "app")
    assert get(f"{address}/{name}", Host=FOREIGN)[0] == 403
    (record,) = logged(caplog, f"the host {FOREIGN} was refused")  # one line, with the address of the client
    assert (record.peer, record.status, record.path) == ("127.0.0.1", 403, f"/{name}")


def test_bokeh_is_not_asked_about_the_origin_of_its_own_page(address, monkeypatch):
    """When it is asked again, the check of hosts in `app/routes.py` may be unnecessary."""
    asked = []
    monkeypatch.setattr(WSHandler, "check_origin", lambda self, origin: not asked.append(origin))
    token, host = tokens(get(f"{address}/app")[2]), address.removeprefix("http://")
    headers = {"Host": host, "Origin": address, "Sec-WebSocket-Protocol": f"bokeh, {token}"}
    assert waited(connected(f"ws://{host}/app/ws", headers)) == 101
    assert asked == []


@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "PUT", "BREW"])
@pytest.mark.parametrize("name", ["", "app", "app/ws", "app/static/style.css", "metrics", "liveness", "components/x"])
def test_every_method_is_answered_without_the_name_of_the_server(address, method, name):
    asked = http.client.HTTPConnection(address.removeprefix("http://"), timeout=60)
    asked.request(method, f"/{name}")
    answer = asked.getresponse()
    body = answer.read()
    asked.close()
    assert answer.headers["Server"] is None
    if method == "HEAD" and name != "app/ws":
        asked.request("GET", f"/{name}")
        assert answer.status == asked.getresponse().status and not body
        asked.close()


def exchange(address, text):
    """Send bytes, and return what the server answers until it closes the connection."""
    host, port = address.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=60) as connection, suppress(ConnectionError):
        connection.sendall(text)
        return b"".join(iter(lambda: connection.recv(65536), b""))


@pytest.mark.parametrize("path", ["app", "app/static/style.css", "metrics", "nothing"])
@pytest.mark.parametrize("kind", ["Content-Length: 65537\r\n\r\n", "Transfer-Encoding: chunked\r\n\r\n11000\r\n"])
def test_a_long_body_is_refused_before_it_is_read(address, path, kind):
    answer = exchange(address, f"POST /{path} HTTP/1.1\r\nHost: localhost\r\n{kind}".encode())
    assert answer.startswith(b"HTTP/1.1 400 ") and b"Server" not in answer


def test_half_sent_bodies_and_headers_are_closed_after_a_time(address, monkeypatch):
    monkeypatch.setattr(routes, "BODY_TIME", 0.1)
    monkeypatch.setattr(routes, "IDLE", 0.1)
    assert exchange(address, b"POST /app HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\nx") == b""
    assert exchange(address, b"GET /app HT") == b""
    assert exchange(address, b"") == b""


@pytest.fixture
def one_place(monkeypatch, caplog):
    """Room for one visitor, who may be silent for 0.2 s."""
    caplog.set_level(logging.INFO, "app")
    monkeypatch.setattr(message_filter, "SILENT", 0.2)
    monkeypatch.setattr(message_filter, "VISITORS", 1)
    monkeypatch.setattr(message_filter, "connected", set())


@pytest.mark.usefixtures("one_place")
def test_a_silent_connection_does_not_keep_visitors_out(address, caplog):
    token = tokens(get(f"{address}/app")[2])

    async def close_code():
        headers = {"Host": "localhost", "Sec-WebSocket-Protocol": f"bokeh, {token}"}
        made = await websocket_connect(HTTPRequest(f"{address.replace('http', 'ws')}/app/ws", headers=headers))
        while await made.read_message() is not None:
            pass  # the server acknowledges the connection
        return made.close_code

    assert waited(close_code()) == message_filter.TRY_LATER
    assert get(f"{address}/app")[0] == 200
    (record,) = logged(caplog, "rejected")
    assert "TimeoutError" in record.message and record.peer == "127.0.0.1"


@pytest.mark.usefixtures("own")
@pytest.mark.parametrize("query", ["", "?own=1"])
def test_what_a_visitor_has_begun_ends_with_the_connection(address, caplog, query):
    """Workers computed on for him until Bokeh discarded his session."""
    caplog.set_level(logging.INFO, "app")
    token = tokens(get(f"{address}/app{query}")[2])

    async def visit():
        headers = {"Host": "localhost", "Sec-WebSocket-Protocol": f"bokeh, {token}"}
        made = await websocket_connect(HTTPRequest(f"{address.replace('http', 'ws')}/app/ws", headers=headers))
        await made.read_message()  # the server has a session by then
        made.close()

    waited(visit())
    assert logged(caplog, "visitor arrived") and logged(caplog, "visitor left")


@contextmanager
def deaf(address):
    """A connection of a browser that answers nothing from then on."""
    token, (host, port) = tokens(get(f"{address}/app")[2]), address.removeprefix("http://").split(":")
    lines = [
        "GET /app/ws HTTP/1.1",
        "Host: localhost",
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
        f"Sec-WebSocket-Protocol: bokeh, {token}",
    ]
    with socket.create_connection((host, int(port)), timeout=60) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        yield connection


def test_a_browser_that_sleeps_gives_up_its_place_and_one_that_answers_keeps_its_own(address, monkeypatch):
    """Its computer acknowledges what arrives, so that the connection stays open for hours."""
    monkeypatch.setattr(message_filter, "ALIVE", 0.5)
    monkeypatch.setattr(message_filter, "VISITORS", 2)
    monkeypatch.setattr(message_filter, "connected", set())
    token = tokens(get(f"{address}/app")[2])

    async def seen(sleeps):
        while b"bokeh" not in sleeps.recv(65536):  # it is connected
            pass
        headers = {"Host": "localhost", "Sec-WebSocket-Protocol": f"bokeh, {token}"}
        awake = await websocket_connect(HTTPRequest(f"{address.replace('http', 'ws')}/app/ws", headers=headers))
        for _part in range(3):  # of an acknowledgement: a browser reads all, or it could not answer
            await awake.read_message()
        found = [503]
        async with asyncio.timeout(60.0):
            while found[-1] == 503:
                found.append((await asyncio.to_thread(get, f"{address}/app"))[0])
        kept = len(message_filter.connected)
        awake.close()
        return found, kept

    with deaf(address) as sleeps:
        found, kept = waited(seen(sleeps))
    assert (found[1], found[-1], kept) == (503, 200, 1)


@pytest.mark.usefixtures("one_place")
def test_a_rejected_connection_gives_up_its_place_though_it_never_answers(address, caplog):
    with deaf(address) as connection:
        while b"\x88" not in connection.recv(65536):  # the frame that closes the connection
            pass
        assert get(f"{address}/app")[0] == 200
    assert logged(caplog, "rejected")


def test_a_page_that_was_opened_before_the_lesson_still_connects(address):
    payload = get_token_payload(tokens(get(f"{address}/app")[2]))
    assert payload["session_expiry"] - time.time() > 3500


def test_security_headers_restrict_sources_and_framing(address, monkeypatch):
    monkeypatch.setattr(web, "FRAMES", "https://school.example")
    monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", "contact.example:5006")
    for query, frames in (("", "'self'"), ("?embed=1", "https://school.example")):
        _, headers, body = get(f"{address}/app{query}", Host="contact.example:5006")
        rules = dict(rule.strip().split(" ", 1) for rule in headers["Content-Security-Policy"].split(";"))
        assert rules["default-src"] == "'none'" and rules["frame-ancestors"] == frames
        assert rules["connect-src"] == "'self' ws://contact.example:5006 wss://contact.example:5006 blob:"
        nonce = re.search(r"'nonce-([\w-]+)'", rules["script-src"])[1]
        assert "unsafe-inline" not in rules["script-src"]
        scripts = re.findall(rb"<script[^>]*>", body)
        assert len(scripts) > 3 and all(f'nonce="{nonce}"'.encode() in script for script in scripts)
        assert headers["X-Content-Type-Options"] == "nosniff" and headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cache-Control"] == "no-store"


def test_scripts_are_compressed_and_cached(address):
    body = get(f"{address}/app")[2].decode()
    found = re.findall(r'<(?:script|link)[^>]* (?:src|href)="\./([^"]+)"', body)
    assert len(found) >= 4
    for name in found:
        status, headers, packed = get(f"{address}/{name}", **{"Accept-Encoding": "gzip"})
        assert status == 200 and headers["Content-Encoding"] == "gzip" and "immutable" in headers["Cache-Control"]
        plain = get(f"{address}/{name}")
        assert "Content-Encoding" not in plain[1] and gzip.decompress(packed) == plain[2]
        assert get(f"{address}/{name}", **{"If-None-Match": headers["Etag"]})[0] == 304
    for name in ("app/static/all.css", f"app/{'0' * 16}/static/all.css", "static/js/bokeh.min.js?v=anything"):
        assert get(f"{address}/{name}")[1]["Cache-Control"] == "no-cache"  # without the version, or of another one


def test_a_page_loads_one_script_and_one_style(address):
    body = get(f"{address}/app")[2].decode()
    assert re.findall(r'rel="(?:modulepreload|stylesheet)" href="\./app/\w{16}/([^"]+)"', body) == [
        "static/all.css",
        "static/page.js",
    ]
    assert b"importmap" not in body.encode()


def test_the_version_of_the_files_changes_with_any_of_them(monkeypatch, tmp_path):
    monkeypatch.setattr(assets, "HERE", tmp_path)
    monkeypatch.setattr(assets, "STATIC", tmp_path / "static")
    monkeypatch.setattr(assets, "files", assets.files.__wrapped__)
    script = tmp_path / "static" / "js" / "a.js"
    script.parent.mkdir(parents=True)
    seen = set()
    for text in ("one", "other"):
        script.write_text(text, encoding="utf-8")
        assets.content.cache_clear()
        seen.add(assets.version.__wrapped__())
    assert len(seen) == 2


def test_a_file_is_answered_without_a_look_into_any_folder(address):
    name = re.search(r'src="\./(app/[^"]+opening\.js)"', get(f"{address}/app")[2].decode())[1]
    looks, looking = [], True
    sys.addaudithook(lambda event, _: looking and event in ("os.scandir", "os.listdir") and looks.append(event))
    assert get(f"{address}/{name}")[0] == 200
    looking = False
    assert not looks


@pytest.mark.parametrize(
    "name", ["../main.py", "%2e%2e/main.py", "", "js", "%00", "js/%00.js", 300 * "x", "%ff"], ids=lambda name: name[:20]
)
def test_names_that_are_no_static_file_are_answered_without_a_traceback(address, name, caplog):
    assert get(f"{address}/app/static/{name}")[0] in (400, 404)
    assert "Traceback" not in caplog.text and "ncaught" not in caplog.text


def test_no_request_imports_a_module(address):
    assert get(f"{address}/components/this/a/b/c")[0] == 404
    assert "this" not in sys.modules


@pytest.mark.parametrize(
    "name",
    [
        *("app/autoload.js?bokeh-autoload-element=1", "app/metadata", "rest/params", "admin", "login", "favicon.ico"),
        *("static/", "static/js/", "static/js/types.js", "static/js/bokeh/x", "static/css/bokeh.css"),
        *("static/js/bokeh../../../__init__.py", "static/extensions/", "static/extensions/panel/panel.json"),
        *("static/extensions/panel/../widgets/base.py", "static/extensions/panel/bundled/theme/../../../a.js"),
        *("static/extensions/panel/panel.js.map", "static/extensions/panel/bundled/plotlyplot/plotly-3.1.0.min.js"),
        "static/extensions/panel/bundled/bootstrap5/css/bootstrap.min.css",
    ],
)
def test_routes_that_are_not_listed_do_not_exist(address, name):
    assert get(f"{address}/{name}")[0] == 404


def test_files_of_plain_panel_pages_are_served(address):
    names = ["panel.min.js", "css/button.css", "bundled/theme/default.css", "bundled/theme/native.css"]
    names += ["bundled/reactiveesm/es-module-shims@%5E1.10.0/dist/es-module-shims.min.js"]
    names += ["bundled/theme/dark.css", "css/dataframe.css"]
    found = [get(f"{address}/static/extensions/panel/{name}")[0] for name in names]
    found += [
        get(f"{address}/static/js/bokeh{name}.min.js")[0] for name in ("", "-gl", "-mathjax", "-tables", "-widgets")
    ]
    assert set(found) == {200}


@pytest.mark.parametrize(("path", "to"), [("/", "./app"), ("/app/?E=80", "../app?E=80")])
def test_root_and_trailing_slash_are_redirected_by_a_relative_address(address, path, to):
    asked = http.client.HTTPConnection(address.removeprefix("http://"), timeout=60)
    asked.request("GET", path)
    assert asked.getresponse().headers["Location"] == to  # a proxy may have taken a prefix away
    asked.close()


def test_metrics_have_the_prometheus_format(address):
    before = metrics.counted("pages")
    get(f"{address}/app")
    status, headers, body = get(f"{address}/metrics")
    assert status == 200 and headers["Content-Type"].startswith("text/plain; version=0.0.4")
    lines = body.decode().splitlines()
    line_of = re.compile(r'# (HELP|TYPE) contact_\w+ .+|contact_\w+(\{\w+=".+"\})? ([-+.\de]+|nan)')
    assert all(map(line_of.fullmatch, lines))
    values = dict(line.rsplit(" ", 1) for line in lines if not line.startswith("#"))
    assert float(values["contact_pages_total"]) == before + 1 and float(values["contact_memory_bytes"]) > 1e7


def test_event_loop_lag_is_counted_once_however_often_it_is_read(monkeypatch):
    now, registry = [0.0], CollectorRegistry()
    loop_lag = metrics.LoopLag(registry)
    monkeypatch.setattr(metrics, "monotonic", lambda: now[0])
    for step in (0.05, 0.05, 0.35, 0.06):
        now[0] += step
        loop_lag.record()
    for _ in range(2):
        late = {
            edge: registry.get_sample_value("contact_loop_lag_seconds_bucket", {"le": edge}) for edge in ("0.2", "0.5")
        }
        assert late == {"0.2": 2.0, "0.5": 3.0}
        assert registry.get_sample_value("contact_loop_lag_seconds_sum") == pytest.approx(0.31)


def test_liveness_reflects_the_workers(address, monkeypatch):
    quiet = Pool(size=1)
    monkeypatch.setattr(web, "pool", quiet)
    status, _, body = get(f"{address}/liveness")
    assert status == 503 and "no worker has answered" in json.loads(body)["why"]
    quiet.start()  # from now on it is warming up
    assert get(f"{address}/liveness")[0] == 200
    quiet.close()


def test_log_records_are_one_line_of_keys_and_values():
    record = logging.makeLogRecord({"name": "app", "levelname": "INFO", "msg": "a %s came", "args": ("visitor",)})
    record.visitors, record.why = 3, 'two\nlines, "quoted"'
    line = server_log.Lines().format(record)
    assert re.match(r'time=\d{4}-\d\d-\d\dT[\d:.]+ level=info event="a visitor came" visitors=3 why=', line)
    assert json.loads(line.split("why=")[1]) == record.why and "\n" not in line
    try:
        raise ValueError("wrong")
    except ValueError as error:
        record.exc_info = (type(error), error, error.__traceback__)
    assert "\n" not in server_log.Lines().format(record) and "ValueError: wrong" in server_log.Lines().format(record)


def test_log_shows_the_address_for_a_class(monkeypatch, caplog):
    caplog.set_level(logging.INFO, "app")
    monkeypatch.chdir(Path(page.__file__).parents[1])
    monkeypatch.setattr(server_log, "addresses", lambda: ["192.0.2.7"])
    monkeypatch.delenv("BOKEH_ALLOW_WS_ORIGIN", raising=False)
    server_log.log_addresses(["serve", "app", "--port", "5007"])
    command = "panel serve app --address 0.0.0.0 --port 5007 --allow-websocket-origin 192.0.2.7:5007"
    assert caplog.messages[-1] == f"for a class at http://192.0.2.7:5007/app start it by: {command}"
    monkeypatch.chdir("/")  # no folder of a clone
    server_log.log_addresses(["serve", "site-packages/app"])
    assert "start it by: mixed-mode-contact serve --address 0.0.0.0 --port 5006" in caplog.messages[-1]
    server_log.log_addresses(["serve", "app", "--port=5007", "--allow-websocket-origin", "192.0.2.7:5007"])
    assert caplog.messages[-1] == "visitors open http://192.0.2.7:5007/app"
    monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", "contact.example")
    server_log.log_addresses(["serve", "app"])
    assert caplog.messages[-1] == "visitors open http://contact.example/app"
    server_log.log_addresses(["serve", "app", "--use-xheaders", "--prefix", "/lab/"])
    assert caplog.messages[-1] == "visitors open https://contact.example/lab/app"


def test_the_page_shares_the_port_that_is_bound(monkeypatch):
    monkeypatch.setattr(server_log, "addresses", lambda: ["192.0.2.7"])
    monkeypatch.setattr(server_log, "_bound", {})
    monkeypatch.setattr(sys, "orig_argv", ["panel", "serve", "app", "--port", "0", "--allow-websocket-origin=*"])
    server_log.bound("http://127.0.0.1:4321/")
    assert page.values("")["declarations"]["reach"]["origins"] == ["http://192.0.2.7:4321"]


@pytest.mark.parametrize("host", ["localhost:5006", "127.0.0.1", "contact.example:443"])
def test_the_policy_names_the_host_of_the_websocket(host):
    assert f"connect-src 'self' ws://{host} wss://{host} blob:;" in web.policy(host, "n", "'self'")


def test_the_policy_leaves_out_an_ipv6_address_which_no_policy_can_name():
    """Browsers report it as invalid; 'self' covers the websocket there."""
    assert "connect-src 'self' blob:;" in web.policy("[::1]:5006", "n", "'self'")


def test_reach_names_no_origin_that_only_this_computer_opens(monkeypatch):
    monkeypatch.setattr(server_log, "addresses", lambda: ["192.0.2.7"])
    monkeypatch.delenv("BOKEH_ALLOW_WS_ORIGIN", raising=False)
    for host in ("localhost:5006", "127.0.0.1:5006", "[::1]:5006"):
        reached = server_log.reach(["serve", "app", "--allow-websocket-origin", host])
        assert reached.origins == [] and len(reached.commands) == 1
    assert server_log.reach(["serve", "app", "--allow-websocket-origin=*"]).origins == ["http://192.0.2.7:5006"]
    named = server_log.reach([f"--allow-websocket-origin={host}" for host in ("localhost:5006", "a.b")])
    assert named.origins == ["http://a.b"] and named.commands == []
