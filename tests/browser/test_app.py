"""The experiment in Chromium by keyboard and mouse, without errors and external requests."""

import re

import pytest
from served import PLAYING, enter, finished, from_menu, values_are
from tabs import imported


def drawn(page, view, part):
    """How many points of a curve are in the chart."""
    return page.evaluate(f"charts.{view}.parts.{part}.x.length")


def sliders(page):
    values = page.evaluate("punch.status.values")
    return {name: values[name] for name in ("delta_bar", "phi_ratio", "E")}


def test_address_sets_the_scene_whose_curves_grow_while_computed_and_notes_what_is_invalid(visit):
    # soft: several slices, however fast the machine
    page = visit("?E=20&delta_bar=0.3&phi_ratio=lots&foo=1&delta=0.5&theme=dark&u_x_max=20", rests=False)
    page.wait_for_function("() => window.punch?.run")
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
    assert any(0 < length < 201 for length in grown)  # seen in the making, not only whole
    assert drawn(page, "forces", "F") == drawn(page, "forces", "L") == drawn(page, "area", "A") == 201
    assert "all increments converged" in page.text_content("#solver")
    assert sliders(page) == {"delta_bar": 0.3, "phi_ratio": 1, "E": 20}
    notes = page.inner_text("#notes")
    assert "phi_ratio" in notes and "0 to 100" in notes
    assert "“foo” in the address is unknown" in notes and re.search("“delta” .*Use .*delta_bar", notes)
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


def test_moving_a_slider_changes_the_curve_and_keeps_the_previous_one_until_reset(look):
    page = look()
    before = page.evaluate("[...punch.run.shear('F_bar')]")
    page.get_by_role("slider", name="Press depth").focus()
    page.keyboard.press("ArrowRight")
    finished(page, run=2)
    assert page.evaluate("punch.status.values.delta_bar") == 0.01
    assert page.evaluate("[...punch.run.shear('F_bar')]") != before
    assert page.evaluate("[...punch.ghost.shear('F_bar')]") == before
    assert drawn(page, "forces", "ghost_F") == len(before)
    assert "delta_bar=0.01" in page.url
    assert page.input_value("#delta_bar-entry") == "0.01"
    assert page.inner_text("[data-name=delta_bar] .unit") == "= 0.1 nm"
    page.get_by_role("button", name="Reset", exact=True).click()
    page.wait_for_function("punch.status.values.delta_bar === 0")
    finished(page)
    assert sliders(page) == {"delta_bar": 0, "phi_ratio": 1, "E": 70}
    assert page.evaluate("punch.ghost") is None
    assert drawn(page, "forces", "ghost_F") == 0


CURSOR = """() => {
    return charts.forces.parts.cursor.at === punch.run.curves.U_x[punch.drawn]
}"""


def test_playback_can_be_paused_and_stepped(visit):
    page = visit(**PLAYING)
    page.wait_for_function("punch.drawn > punch.run.sheared + 3")  # it plays by itself
    page.wait_for_function(CURSOR)
    page.get_by_role("button", name="Pause").click()
    page.wait_for_function("document.getElementById('status').textContent.includes('paused')")
    page.wait_for_function(CURSOR)
    at = page.evaluate("Math.floor(punch.at)")
    page.get_by_role("button", name="Step forward").click()
    page.wait_for_function("(at) => punch.drawn === at", arg=at + 1)
    page.get_by_role("button", name="Step back").click()
    page.wait_for_function("(at) => punch.drawn === at", arg=at)
    page.locator("body").press("Shift+ArrowRight")
    page.wait_for_function("(at) => punch.drawn === at", arg=at + 10)
    page.locator("body").press("Home")
    page.wait_for_function("document.getElementById('readout').innerText.startsWith('approach 0')")
    page.locator("body").press("End")
    page.wait_for_function("document.getElementById('readout').innerText.includes('40.0 nm')")
    page.locator("body").press("Space")
    page.wait_for_function("punch.playing")


def test_a_status_from_before_another_experiment_was_chosen_ends_nothing(look):
    """The experiment chosen was not shown as it was computed, but at an increment of the run before."""
    followed = imported(look(), "status").evaluate(
        """() => [[{ n: 1e9, what: "restore", at: performance.now() }], []].map((waiting) => {
            Object.assign(punch, { waiting, following: true })
            modules.status.heard({ ...punch.status })
            return punch.following
        })"""
    )
    assert followed == [True, False]


def test_a_place_that_a_run_is_to_reach_is_given_up_by_scrubbing(look):
    """A run that grew jumped there later, away from where one had scrubbed."""
    place = imported(look(), "player").evaluate(
        "() => { punch.place = punch.run.place(300); modules.player.goto(200); return punch.place }"
    )
    assert place is None


def test_a_run_that_fails_behind_a_picture_says_why(look):
    page = imported(look(), "status")
    page.evaluate(
        """() => {
            window.kept = punch.status
            punch.run.followed = true
            modules.status.heard({ ...kept, state: "failed", why: "It fluttered." })
        }"""
    )
    page.wait_for_function("!punch.fresh")
    assert page.inner_text("#status").split()[:3] == ["failed", "It", "fluttered."]
    page.evaluate("() => { punch.run.followed = false; modules.status.heard({ ...kept }) }")


