"""The page on paper, as Chromium prints it."""

import pytest
from served import finished

pytestmark = pytest.mark.thorough

COLOURS = """() => {
    const of = (what) => getComputedStyle(document.querySelector(what)).color.match(/[\\d.]+/g).slice(0, 3).map(Number)
    const page = charts.forces.canvas, { data } = page.getContext("2d").getImageData(0, 0, page.width, page.height)
    let dark = 0
    for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 128 && data[i] + data[i + 1] + data[i + 2] < 200) dark++
    return { entry: of("#E-entry"), theme: document.documentElement.dataset.theme, dark }
}"""


def test_a_dark_page_is_printed_in_light_colours_and_stays_dark_on_screen(look):
    page = look("?theme=dark&k=150")
    finished(page)
    page.wait_for_function("punch.drawn === 150 && !punch.fresh")
    before = page.evaluate(COLOURS)
    assert before["theme"] == "dark" and max(before["entry"]) > 180
    page.evaluate(f"addEventListener('beforeprint', () => {{ window.printed = ({COLOURS})() }})")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    printed = page.evaluate("printed")
    assert printed["theme"] == "light" and max(printed["entry"]) < 90
    assert printed["dark"] > 200 > before["dark"]  # ink of curves and numbers, drawn before the paper is made
    page.emulate_media(media="print")
    sizes = "() => [...document.querySelectorAll('.chart')].map((c) => getComputedStyle(c).objectFit)"
    assert {*page.evaluate(sizes)} == {"contain"}
    assert not page.locator("#play").is_visible()
    page.emulate_media(media="screen")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.wait_for_function("document.documentElement.dataset.theme === 'dark' && !punch.fresh")
