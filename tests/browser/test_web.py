"""Security policy, refused connections and embedding, in a real browser."""

import http.server
import threading

import pytest
from served import Server, finished, from_menu, patient

pytestmark = pytest.mark.thorough


def test_a_full_class_admits_a_waiting_visitor_when_another_leaves(browser, monkeypatch):
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
def page(browser):
    """A tab that has seen nothing of the app."""
    opened = patient(browser.new_page())
    yield opened
    opened.close()


FORBIDDEN = """for (const name of ["localStorage", "sessionStorage"]) {
    Object.defineProperty(window, name, { get() { throw new DOMException("forbidden", "SecurityError") } })
}"""


@pytest.mark.parametrize("allowed", ["allow-scripts", "allow-scripts allow-same-origin"])
def test_a_sandboxed_frame_without_an_origin_says_what_to_do(server, page, allowed):
    outer = f"{server.origin}/outer"
    body = f'<iframe src="{server.address}?embed=1" sandbox="{allowed}" width="960" height="600"></iframe>'
    page.route(outer, lambda route: route.fulfill(body=body, content_type="text/html"))
    page.goto(outer)
    frame = page.frame_locator("iframe")
    if "same-origin" in allowed:
        frame.locator(".page:has(#scrub[aria-valuetext]) #punch-view").wait_for()
        assert frame.locator("#lost").is_hidden()
    else:
        frame.get_by_text("Add allow-same-origin to the sandbox attribute of the frame.").wait_for()
        assert frame.locator("#retry").is_hidden()


def test_page_works_in_a_browser_that_forbids_storage(server, page):
    problems = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.add_init_script(FORBIDDEN)
    page.goto(server.address)
    finished(page)
    page.locator("#stress").evaluate("(of) => { of.value = 'zz'; of.dispatchEvent(new Event('change')) }")
    page.keyboard.press("l")
    page.wait_for_function("document.getElementById('more').ariaPressed === 'true'")
    assert not problems


def test_page_explains_a_refused_websocket_and_shows_the_servers_reason(server, page):
    page.clock.install()
    page.route_web_socket("**/ws*", lambda socket: socket.close(code=1013))
    page.goto(server.address)
    page.clock.run_for(9_000)
    assert page.locator("#lost").is_hidden()
    page.clock.run_for(2_000)
    page.get_by_role("alert").filter(has_text="the websocket does not open").wait_for()
    page.route(server.address, lambda route: route.fulfill(status=503, body="The class is full"))
    page.get_by_role("button", name="Try now").click()
    page.get_by_text("The class is full").wait_for()


def test_page_names_a_script_that_failed_before_the_connection(server, page):
    page.clock.install()
    page.route("**/static/page.js*", lambda route: route.abort())
    with page.expect_event("requestfailed"):
        page.goto(server.address)
    page.clock.run_for(11_000)
    page.get_by_role("alert").filter(has_text="a script of the page failed").wait_for()


def test_a_script_on_demand_that_does_not_arrive_is_reported_with_a_remedy(server, page):
    page.route("**/static/later.js*", lambda route: route.abort())
    page.goto(server.address)
    finished(page)
    from_menu(page, "#tour")
    page.get_by_text("A part of the page did not arrive. Check the connection, then reload the page.").wait_for()


def test_a_page_refused_after_loading_is_replaced_by_the_reason(server, page):
    page.clock.install()
    page.route_web_socket("**/ws*", lambda socket: socket.close(code=1013))
    page.goto(server.address)
    page.route(server.address, lambda route: route.fulfill(status=503, body="The class is full"))
    page.clock.run_for(11_000)
    page.get_by_text("The class is full").wait_for()


@pytest.fixture
def elsewhere(server):
    """Address of a page on another origin that embeds the app in a frame."""

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


def test_other_sites_cannot_frame_the_app(page, elsewhere):
    said = []
    page.on("console", lambda message: said.append(message.text))
    with page.expect_event("console", lambda message: "frame-ancestors" in message.text):
        page.goto(f"{elsewhere}?embed=1")


def test_a_configured_site_can_frame_the_embedded_page(page, elsewhere, monkeypatch, server):
    monkeypatch.setenv("APP_FRAME_ANCESTORS", elsewhere.rstrip("/"))
    other = Server()
    other.wait_for("workers are warm")
    try:
        page.goto(f"{elsewhere}?embed=1")
        page.evaluate("address => { document.querySelector('iframe').src = address }", f"{other.address}?embed=1")
        frame = page.frame_locator("iframe")
        frame.locator(".punch canvas").first.wait_for(state="attached")
    finally:
        other.stop()
