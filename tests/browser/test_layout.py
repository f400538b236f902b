"""The layout at every screen size: no clipped text, no overlap, and plots that are high enough."""

import pytest
from served import FAULTS, enter, faults_at, from_menu, laid_out

pytestmark = pytest.mark.thorough

SIZES = (
    (360, 740),
    (390, 844),
    (844, 390),
    (768, 1024),
    (820, 1180),
    (1024, 768),
    (1000, 820),
    (1280, 720),
    (1440, 900),
    (1920, 1080),
    (2560, 1440),
    (960, 600),  # 1440 x 900 at 150 %
    (720, 450),  # and at 200 %
)


WHOLE = SIZES[4:10]  # the first screen without scrolling; with more in sight from 1280 px on


def higher(page, sizes):
    """{size: height of the page}, where the first screen scrolls."""
    found = {}
    for width, height in sizes:
        laid_out(page, (width, height))
        if (high := page.evaluate("document.documentElement.scrollHeight")) > height:
            found[width, height] = high
    return found


@pytest.mark.once
@pytest.mark.parametrize("query", ["?more=0", "?more=1", "?more=0&view=projector"])
def test_experiment_fits_every_screen_size(look, query):
    page = look(query)
    page.keyboard.press("End")  # the longest readout
    assert not faults_at(page, SIZES)
    assert not higher(page, [size for size in WHOLE if query != "?more=1" or size[0] >= 1280])


SMALL = (546, 307), (320, 256), (455, 256), (640, 360), (667, 375), (760, 340), (400, 300)  # zooms of 200 % and more
OUT_OF_REACH = """() => ['#punch-view', '#sentence', '.forces .view', '#delta_bar', '#phi_ratio', '#E', '#play']
    .filter((what) => {
        const part = document.querySelector(what)
        document.querySelector(`#one input[value="${what.slice(1)}"]`)?.click() // where one slider is shown at a time
        part.scrollIntoView({ block: 'center' })
        const { left, right, top, bottom, width, height } = part.getBoundingClientRect()
        const x = left + width / 2, y = top + height / 2, seen = document.elementFromPoint(x, y)
        return !seen || !(part.contains(seen) || seen.closest('#punch-view')) || left < -1
            || right > innerWidth + 1 || y < 0 || y > innerHeight
    })"""


@pytest.mark.parametrize("query", ["?more=0", "?more=1"])
def test_a_page_zoomed_to_250_percent_and_more_scrolls_to_all_its_parts(look, query):
    """WCAG 1.4.10. Two of three sliders were gone, parts lay over each other, and nothing scrolled."""
    page = look(query)
    assert not faults_at(page, SMALL)
    for width, height in SMALL:
        laid_out(page, (width, height))
        assert page.evaluate("document.documentElement.scrollHeight") > height, (width, height)
        assert not page.evaluate(OUT_OF_REACH), (width, height)


OVER_ENDS = """() => [...document.querySelectorAll('.ends')].flatMap((scale) => {
    const labels = [...scale.querySelectorAll(':scope > span, .mark span')]
    const boxes = labels.map((e) => [e.textContent, e.getBoundingClientRect()])
    return boxes.flatMap(([name, box], i) => boxes.slice(i + 1)
        .filter(([, other]) => box.right > other.left && other.right > box.left)
        .map(([other]) => `${name} over ${other}`))
})"""


def test_the_label_of_every_slider_has_one_line_on_windows_that_show_three_beside_each_other(look):
    """A label in two lines puts its slider lower than the others."""
    page = look()
    for width in (900, 1000, 1060, 1180):
        laid_out(page, (width, 800))
        tops = page.evaluate("[...document.querySelectorAll('.control input[type=range]')].map((e) => e.offsetTop)")
        assert len(tops) == 3 and len(set(tops)) == 1, width


def test_slider_marks_cover_no_number_and_the_description_is_not_cut(look):
    page = look("?more=1")
    laid_out(page, (1440, 900))
    page.locator(".mark span").first.wait_for()
    assert not page.evaluate(OVER_ENDS)
    page.keyboard.press("Home")
    whole, shown = page.evaluate("(({ scrollHeight, clientHeight }) => [scrollHeight, clientHeight])(reasons)")
    assert whole <= shown


def test_phone_hides_pages_in_a_menu_and_a_finger_drags_the_punch_down(visit):
    page = visit("?more=0", viewport={"width": 390, "height": 844}, has_touch=True)
    punch, player = (page.locator(what).bounding_box() for what in ("#punch-view", ".player"))
    assert punch["y"] + 140 < player["y"]
    finger, grip = page.context.new_cdp_session(page), page.locator("#grab").bounding_box()

    def swipe(x, y):
        for kind, down in (("touchStart", 0), ("touchMove", 10), ("touchMove", 40), ("touchEnd", None)):
            points = [] if down is None else [{"x": x, "y": y + down}]
            finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    swipe(40, punch["y"] + 100)  # scrolls the page, and changes nothing
    page.evaluate("() => new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)))")
    assert page.evaluate("[punch.dragging, punch.waiting.length, punch.status.values.delta_bar]") == [False, 0, 0]
    swipe(grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2)
    page.wait_for_function("punch.status.values.delta_bar > 0")
    assert page.evaluate("scrollY") == 0 and page.locator("#preset").is_visible()
    law = page.get_by_role("button", name="Interface law")
    assert not law.is_visible()
    page.get_by_role("button", name="Menu").click()
    law.click()
    page.locator("#law").wait_for()
    assert not page.locator("nav").is_visible()  # the menu folds itself
    page.get_by_role("button", name="Menu").click()
    from_menu(page, "#parameters")
    page.wait_for_function("document.getElementById('find').getBoundingClientRect().bottom < innerHeight - 150")


