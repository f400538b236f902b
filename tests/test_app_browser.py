"""The app as a visitor meets it: the README's command, a real Chromium, keys and mouse; no error, nothing fetched."""

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
    """`panel serve app` on a free port, with what it logs."""

    def __init__(self):
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
            [*command, *quick], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.lines, self.news = [], threading.Condition()
        threading.Thread(target=self._listen, daemon=True).start()
        self.address = f"http://localhost:{self.port}/app"

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
        self.process.send_signal(signal.SIGINT)
        self.process.wait(30)


@pytest.fixture(scope="module")
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


def drawn(page, view, part):
    """How many points of a curve are in the Bokeh figure."""
    models = "[...Bokeh.documents[0]._all_models.values()]"
    return page.evaluate(f"{models}.find((model) => model.name === '{view}.{part}').data_source.data.value.length")


def test_the_curves_grow_while_the_worker_computes(visit):
    page = visit("?E=20&delta_bar=0.3")  # soft: several slices, however fast the machine
    page.wait_for_function("() => window.punch?.run", timeout=PATIENCE)
    grown = page.evaluate(
        """() => new Promise((resolve) => {
            const lengths = new Set()
            const look = () => {
                lengths.add(punch.run.shear("U_x").length)
                punch.status.state === "finished" ? resolve([...lengths]) : setTimeout(look, 1)
            }
            look()
        })"""
    )
    finished(page)
    assert grown == sorted(grown)
    assert any(0 < length < 401 for length in grown)  # seen in the making, not only whole
    assert drawn(page, "forces", "F") == drawn(page, "forces", "L") == drawn(page, "area", "A") == 401
    assert "all increments converged" in page.inner_text("#status")


def test_a_slider_moved_by_keyboard_changes_the_curve_and_leaves_a_ghost(visit):
    page = visit()
    finished(page)
    before = page.evaluate("[...punch.run.shear('F')]")
    page.get_by_role("slider", name="Indentation").focus()
    page.keyboard.press("ArrowRight")
    finished(page, run=2)
    assert page.evaluate("punch.status.values.delta_bar") == 0.01
    assert page.evaluate("[...punch.run.shear('F')]") != before
    assert page.evaluate("[...punch.ghost.shear('F')]") == before
    assert drawn(page, "forces", "ghost_F") == len(before)
    assert "delta_bar=0.01" in page.url
    assert page.input_value("#delta_bar-entry") == "0.01"


def test_dragging_on_never_queues_and_ends_at_the_last_position(visit):
    page = visit()
    finished(page)
    page.focus("#delta_bar")
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("punch.status.values.delta_bar === 0.12", timeout=PATIENCE)
    finished(page, run=2)
    assert page.evaluate("punch.run.values(punch.run.length - 1).delta") == pytest.approx(1.2)
    assert page.evaluate("punch.status.run") <= 13


def test_play_pause_step_and_reset(visit):
    page = visit()
    finished(page)
    page.wait_for_function("punch.drawn > punch.run.sheared + 3")  # it plays by itself
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function("document.getElementById('status').textContent.includes('paused')")
    at = page.evaluate("Math.floor(punch.at)")
    page.get_by_role("button", name="Step forward").click()
    assert page.evaluate("punch.drawn") == at + 1
    page.get_by_role("button", name="Step back").click()
    assert page.evaluate("punch.drawn") == at
    page.locator("body").press("Shift+ArrowRight")
    assert page.evaluate("punch.drawn") == at + 10
    page.locator("body").press("Home")
    assert page.inner_text("#readout").startswith("approach 0")
    page.locator("body").press("End")
    assert "40.0 nm" in page.inner_text("#readout")
    page.locator("body").press("Space")
    page.wait_for_function("punch.playing")
    page.focus("#phi_ratio")
    page.keyboard.press("ArrowLeft")
    finished(page, run=2)
    page.get_by_role("button", name="Reset").click()
    finished(page, run=3)
    assert page.evaluate("punch.status.values") == {"delta_bar": 0, "phi_ratio": 1, "E": 70}
    assert page.evaluate("punch.ghost") is None
    assert drawn(page, "forces", "ghost_F") == 0


def test_hovering_and_clicking_a_curve_moves_every_view(visit):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Pause").click()
    at = page.evaluate("punch.drawn")
    box = page.locator("figure[aria-label^='Friction'] .view").bounding_box()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.4 * box["height"])
    page.wait_for_function(f"punch.drawn > {at} + 50")
    page.mouse.move(5, 5)
    page.wait_for_function(f"punch.drawn === {at}")
    page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 0.4 * box["height"])
    page.mouse.move(5, 5)
    page.wait_for_function(f"punch.at > {at} + 50 && punch.preview === null")


def test_a_bad_entry_is_explained_and_the_run_stays(visit):
    page = visit()
    finished(page)
    for text, said in (("7000", "out of range"), ("stiff", "not a number"), ("nan", "out of range")):
        page.fill("#E-entry", text)
        page.keyboard.press("Enter")
        page.wait_for_function(f"document.getElementById('E-error').textContent.includes('{said}')")
        assert "10 to 1000" in page.inner_text("#E-error")
    assert page.evaluate("punch.run.number") == 1
    page.fill("#E-entry", "73.5")
    page.keyboard.press("Enter")
    finished(page, run=2)
    assert page.locator("#E-error").is_hidden()


def test_the_address_holds_the_state_and_bad_values_give_a_note(visit):
    page = visit("?delta_bar=0.4&phi_ratio=lots&E=200&theme=dark")
    finished(page)
    assert page.evaluate("punch.status.values") == {"delta_bar": 0.4, "phi_ratio": 1, "E": 200}
    assert "phi_ratio" in page.inner_text("#notes") and "0.05 to 2" in page.inner_text("#notes")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


def test_the_theme_follows_the_browser_and_switches_without_losing_the_run(visit):
    page = visit(color_scheme="dark")
    finished(page)
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.get_by_role("button", name="Switch between light and dark").click()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.evaluate("punch.run.number") == 1


@pytest.mark.parametrize("size", [(1440, 900), (1280, 720), (390, 844)])
def test_nothing_is_cut_off_sideways_and_what_matters_is_above_the_fold(visit, size):
    page = visit()
    page.set_viewport_size({"width": size[0], "height": size[1]})
    finished(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    for part in ("#status", "#delta_bar", "#phi_ratio", "#E", "#play", "figure >> nth=0"):
        box = page.locator(part).bounding_box()
        assert box["y"] >= 0 and box["y"] + min(box["height"], 100) <= size[1], part


def test_closing_the_tab_frees_what_it_held(server, browser):
    seen = len(server.lines)
    page = browser.new_page()
    page.goto(server.address)
    finished(page)
    page.close()
    assert "now 0, slices in flight 0" in server.wait_for("visitor left, now 0", since=seen)


def test_stopping_the_server_ends_its_workers(chromium):
    running = Server()
    running.wait_for("workers are warm")
    urllib.request.urlopen(running.address).read()
    children = Path(f"/proc/{running.process.pid}/task/{running.process.pid}/children")
    if not children.exists():
        running.stop()
        pytest.skip("this system does not list the children of a process in /proc")
    workers = children.read_text().split()
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
