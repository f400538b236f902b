"""Stored runs: they match the solver, and a page shows one until the computed run arrives."""

import base64

import blocks
import numpy as np
import pytest
from served import PATIENCE, PLAYING, Server, finished, paused_at
from tabs import Tabs

from app.features.stored import store as stored
from app.service import packing, worker

CURVES = 1e-3  # of the largest value: processors differ in round-off, and slips amplify it
FIELDS = 0.025  # of the largest value: two runs that each err by 2 packing.FINE, with roundings
SIDED = 3  # frames, with those beside it between which a run is interpolated
NOBODY = "tcp://127.0.0.1:9"  # the port "discard": no scheduler, thus no worker
COMPARE = """async (texts) => {
    const { unpackLater } = await import("http://scripts/static/js/packed.js")
    const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer
    const [one, other] = await Promise.all(texts.map((text) => unpackLater({ body: bytes(text) })))
    const apart = (a, b) => a.length === b.length && a.reduce((most, v, i) => Math.max(most, Math.abs(v - b[i])), 0)
        / b.reduce((most, v) => Math.max(most, Math.abs(v)), 1e-7)  // below: round-off, as F of a lifted punch
    const of = (kind, names) => Object.fromEntries(
        names.map((name) => [name, apart(one[kind][name], other[kind][name])]))
    const { scene, frames, nodes } = one.head
    const few = (name) => { // frames whose field is far from the other's
        const a = one.fields[name], b = other.fields[name], most = b.reduce((m, v) => Math.max(m, Math.abs(v)), 1e-7)
        const far = Array.from(a, (v, i) => Math.abs(v - b[i]) > %s * most && Math.floor(i / nodes))
        return a.length === b.length ? new Set(far.filter((k) => k !== false)).size : frames
    }
    const fields = Object.fromEntries(%s.map((name) => [name, few(name)]))
    return { scene, size: [frames, nodes], columns: of("columns", %s), fields }
}"""
PLAYS = """() => new Promise((then) => {
    const { drawn } = punch, look = () => (punch.drawn === drawn ? requestAnimationFrame(look) : then())
    look()
})"""
RANGES = """['punch', 'forces', 'area', 'map'].flatMap((name) => {
    const { x, y } = charts[name]
    return [x.start, x.end, y.start, y.end]
})"""
ALIKE = ("stage", "U_x", "delta", "F_bar", "L_bar", "A_bar", "slip", "slip_at", "slip_F", "slip_A", "work")


@pytest.mark.parametrize("name", stored.row())
@pytest.mark.once(2)
def test_stored_runs_match_the_solver(tab, name):
    scene = stored.row()[name].scene
    made = worker.compute(scene, None, np.inf, limit=np.inf)
    (block,) = made.blocks
    run = stored.path_of(name).read_bytes()
    assert len(run) <= stored.LARGEST
    texts = [base64.b64encode(message).decode() for message in (run, block)]
    compared = tab.evaluate(COMPARE % (FIELDS, list(packing.FIELDS), list(ALIKE)), texts)
    assert compared["size"] == [made.frames, blocks.header(block)["nodes"]]
    assert compared["scene"] == blocks.header(block)["scene"], "run python -m app.features.stored.store"
    assert {name: apart for name, apart in compared["columns"].items() if apart > CURVES} == {}
    # a symmetric wave touches on either side first, as round-off decides, until the other side has followed
    assert max(compared["fields"].values()) <= (SIDED if name == "wave" else 0)


@pytest.fixture(scope="module")
def held_back(browser):
    """A server without workers, and tabs of its own; the last test to use it ends it."""
    server = Server(APP_SCHEDULER=NOBODY)
    server.wait_for("visitors open|for a class")
    tabs = Tabs(server, browser)
    yield server, tabs
    tabs.close()
    if server.process.poll() is None:
        server.stop()


