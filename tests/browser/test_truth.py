"""The page states which scene its run belongs to, and reports a lost server."""

import time

import pytest
from served import Server, finished, patient

pytestmark = pytest.mark.thorough
GREY = "document.querySelector('.hero').ariaBusy === 'true'"
SAID = "document.getElementById('stale').textContent"

DRAWN = """() => {
    // with every picture once another scene is asked for: E of the punch and of the curves, whether they are grey
    window.drawn = []
    const look = () => {
        const { stale, mixed } = document.querySelector(".page").dataset
        const asked = Number(document.getElementById("E-entry").value)
        if (punch.picture.run.scene.E !== asked || punch.charted.scene.E !== asked)
            drawn.push([punch.picture.run.scene.E, punch.charted.scene.E, stale === "true", mixed === "true"])
        requestAnimationFrame(look)
    }
    look()
}"""


def enter(page, E):
    """In one go: what is being typed is not yet a change."""
    page.locator("#E-entry").evaluate(f"(e) => {{ e.value = {E}; e.dispatchEvent(new Event('change')) }}")


def test_previous_run_is_grey_until_the_new_one_is_complete(look):
    page = look("?E=20&delta_bar=0.3")
    assert not page.evaluate(GREY)
    page.evaluate(DRAWN)
    enter(page, 21.5)
    finished(page, run=2)
    seen = page.evaluate("drawn")
    assert {grey for E, curves, grey, _ in seen if E == 20} == {True}
    assert not [row for row in seen if 20 in row[:2] and not row[2 + (row[0] != 20)]]
    assert not page.evaluate(GREY)
    page.fill("#E-entry", "7000000")  # refused: the run on screen is that of the sliders
    page.keyboard.press("Enter")
    page.wait_for_function("document.getElementById('E-error').textContent.includes('7000000')")
    assert not page.evaluate(GREY)


def test_an_old_picture_is_grey_until_the_new_run_reaches_its_increment(look):
    """The new run begins with its approach; the increment on screen lies far behind that."""
    page = look("?E=20&k=205")
    page.wait_for_function("punch.drawn === 205")
    page.evaluate(DRAWN)
    page.evaluate("modules.player.goto(205)")
    enter(page, 10)
    finished(page, run=2)
    page.wait_for_function("punch.picture.run === punch.run && punch.charted === punch.run && !punch.fresh")
    seen = page.evaluate("drawn")
    assert len(seen) > 3 and not [row for row in seen if row[0] == 20 and not row[2]]
    assert not [row for row in seen if row[1] == 20 and not row[3]]
    assert not page.evaluate(GREY) and page.evaluate("punch.drawn") == 205


WATCHED = """() => {
    // what is on screen from now on: [whether the loss is told, whether it is grey, E of the run, E of the controls]
    window.watched = []
    const look = () => {
        if (window.punch?.run && punch.status.values) {
            const { stale, drawn } = document.querySelector(".page").dataset
            const grey = stale === "true" || drawn === undefined // nothing is in sight yet
            const lost = !document.getElementById("lost").hidden
            const [of, entry] = [punch.run.scene?.E, Number(document.getElementById("E-entry").value)]
            watched.push([lost, grey, of, entry])
        }
        requestAnimationFrame(look)
    }
    look()
}"""


