"""The app served by the README's command: fixtures for tests in a real Chromium; what a server frees and ends."""

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import pytest

pytestmark = pytest.mark.browser
ROOT = Path(__file__).parent.parent
PATIENCE = 120_000  # ms; a limit against hanging, not a claim about speed
TROUBLE = re.compile(r"error|exception|traceback|critical", re.IGNORECASE)
FINISHED = "() => window.punch?.status.state === 'finished' && !punch.fresh && punch.run.length === punch.status.frames"


class Server:
    """`panel serve app` on a free port, or a given one, with what it logs."""

    def __init__(self, prefix="", port=None):
        self.port = port
        if port is None:
            with socket.socket() as probe:
                probe.bind(("127.0.0.1", 0))
                self.port = probe.getsockname()[1]
        command = [Path(sys.executable).parent / "panel", "serve", "app", "--port", str(self.port)]
        quick = [
            "--unused-session-lifetime",
            "1000",
            "--check-unused-sessions",
            "500",
        ]  # ms, closed tabs
        self.process = subprocess.Popen(
            [*command, *quick, "--prefix", prefix],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.lines, self.news = [], threading.Condition()
        threading.Thread(target=self._listen, daemon=True).start()
        self.address = f"http://localhost:{self.port}{prefix}/app"

    def _listen(self):
        for line in self.process.stdout:
            with self.news:
                self.lines.append(line)
                self.news.notify_all()

    def wait_for(self, pattern, since=0):
        """The first logged line from number `since` on that matches."""
        with self.news:
            found = self.news.wait_for(
                lambda: next(filter(re.compile(pattern).search, self.lines[since:]), None), PATIENCE / 1000
            )
        assert found, f"the server never logged {pattern!r}:\n{''.join(self.lines)}"
        return found

    def stop(self):
        self.process.send_signal(signal.SIGTERM)  # as process managers do; background jobs do not hear SIGINT
        self.process.wait(PATIENCE / 1000)


@pytest.fixture(scope="session")
def server(chromium):
    running = Server()
    running.wait_for("workers are warm")
    yield running
    running.stop()
    trouble = [line for line in running.lines if TROUBLE.search(line)]
    assert not trouble, "".join(running.lines)


@pytest.fixture
def visit(server, browser):
    """Open the app in a tab of its own; at the end nothing may have gone wrong or been asked from elsewhere."""
    contexts, problems, asked = [], [], []

    def opened(query="", **options):
        context = browser.new_context(viewport={"width": 1280, "height": 720}, **options)
        contexts.append(context)
        context.set_default_timeout(PATIENCE)
        page = context.new_page()
        page.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(server.address + query)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not problems
    outside = [url for url in asked if not re.match(rf"(http|ws)://localhost:{server.port}/|data:|blob:", url)]
    assert not outside


def finished(page, run=1):
    page.wait_for_function(FINISHED, timeout=PATIENCE)
    page.wait_for_function(f"punch.status.run >= {run}", timeout=PATIENCE)
    page.wait_for_function(FINISHED, timeout=PATIENCE)


def test_closing_the_tab_frees_what_it_held(server, browser):
    seen = len(server.lines)
    page = browser.new_page()
    page.goto(server.address)
    finished(page)
    page.close()
    assert "now 0, slices in flight 0" in server.wait_for("visitor left, now 0", since=seen)


def test_behind_a_prefix_scripts_and_styles_are_found_and_fetched_once(browser):
    behind = Server("/lab/contact")
    behind.wait_for("workers are warm")
    context = browser.new_context()
    paid = []
    for _ in range(2):
        page = context.new_page()
        page.goto(behind.address)
        finished(page)
        entries = "performance.getEntriesByType('resource').map(({ name, transferSize }) => [name, transferSize])"
        files = {name: size for name, size in page.evaluate(entries) if "/app/static/" in name}
        assert {name.rsplit("/", 1)[1].split("?v=")[0] for name in files} >= {"style.css", "main.js", "solid.js"}
        assert all(f"{behind.address}/static/" in name and "?v=" in name for name in files)
        paid.append(sum(files.values()))
        page.close()
    context.close()
    behind.process.kill()  # workers go with their server
    behind.process.wait(PATIENCE / 1000)
    assert paid[0] > 0 == paid[1]


def test_stopping_the_server_ends_its_workers(chromium):
    running = Server()
    running.wait_for("workers are warm")
    urllib.request.urlopen(running.address).read()
    children = list(Path(f"/proc/{running.process.pid}/task").glob("*/children"))  # of each of its threads
    if not children:
        running.stop()
        pytest.skip("this system does not list the children of a process in /proc")
    workers = " ".join(path.read_text() for path in children).split()
    assert workers
    running.stop()
    deadline = time.monotonic() + PATIENCE / 1000
    while any(map(alive, workers)):
        assert time.monotonic() < deadline, "workers outlived their server"
        os.sched_yield()


def alive(pid):
    """Whether a process still runs; one that only waits to be collected does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
