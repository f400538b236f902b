"""The server: sessions freed, workers ended, and serving under a prefix."""

import os
import re
import time
import urllib.request
from pathlib import Path

import pytest
from served import PATIENCE, Server, finished, patient


def test_closing_a_tab_frees_its_session(server, browser):
    seen = len(server.lines)
    page = patient(browser.new_page())
    page.goto(server.address)
    finished(page)
    page.close()
    visitors = int(re.search(r"arrived, now (\d+)", server.wait_for("visitor arrived", since=seen))[1])
    server.wait_for(f"visitor left, now {visitors - 1},", since=seen)


@pytest.mark.thorough
def test_scripts_and_styles_load_under_a_prefix_and_are_cached(browser):
    behind = Server("/lab/contact")
    behind.wait_for("workers are warm")
    context = browser.new_context()
    paid = []
    for _ in range(2):
        page = patient(context.new_page())
        page.goto(behind.address)
        finished(page)
        entries = "performance.getEntriesByType('resource').map(({ name, transferSize }) => [name, transferSize])"
        files = {name: size for name, size in page.evaluate(entries) if "/app/" in name}
        assert {name.rsplit("/", 1)[1] for name in files} >= {"all.css", "page.js", "opening.js"}
        assert all(re.match(rf"{behind.address}/\w{{16}}/(static|features)/", name) for name in files)
        paid.append({name for name, size in files.items() if size > 0})
        page.close()
    context.close()
    behind.process.kill()  # workers go with their server
    behind.process.wait(PATIENCE / 1000)
    assert paid[0] and not paid[0] & paid[1]  # what is fetched late may come with the second page only


@pytest.mark.thorough
def test_stopping_the_server_ends_its_workers(chromium):
    running = Server()
    running.wait_for("workers are warm")
    urllib.request.urlopen(running.address).read()
    helpers = children(running.process.pid)
    workers = [*helpers, *(pid for helper in helpers for pid in children(helper))]
    running.stop()
    if not workers:
        pytest.skip("this system does not list the children of a process in /proc")
    assert len(workers) > len(helpers)
    deadline = time.monotonic() + PATIENCE / 1000
    while any(map(alive, workers)):
        assert time.monotonic() < deadline, "workers outlived their server"
        os.sched_yield()


def children(pid):
    """Of each of its threads."""
    return [child for path in Path(f"/proc/{pid}/task").glob("*/children") for child in path.read_text().split()]


def alive(pid):
    """Whether a process still runs; one that only waits to be collected does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