@pytest.mark.thorough
def test_a_stored_run_named_by_a_link_plays_from_its_beginning(held_back, browser):
    """The jump into contact, which "Jump in" is about, happens during the approach."""
    server, _ = held_back
    page = browser.new_page(**PLAYING)
    page.add_init_script("""(() => {
        const look = () => {
            if (window.punch?.run?.stored && punch.drawn >= 0) window.first ??= punch.drawn / punch.run.sheared
            requestAnimationFrame(look)
        }
        look()
    })()""")
    page.goto(f"{server.address}?more=0&preset=unload")
    page.wait_for_function("window.first !== undefined", timeout=PATIENCE)
    assert page.evaluate("first") < 0.5
    page.close()


@pytest.mark.thorough
@pytest.mark.slow
def test_a_stored_run_plays_without_workers_and_without_the_server(held_back):
    server, tabs = held_back
    page = tabs.open(**PLAYING)
    page.wait_for_function(
        "window.punch?.run?.stored && punch.drawn > punch.run.sheared && punch.status.state === 'warming'"
    )
    assert page.locator("#status").inner_text().startswith("stored")
    assert page.evaluate("punch.run.length") > 400 and page.evaluate("!punch.stale")
    page.evaluate(PLAYS)
    page.locator("[data-preset=fig4a-blue]").click()
    page.wait_for_function("punch.run.stored && punch.run.head.flat && !punch.fresh")
    assert not tabs.problems
    server.process.kill()
    page.wait_for_function("punch.lost")
    page.evaluate(PLAYS)


class HeldBack:
    """Holds back the server's messages from the first binary one on, until they are released."""

    def __init__(self, page):
        self.messages, self.socket, self.released = [], None, False
        page.route_web_socket("**/ws*", self._connect)

    def _connect(self, socket):
        self.socket = socket
        socket.connect_to_server().on_message(self._pass_on)

    def _pass_on(self, message):
        if self.released or not (self.messages or isinstance(message, bytes)):
            self.socket.send(message)
        else:
            self.messages.append(message)

    def release(self):
        self.released = True
        for message in self.messages:
            self.socket.send(message)


def test_a_stored_run_is_on_screen_before_bokeh_is_there(server, browser):
    page, held = browser.new_page(reduced_motion="reduce"), []
    page.route("**/bokeh.min.js", lambda route: held.append(route))
    page.goto(server.address, wait_until="commit")
    page.wait_for_function("window.punch?.run?.stored && !punch.fresh", timeout=PATIENCE)
    offered = "['take', 'pin'].map((id) => !document.getElementById(id).disabled)"
    assert page.evaluate(offered) == [False, False]  # they need what the server says of the scene
    held[0].continue_()
    finished(page)
    assert page.evaluate(offered) == [True, True]
    page.close()


@pytest.mark.slow
def test_computed_run_replaces_the_stored_one_at_the_same_increment_and_axes(server, browser):
    page = browser.new_page(viewport={"width": 1280, "height": 720}, reduced_motion="reduce")
    computed = HeldBack(page)
    page.goto(server.address)
    page.wait_for_function("window.punch?.run?.stored && !punch.fresh && punch.mapped", timeout=PATIENCE)
    paused_at(page, 300)
    before = page.evaluate(RANGES)
    computed.release()
    finished(page)
    assert page.evaluate("[punch.run.stored ?? false, punch.drawn]") == [False, 300]
    assert page.evaluate(RANGES) == pytest.approx(before, rel=0.02)
    page.close()


@pytest.mark.thorough
@pytest.mark.slow
def test_figures_and_play_are_disabled_until_a_run_is_on_screen(server, browser):
    page = browser.new_page(reduced_motion="reduce")
    stored_runs, computed = [], HeldBack(page)
    page.route("**/stored/runs/**", lambda route: stored_runs.append(route))
    page.goto(f"{server.address}?more=1")
    page.wait_for_function(
        "document.getElementById('status').dataset.state === 'opening' && window.punch", timeout=PATIENCE
    )
    offered = """['play', 'grab', 'chosen', 'punch-view'].map((id) => document.getElementById(id))
        .map((e) => e.checkVisibility({ visibilityProperty: true }) && !e.disabled)"""
    assert page.evaluate(offered) == [False] * 4
    for route in stored_runs:
        route.abort()
    computed.release()
    finished(page)
    assert page.evaluate(offered) == [True] * 4
    page.close()