def test_page_reports_a_lost_server_and_recovers_when_it_restarts(server, browser):
    """The page tries to reconnect every 2 s at most; the test waits for these attempts, not for a time."""
    mortal = Server()
    mortal.wait_for("workers are warm")
    page = patient(browser.new_page())
    problems, attempts = [], []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.add_init_script(f"addEventListener('DOMContentLoaded', {WATCHED})")
    page.goto(f"{mortal.address}?delta_bar=0.2&E=300")
    finished(page)
    page.locator("body").press("End")
    for _ in range(20):
        page.locator("body").press("Shift+ArrowLeft")
    page.wait_for_function("Math.abs(punch.run.curves.U_x[punch.drawn] - 20.0) < 1e-4")  # drawn with the next frame
    told = time.monotonic()
    mortal.process.kill()
    page.get_by_role("alert").filter(has_text="what you change takes effect when the server answers").wait_for()
    print(f"told {time.monotonic() - told:.1f} s after the server was killed")
    page.locator("body").press("ArrowRight")  # scrubbing goes on
    page.wait_for_function("Math.abs(punch.run.curves.U_x[punch.drawn] - 20.1) < 1e-4")  # drawn with the next frame
    enter(page, 310)  # it waits
    assert page.evaluate(SAID) == "The picture is that of E = 300 GPa."
    assert not page.evaluate(GREY)  # it goes on playing
    assert "E=300" in page.url
    # sliders and experiments live, and look so; what only the server can do is locked
    assert page.evaluate("getComputedStyle(document.querySelector('.controls')).opacity") == "1"
    assert page.evaluate("[...document.querySelectorAll('nav button')].every((button) => button.disabled)")
    assert page.is_enabled("#E") and page.is_enabled("#row input >> nth=0")
    page.locator("#take").dispatch_event("click")
    page.locator("#share-status", has_text="server does not answer").wait_for()
    assert page.is_disabled("#copy-python")
    page.keyboard.press("Escape")
    before = page.evaluate("watched")
    page.on("request", lambda request: attempts.append(request.method))
    while attempts.count("HEAD") < 4:  # it goes on trying, as long as it takes
        page.wait_for_event("request")
    begun = time.monotonic()
    again = Server(port=mortal.port)
    again.wait_for("Bokeh app running")
    up = time.monotonic()
    page.wait_for_function("window.punch?.status.values?.E === 310")
    finished(page)
    print(f"back {time.monotonic() - begun:.1f} s after the restart, {time.monotonic() - up:.1f} s after it serves")
    assert page.evaluate("punch.status.values.delta_bar") == 0.2
    page.wait_for_function("Math.abs(punch.run.curves.U_x[punch.drawn] - 20.1) < 1e-4")  # drawn with the next frame
    assert not page.evaluate("punch.playing")
    assert page.locator("#lost").is_hidden() and not page.evaluate(GREY)
    page.wait_for_function("watched.at(-1).join() === 'false,false,310,310'")
    after = page.evaluate("watched")
    page.close()
    again.stop()
    mortal.process.wait(30)
    assert not problems
    assert {tuple(row[2:]) for row in before if not row[0]} == {(300, 300)}
    # while the server answers, a run that is not that of the sliders is grey
    assert not [row for row in before + after if row[2] not in (None, row[3]) and not (row[0] or row[1])]


def test_a_long_run_shows_its_remaining_time_and_can_be_skipped(visit):
    # a rough soft layer, there and back over hundreds of sites: far longer than it takes until Skip is offered
    page = visit(
        "?preset=rough&E=10&phi_ratio=2&nodes=2048&width=5000&path=loop&du_x=1&delta_bar=-0.1&du_z=1&u_x_max=200",
        rests=False,
    )
    page.get_by_role("button", name="Skip").wait_for()
    said = page.locator("#status")
    page.wait_for_function(
        """() => /^\\d+ of \\d+ increments · (solving a (slip|jump) near .* for \\d+ s|about \\d+ s left)/.test(
            document.querySelector("#status span").textContent)"""
    )
    assert page.evaluate("punch.status.frames < punch.status.total && punch.run.sheared >= 0")
    page.get_by_role("button", name="Skip").click()
    page.wait_for_function("punch.status.state === 'skipped'")
    assert page.locator("#skip").is_hidden() and "what was computed stays" in said.inner_text()
    frames = page.evaluate("punch.run.length")
    assert frames == page.evaluate("punch.status.frames")
    page.wait_for_function("!punch.playing || !punch.following")  # it can be played
    page.locator("body").press("End")
    page.wait_for_function(f"punch.drawn === {frames - 1}")
    page.locator("body").press(" ")
    page.wait_for_function(f"punch.drawn < {frames - 1}")  # from the beginning
    page.locator("body").press(" ")
    page.select_option("#preset", "fig6")  # and the server is free for what comes next
    finished(page, run=2)
    assert page.evaluate("punch.run.length") == page.evaluate("punch.status.total")
