"""The stress in the punch in Chromium: fringes, and components with their sign."""

import pytest
from served import enter, finished, laid_out, patient, values_are
from tabs import imported

pytestmark = pytest.mark.thorough


KEY = "document.getElementById('fringe-most').textContent"


def test_stress_per_fringe_changes_only_when_the_user_chooses_it(visit):
    page = visit("?E=71.6")
    page.wait_for_function(f"{KEY} === '0.6 GPa'")
    enter(page, "delta_bar", "0.4")  # pressed harder: the tractions are larger
    values_are(page, delta_bar=0.4)
    page.wait_for_function("!punch.fresh && punch.drawn >= 0")
    assert page.evaluate(KEY) == "0.6 GPa"
    page.locator("#fringe").evaluate("(of) => { of.value = '0.5'; of.dispatchEvent(new Event('change')) }")
    page.wait_for_function(f"{KEY} === '1.5 GPa'")


def test_a_page_that_opens_with_a_stored_run_gets_the_table_of_its_layer(visit):
    """It was asked for before the first run was, and the server knew of none."""
    page = visit()
    page.wait_for_function("Boolean(Bokeh.documents[0].roots()[0].data.table.body)")


WHOLE = """() => {
    const key = document.querySelector(".hero .key"), [of, around] = [document.querySelector(".of-fringe"), key]
        .map((element) => element.getBoundingClientRect())
    return of.width > 0 && of.right <= around.right && of.bottom <= around.bottom + 1
        && key.scrollWidth <= key.clientWidth
}"""


SCREENS = (1440, 900), (1366, 768), (1280, 720), (390, 844)


@pytest.mark.parametrize(
    ("query", "sizes"), [("?more=0", (*SCREENS, (1180, 820))), ("?more=0&view=projector", SCREENS)]
)
def test_the_scale_of_the_fringes_is_in_sight_on_every_screen(look, query, sizes):
    page = look(query)
    for width, height in sizes:
        laid_out(page, (width, height))
        assert page.evaluate(WHOLE), (width, height)


# [r, g, b, a] of the lowest painted pixel of a column at a fraction of the width of the plot: just above the surface
LOWEST = """(part) => {
    const { picture: canvas } = charts.punch.parts.fringes, { width, height } = canvas
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height)
    const painted = (x, y) => data[4 * (y * width + x) + 3] > 200
    const columns = Array.from({ length: width }, (_, x) => x).filter((x) => painted(x, height >> 3))
    const x = columns[Math.round(part * (columns.length - 1))]
    for (let y = height - 1; y >= 0; y--) if (painted(x, y)) return [...data.slice(4 * (y * width + x)).slice(0, 4)]
    return null
}"""


CHOOSE = "(of, value) => { of.value = value; of.dispatchEvent(new Event('change')) }"


WATCHED = """() => {
    // with every picture from the opening on: [scales of stress in sight, whether stress is drawn]
    window.watched = []
    const look = () => {
        const scales = [...document.querySelectorAll(".of-fringe, .of-stress")].filter((of) => of.checkVisibility())
        if (window.charts) watched.push([scales.length, Boolean(charts.punch.parts.fringes?.picture)])
        requestAnimationFrame(look)
    }
    look()
}"""


def test_a_scale_of_stress_is_in_sight_only_where_stress_is_drawn(server, browser):
    """A page opens with a stored run, before the table of its layer is there."""
    page = patient(browser.new_page())
    page.add_init_script(f"addEventListener('DOMContentLoaded', {WATCHED})")
    page.goto(f"{server.address}?more=0")
    finished(page)
    page.wait_for_function("watched.at(-1).join() === '1,true'")
    for name, value in (("delta_bar", -1), ("surface", "flat"), ("surface", "circular"), ("delta_bar", 0.2)):
        imported(page, "steer").evaluate(f"modules.steer.enter({{ {name}: '{value}' }})")
        values_are(page, **{name: value})
    page.wait_for_function("watched.at(-1).join() === '1,true'")
    page.locator("#stress").evaluate(CHOOSE, "xx")
    page.wait_for_function(
        "document.querySelector('.of-stress:not([hidden])')?.dataset.stress === 'xx'"
        " && watched.at(-1).join() === '1,true'"
    )
    seen = page.evaluate("watched")
    page.close()
    assert {tuple(each) for each in seen} == {(0, False), (1, True)}


def test_chosen_stress_is_drawn_with_its_sign_and_scale(look):
    """A punch that is pressed is squeezed above the contact, stretched where its edges adhere, and held back."""
    page = look("?delta_bar=0.4&k=190&theme=light")
    page.wait_for_function("punch.drawn === 190")
    stress = page.locator("#stress")
    painted = f"({LOWEST})(0.5) !== null"
    try:
        stress.evaluate(CHOOSE, "zz")
        page.wait_for_function("document.querySelector('.of-stress:not([hidden])')?.dataset.stress === 'zz'")
        page.wait_for_function(painted)
        key = page.locator(".of-stress:visible")
        assert " ".join(key.inner_text().split()) == "σ_zz: squeezed −0.6+0.6 GPa stretched"
        red, _, blue, _ = page.evaluate(LOWEST, 0.5)
        assert blue > red + 30
        red, _, blue, _ = page.evaluate(LOWEST, 0.15)
        assert red > blue + 30
        stress.evaluate(CHOOSE, "xz")
        page.wait_for_function("document.querySelector('.of-stress:not([hidden])')?.dataset.stress === 'xz'")
        page.wait_for_function(painted)
        red, green, _, _ = page.evaluate(LOWEST, 0.5)
        assert green > red + 15
        assert page.locator(".of-stress:visible").inner_text().startswith("τ: pulls on")
        assert not page.locator("#fringe-bar").is_visible()
        stress.evaluate(CHOOSE, "plain")
        page.wait_for_function("charts.punch.parts.fringes.picture === null")
    finally:
        stress.evaluate(CHOOSE, "fringes")
    page.wait_for_function("!document.querySelector('.of-fringe').hidden")
