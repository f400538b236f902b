"""The routes of a really started server are those of app/routes.py, whatever Panel, Bokeh and options add."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from app.routes import FILES

ROOT = Path(__file__).parents[2]
# The commands of Panel and Bokeh build the server; where they would wait for visitors, this prints what was built.
LOOK = """
import json, sys
from bokeh.server.server import Server

def tell(self):
    (application,) = [rule.target for rule in self._tornado.default_router.rules]
    kept = [[rule.matcher.regex.pattern, rule.target.__module__] for rule in application.rules]
    print(json.dumps([kept, self._tornado.removed]), flush=True)
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
    """Return ([[pattern, module of the handler]], removed patterns) of a server that a command has built."""
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
def test_a_started_server_has_the_listed_routes_and_no_others(command, removed):
    kept, dropped = routes_of(*command.split())
    panel = [pattern for pattern, _ in kept if pattern.startswith("/static/extensions/panel/")]
    assert len(panel) == 1 and [tuple(each) for each in kept if each[0] != panel[0]] == SERVED
    assert dropped == removed