def test_an_error_message_leaves_slider_widths_unchanged(look):
    page = look()
    widths = "['delta_bar', 'phi_ratio', 'E'].map((name) => document.getElementById(name).clientWidth)"
    before = page.evaluate(widths)
    enter(page, "E", "abc")
    page.locator("#E-error").wait_for()
    assert page.evaluate(widths) == before


SHARES = {(1440, 900): 0.55, (1280, 720): 0.55, (390, 844): 0.38}  # of the first screen that is the hero's
PLOTS = {(1440, 900): 180, (1280, 720): 130, (1920, 1080): 300}  # px, of the forces within their axes


def test_punch_fills_its_share_of_every_screen_beside_a_visible_curve(look):
    page = look("?more=0")
    others = (1920, 1080), (900, 600), (1024, 600), (1024, 700), (1180, 600), (1366, 657)
    for width, height in (*SHARES, *others):
        laid_out(page, (width, height))
        hero, curve = (page.locator(what).bounding_box() for what in (".hero", ".view[data-view=forces]"))
        assert hero["width"] * hero["height"] >= SHARES.get((width, height), 0.4) * width * height, (width, height)
        assert page.evaluate("charts.forces.box.height") >= PLOTS.get((width, height), 0)
        player = page.locator(".player").bounding_box()["y"]
        assert max(box["y"] + box["height"] for box in (hero, curve)) <= player, (width, height)


LONGEST = "It slips by one site, 2.4 nm: friction drops from 50.4 to 39.2 N/m, and nothing is pressed together."
ALONE = "Nothing is pressed together any more, yet it holds: attraction alone carries the friction."
REASON = (
    "Pressed deeper: it slips later, at 13.5 nm instead of 10.8 nm, 264 N/m instead of 195 N/m; "
    "there is more contact to hold it."
)


def test_long_sentences_do_not_move_curves_and_sliders(visit):
    page = visit("?more=0")
    where = """() => ["figure.forces .view", ".control[data-shown]", ".player"].map((name) => (
        ((box) => [box.top, box.height])(document.querySelector(name).getBoundingClientRect())))"""
    for width, height in SIZES:
        laid_out(page, (width, height))
        places = []
        for sentence, reason, state in (
            ("", "", "paused"),
            (LONGEST, REASON, "followed"),
            (ALONE, REASON, "followed"),
            ("It slips.", "", "running"),
        ):
            page.evaluate(
                """(said) => ["sentence", "why"].forEach((id, i) => {
                    document.getElementById(id).textContent = said[i]
                    document.getElementById(id).dataset.long = said[i].length > 80
                    document.getElementById("status").dataset.state = said[2]
                })""",
                [sentence, reason, state],
            )
            places.append(page.evaluate(where))
        assert all(place == places[0] for place in places), (width, height)


def test_a_phone_on_its_side_shows_the_whole_punch_above_sliders_and_play(look):
    page = look("?more=0")
    laid_out(page, (844, 390))
    punch, sliders, play = (page.locator(what).bounding_box() for what in ("#punch-view", ".sliders", "#play"))
    assert punch["y"] + punch["height"] <= sliders["y"]
    assert play["y"] + play["height"] <= 390


def test_a_page_opened_on_a_phone_starts_at_its_heading(visit):
    page = visit("?page=law", rests=False, viewport={"width": 390, "height": 844})
    page.wait_for_function(
        "() => { const { top } = document.querySelector('#law h2').getBoundingClientRect();"
        " return top >= -1 && top < innerHeight / 2 }"
    )


@pytest.mark.parametrize("query", ["?more=0", "?more=1"])
def test_a_flat_shows_picture_text_and_one_curve_at_every_size(look, query):
    page = look(f"{query}&preset=fig4a-blue")
    page.locator("#chosen [value=area]").evaluate("(radio) => radio.click()")  # a curve that a flat has not
    places = """() => ['.hero', '#narration', '.forces'].map((what) => document.querySelector(`main ${what}`))
        .map((part) => part.getBoundingClientRect()).map((box) => [box.left, box.right, box.top, box.bottom])"""
    for width, height in SIZES:
        laid_out(page, (width, height))
        assert not page.evaluate(FAULTS), (width, height)
        boxes = page.evaluate(places)
        for i, (left, right, top, bottom) in enumerate(boxes):
            assert right - left > 0.2 * width and bottom > top, (width, height)
            for others in boxes[i + 1 :]:
                beside = others[0] >= right - 1 or others[1] <= left + 1
                apart = beside or others[2] >= bottom - 1 or others[3] <= top + 1
                assert apart, (width, height)
