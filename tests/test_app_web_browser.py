"""The page under its own policy in a real browser: nothing is blocked that it needs, frames only where allowed."""

import http.server
import threading

import pytest
from served import PATIENCE, Server, finished, patient

pytestmark = [pytest.mark.browser, pytest.mark.thorough]


@pytest.mark.thorough
def test_enter_in_an_entry_changes_the_scene_and_leaves_the_page_as_it_is(visit):
    page = visit()
    finished(page)
    page.evaluate("window.same = true")
    page.locator("#E-entry").fill("80")
    page.locator("#E-entry").press("Enter")
    finished(page, run=2)
    assert page.evaluate("window.same && punch.status.values.E") == 80


@pytest.mark.thorough
def test_a_full_class_lets_in_who_waits(browser, monkeypatch):
    monkeypatch.setenv("APP_VISITORS", "1")
    full = Server()
    full.wait_for("workers are warm")
    try:
        context = browser.new_context()
        first, second = patient(context.new_page()), patient(context.new_page())
        first.goto(full.address)
        finished(first)
        second.goto(full.address)
        assert "class is full" in second.inner_text("body")
        first.close()
        finished(second)  # it has tried again by itself
        context.close()
    finally:
        full.stop()


@pytest.fixture
def elsewhere(server):
    """Address of a page on another origin that shows the app in a frame."""

    class Frame(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(f'<iframe src="{server.address}{self.path[1:]}"></iframe>'.encode())

        def log_message(self, *_):
            pass

    site = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Frame)
    threading.Thread(target=site.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{site.server_port}/"
    site.shutdown()


def test_another_site_may_not_frame_the_app_unless_it_was_named(browser, elsewhere):
    page = patient(browser.new_page())
    said = []
    page.on("console", lambda message: said.append(message.text))
    with page.expect_event("console", lambda message: "frame-ancestors" in message.text, timeout=PATIENCE):
        page.goto(f"{elsewhere}?embed=1")
    page.close()


@pytest.mark.thorough
def test_a_site_that_was_named_may_frame_what_is_to_be_embedded(browser, elsewhere, monkeypatch, server):
    monkeypatch.setenv("APP_FRAME_ANCESTORS", elsewhere.rstrip("/"))
    other = Server()
    other.wait_for("workers are warm")
    try:
        page = patient(browser.new_page())
        page.goto(f"{elsewhere}?embed=1")
        page.evaluate("address => { document.querySelector('iframe').src = address }", f"{other.address}?embed=1")
        frame = page.frame_locator("iframe")
        frame.locator("#punch-view canvas").first.wait_for(state="attached", timeout=PATIENCE)
        page.close()
    finally:
        other.stop()