def test_help_lists_the_keys_and_opens_by_keyboard_and_mouse(look):
    page = look()
    help_ = page.get_by_role("dialog", name="Keys")
    from_menu(page, "#help")
    for key in ("Space", "Shift", "Home", "End", "R", "←", "→"):
        assert help_.locator("kbd", has_text=re.compile(rf"^{key}$")).count() >= 1
    at = page.evaluate("punch.status.run")
    page.keyboard.press("r")  # behind an open help nothing happens
    page.keyboard.press("Escape")
    help_.wait_for(state="hidden")
    assert page.evaluate("punch.status.run") == at
    page.locator("body").press("?")
    help_.wait_for(state="visible")
    help_.get_by_role("button", name="Close").click()
    help_.wait_for(state="hidden")


@pytest.mark.thorough
def test_playback_speed_is_the_chosen_speed_of_the_top(visit):
    page = visit(**PLAYING)
    page.select_option("#speed", "20")
    assert page.evaluate("punch.speed") == 20
    page.evaluate("punch.at = punch.run.sheared + 200")  # beyond the first stick and slip, which are slowed
    # frames passed while the clock of the page ran on, whatever its pace
    at, now = page.evaluate("[punch.at, punch.clock]")
    page.wait_for_function(f"punch.clock > {now} + 0.2 || punch.at < {at}")
    passed, frames = page.evaluate(f"[punch.clock - {now}, punch.at - {at}]")
    assert frames < 0 or frames * 0.1 == pytest.approx(20 * passed)


@pytest.mark.thorough
def test_moving_a_slider_replaces_a_slow_run_at_once(visit):
    page = visit("?E=10&delta_bar=1", rests=False)
    page.wait_for_function("() => window.punch?.run?.sheared >= 0 && punch.status.state === 'running'")
    assert re.search(r"running\s+\d+ of \d+ increments", page.inner_text("#status"))
    enter(page, "E", "500")
    finished(page, run=2)
    assert page.evaluate("punch.status.values.E") == 500
    assert 0 < page.evaluate("punch.ghost.shear('F_bar').length") < 401  # what was there of the slow one


def test_hovering_previews_and_clicking_selects_an_increment(look):
    page = look()
    page.keyboard.press("Home")
    page.wait_for_function("punch.drawn === 0")
    at = 0
    box = page.locator("figure[aria-label^='Friction'] .view").bounding_box()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.4 * box["height"])
    page.wait_for_function(f"punch.drawn > {at} + 50")
    page.wait_for_function("document.getElementById('scrub').value === `${punch.drawn}`")
    page.mouse.move(5, 5)
    page.wait_for_function(f"punch.drawn === {at}")
    page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 0.4 * box["height"])
    page.mouse.move(5, 5)
    page.wait_for_function(f"punch.at > {at} + 50 && punch.preview === null")
    page.keyboard.press("Home")
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.4 * box["height"])
    page.wait_for_function("punch.preview !== null")
    page.keyboard.press(" ")  # it plays on, although the mouse rests on a curve
    page.wait_for_function("punch.playing && punch.preview === null && punch.at > 1")
    page.mouse.move(5, 5)
    page.keyboard.press(" ")
    page.wait_for_function("!punch.playing")


def test_an_invalid_entry_shows_the_range_and_keeps_the_run(look):
    page = look()
    for text, said in (("7000000", "“7000000”"), ("stiff", "“stiff”"), ("nan", "Stiffness “nan”")):
        enter(page, "E", text)
        page.wait_for_function("said => document.getElementById('E-error').textContent.includes(said)", arg=said)
        assert "0.01 to 10⁶ GPa" in page.inner_text("#E-error")
    assert page.evaluate("punch.run.number - before") == 1
    enter(page, "E", "73.5")
    finished(page, run=2)
    assert page.locator("#E-error").is_hidden()


@pytest.mark.thorough
def test_entries_convert_units_and_a_rejected_depth_shows_no_conversion(look):
    page = look()
    read = "name => document.getElementById(`${name}-entry`).value"
    for text in ("70 GPa", "0.08 TPa", "70e9 Pa"):
        enter(page, "E", text)
        page.wait_for_function(f"({read})('E') === '{80 if 'T' in text else 70}'")
    enter(page, "delta_bar", "-3")
    page.locator("#delta_bar-error").wait_for()
    assert page.inner_text("[data-name=delta_bar] .unit") == "" and page.evaluate(read, "delta_bar") == "-3"
    enter(page, "delta_bar", "2.5")
    page.wait_for_function("document.getElementById('delta_bar').title.startsWith('2.5 lies beyond')")


@pytest.mark.thorough
def test_theme_follows_the_browser_and_switching_it_keeps_the_run(visit):
    page = visit(color_scheme="dark")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    from_menu(page, "#theme")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.evaluate("punch.run.number") == 1


def test_two_entries_made_at_once_both_count(look):
    """Panel passes on the last of two values that come together."""
    page = look("?u_x_max=6")
    entries = "[{ E: '81' }, { phi_ratio: '0.9' }]"
    imported(page, "steer").evaluate(f"() => {entries}.forEach(modules.steer.enter)")
    values_are(page, E=81, phi_ratio=0.9)
