"""The picture of the punch in Chromium: lens, dragging, slow motion."""

import re

import pytest
from served import laid_out

pytestmark = pytest.mark.thorough


LEAN = """() => {
    const { run, drawn: k } = punch, { x } = run.frame(k)
    const { first, spacing, middle } = run.headOf(k), i = x.length >> 1, from = (first + i) * spacing - middle
    return Math.round((charts.punch.parts.surface.x[i] - from) / (x[i] - from) * 100) / 100
}"""


OWN = "?preset=fig6&theme=light"  # of the two tests that leave the page changed


def at_first_slip(page):
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    page.keyboard.press("]")
    page.wait_for_function("() => punch.run.curves.slip[punch.drawn] && punch.drawn > punch.run.sheared")


def test_bracket_keys_lead_from_slip_to_slip_and_the_sentence_states_it(look):
    page = look("?preset=fig6")
    at_first_slip(page)
    assert page.inner_text("#sentence").startswith("It slips by one site, 2.4 nm")
    first = page.evaluate("punch.drawn")
    page.keyboard.press("]")
    page.wait_for_function(f"() => punch.drawn > {first}")
    page.keyboard.press("[")
    page.wait_for_function(f"() => punch.drawn === {first}")


def test_what_differs_from_the_experiment_is_said_with_its_unit(look):
    page = look("?preset=fig6&E=60&delta_bar=-0.1")
    page.locator("#look", has_text="changed: ").wait_for()
    assert {*page.inner_text("#look").removeprefix("changed: ").split(", ")} == {
        "Press depth = −0.1",
        "Stiffness = 60 GPa",
    }


def test_the_picture_states_once_and_in_words_how_much_it_enlarges_lean_height_and_lens(look):
    page = look()
    page.wait_for_function("punch.drawn === punch.run.length - 1")
    assert page.evaluate(LEAN) == 3 and "×" not in page.evaluate("charts.punch.up")
    page.locator("#solver-figures").click()
    page.locator("#scales", has_text="displacements sideways 3 times as large").wait_for()
    said = page.inner_text("#scales")
    assert re.search(r"shows heights \d+ times", said) and re.search(r"magnifies \d+(.\d)? times", said)
    page.keyboard.press("Escape")


def test_dragging_the_punch_sideways_scrubs_and_downwards_presses_by_predictions(look):
    page = look(OWN)
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    page.evaluate("punch.at = punch.run.sheared")
    page.keyboard.press("ArrowRight")
    page.wait_for_function("() => punch.drawn === punch.run.sheared + 1")
    box = page.locator("#punch-view").bounding_box()
    x, y = box["x"] + 0.7 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 10, y, steps=3)
    page.mouse.move(x + 30, y, steps=3)
    page.mouse.up()
    page.wait_for_function("() => punch.drawn > punch.run.sheared + 5")
    covered = page.evaluate("punch.run.curves.U_x[punch.drawn] / punch.run.curves.U_x.at(-1)")
    assert covered == pytest.approx(0.5 * 30 / box["width"], rel=0.4)  # half a run for the width of the view
    run, depth = page.evaluate("[punch.run.number, punch.status.values.delta_bar]")
    page.evaluate("punch.rests = 1e6")  # on however slow a machine, this hand rests when it lets go
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 30, steps=4)
    page.wait_for_function(f"punch.run.followed && punch.run.scene.delta_bar > {depth} + 0.1")
    page.mouse.up()
    page.wait_for_function(
        f"punch.run.number > {run} && punch.status.values.delta_bar > {depth} + 0.1 && !punch.run.followed"
    )
    assert page.evaluate("punch.status.values.delta_bar") == pytest.approx(depth + 0.2, abs=0.011)  # a third in 100 px
    page.wait_for_function("() => location.search.includes('delta_bar=')")


SIZES = ((1920, 1080), (1440, 900), (1366, 657), (1280, 720), (1024, 768), (900, 600), (820, 1180), (390, 844))


# keeps what is written over the punch, with a rim as nothing on axes has it, and where
RECORD = """() => {
    if (window.written) return
    window.written = []
    const pen = CanvasRenderingContext2D.prototype, { strokeText, clearRect } = pen
    pen.clearRect = function (...box) {
        if (this.canvas === charts.punch.canvas) written.length = 0
        return clearRect.apply(this, box)
    }
    pen.strokeText = function (text, x, y) {
        const half = 0.4 * parseFloat(this.font.match(/([.\\d]+)px/)[1])
        const box = { text, left: x, right: x + this.measureText(text).width, top: y - half, bottom: y + half }
        if (this.canvas === charts.punch.canvas) written.push(box)
        return strokeText.call(this, text, x, y)
    }
}"""


OVER_EACH_OTHER = """() => {
    const { left, top } = charts.punch.canvas.getBoundingClientRect()
    const place = (id) => document.getElementById(id).getBoundingClientRect()
    const said = ['film', 'slow'].map((text) => [text, place(text)]).filter(([, box]) => box.width)
    const found = [], all = [...written, ...said.map(([text, box]) => (
        { text, left: box.left - left, right: box.right - left, top: box.top - top, bottom: box.bottom - top }))]
    written.forEach((a, i) => {
        for (const b of all.slice(i + 1)) {
            const over = Math.min(a.right, b.right) - Math.max(a.left, b.left)
            const under = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top)
            if (over > 1 && under > 1) found.push(`${a.text} and ${b.text}`)
        }
        const lens = place('lens'), x = lens.left + lens.width / 2 - left, y = lens.top + lens.height / 2 - top
        const apart = Math.hypot(x - Math.max(a.left, Math.min(x, a.right)), y - Math.max(a.top, Math.min(y, a.bottom)))
        if (apart < lens.width / 2 - 1) found.push(`${a.text} and the lens`)
    })
    return found
}"""


PICTURES = ["?preset=fig6", "?preset=fig6&view=projector", "?preset=fig7-case1", "?preset=fig7-case2", "?preset=rough"]


@pytest.mark.once
@pytest.mark.parametrize("query", PICTURES)
def test_labels_over_the_punch_do_not_overlap(look, query):
    page = look(query)
    page.evaluate(RECORD)
    at_first_slip(page)
    found = {}
    for width, height in SIZES:
        laid_out(page, (width, height))
        for key in ("[", "]", "ArrowRight", "ArrowLeft", "End"):
            page.keyboard.press(key)
            page.evaluate("() => new Promise(requestAnimationFrame)")
            if over := page.evaluate(OVER_EACH_OTHER):
                found[width, height, key] = over
    assert not found
