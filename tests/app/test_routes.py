"""The routes of a really started server are those of app/routes.py, whatever Panel, Bokeh and options add."""

import contextlib
import http.client
import json
import re
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from visitor import waited

from app.routes import FILES

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "load"))  # of a Tab
# The commands of Panel and Bokeh build the server; where they would wait for visitors, this prints what was built.
LOOK = """
import json, sys
from bokeh.server.server import Server

def tell(self):
    (application,) = [rule.target for rule in self._tornado.default_router.rules]
    kept = [[rule.matcher.regex.pattern, rule.target.__module__] for rule in application.rules]
    print(json.dumps([kept, self._tornado.removed, "holoviews" in sys.modules]), flush=True)
    sys.exit()

Server.run_until_shutdown = tell
command = sys.argv.pop(1)
if command == "panel":
    from panel.command import main
else:
    from bokeh.command.bootstrap import main
main([command, *sys.argv[1:]])
"""
SERVED = [
    ("/app/?$", "app.web"),
    ("/app/ws$", "app.session.message_filter"),
    *((f"/app{route}$", "app.web") for route, _ in FILES),
    ("/?$", "app.web"),
    ("/metrics$", "app.web"),
    ("/liveness$", "app.web"),
    (r"/static/(js/bokeh[\w.-]*\.js)$", "app.web"),
]
# What Bokeh and Panel add beside their lists of patterns. If this changes, see what the new route does.
BOKEH = ["/favicon.ico$", "/app/static/(.*)$"]
PANEL = [*BOKEH, "/components/(.*)$"]
OPTIONS = "--liveness --admin --basic-auth secret --cookie-secret secret --static-dirs tests=tests"
ADMIN = [f"/admin{route}$" for route in ("/?", "/ws", *(route for route, _ in FILES))]


def routes_of(*command):
    """Return ([[pattern, module of the handler]], removed patterns, whether HoloViews is there) of a built server."""
    run = [sys.executable, "-c", LOOK, *command, "--port", "0", "--address", "127.0.0.1"]
    ended = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout.splitlines()[-1])


@pytest.mark.slow
@pytest.mark.once
@pytest.mark.parametrize(
    ("command", "removed"),
    [
        ("panel serve app", PANEL),
        ("bokeh serve app", BOKEH),
        (
            f"panel serve app {OPTIONS}",
            [*BOKEH, "/tests/(.*)$", PANEL[-1], "/liveness$", *ADMIN, "/login$", "/logout$"],
        ),
    ],
)
def test_a_started_server_has_the_listed_routes_and_no_others_nor_holoviews_which_no_visitor_reaches(command, removed):
    kept, dropped, plots = routes_of(*command.split())
    panel = [pattern for pattern, _ in kept if pattern.startswith("/static/extensions/panel/")]
    assert len(panel) == 1 and [tuple(each) for each in kept if each[0] != panel[0]] == SERVED
    assert dropped == removed and not plots


@contextlib.contextmanager
def started(served, *options):
    """(the process of `panel serve`, an iterator over the lines of its log)."""
    panel = Path(sys.executable).parent / "panel"
    command = [panel, "serve", served, "--port", "0", "--address", "127.0.0.1", *options]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as server:
        try:
            yield server, iter(server.stdout)
        finally:
            server.kill()


@pytest.mark.slow
def test_a_server_of_the_file_alone_ends_with_a_sentence_at_the_first_visit():
    """It has run no hooks, so that routes of Panel are open, one of which imports what a visitor names."""
    with started("app/main.py") as (server, lines):
        address = next(line for line in lines if "running at" in line).split()[-1]
        with contextlib.suppress(OSError, http.client.HTTPException):
            urllib.request.urlopen(address, timeout=120)
        assert server.wait(120) != 0
        assert "Serve the folder: panel serve app" in "".join(lines)


@pytest.mark.slow
def test_a_folder_beside_another_installed_version_is_not_served(tmp_path, monkeypatch):
    """Its pages would be those of the other version."""
    other = tmp_path / "app"
    other.mkdir()
    (other / "__init__.py").write_text("")  # whatever else it holds, it is another one
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with started("app") as (server, lines):
        said = "".join(lines)
        assert server.wait(120) != 0
    assert f"another version is installed: {other}. Install this one: pip install -e {ROOT}" in said
    assert "Traceback" not in said


NO_CLASS = (
    "Class ABCD cannot open: this server has several processes, and each would have its own class ABCD."
    " Start it without --num-procs."
)


async def notes_of_class(port):
    """What a visitor reads who opens the page of a class."""
    from client import Tab  # here: its folder is on the path by now

    tab = Tab(port, 0)
    await tab.arrive("?class=ABCD")
    for order in ({"do": "hello"}, {"do": "join", "code": "ABCD", "secret": "mine"}):
        await tab.give(order)
    while not tab.status.get("notes"):
        await tab.heard()
    tab.leave()
    return " ".join(tab.status["notes"])


@pytest.mark.slow
def test_servers_of_num_procs_name_the_port_the_system_has_chosen_open_no_class_and_end_with_their_parent():
    """They share the pipe of the log with it, which has an end only when all of them have ended."""
    count = 1 if sys.platform == "win32" else 2  # --num-procs needs a fork
    with started("app", "--num-procs", f"{count}", "--allow-websocket-origin=*") as (server, lines):
        told = {"running at": [], "visitors open": []}
        while min(map(len, told.values())) < count:
            line = next(lines)
            for words in (words for words in told if words in line):
                told[words].append(re.search(r":(\d+)/app", line)[1])
        (port,) = {*told["running at"], *told["visitors open"]}  # a class reads the second
        assert port != "0"
        if count > 1:
            assert {waited(notes_of_class(int(port))) for _ in range(6)} == {NO_CLASS}  # whichever process answers
            server.terminate()
            assert sum("the server is being stopped" in line for line in lines) == 2
