"""Slow motion in Chromium."""

import pytest
from served import grab, paused, paused_at

pytestmark = pytest.mark.thorough


def at_first_slip(page):
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    page.keyboard.press("]")
    page.wait_for_function("() => punch.run.curves.slip[punch.drawn] && punch.drawn > punch.run.sheared")


def test_slow_motion_keeps_the_top_fixed_and_ends_at_the_increment_after_the_slip(look):
    page = look("?preset=fig6")
    page.keyboard.press("Home")
    page.locator("#slow").wait_for(state="hidden")
    at_first_slip(page)
    page.evaluate(
        """() => {
            window.seen = []
            new MutationObserver(() => {
                const text = document.getElementById("film").textContent
                if (!text.startsWith("slow")) return
                seen.push([text, document.getElementById("readout").textContent])
            }).observe(document.getElementById("film"), { childList: true })
        }"""
    )
    k = page.evaluate("punch.drawn")
    page.get_by_role("button", name="Slow motion").click()
    page.wait_for_function("seen.length > 3")
    assert page.locator("#slow").inner_text() == "Stop"
    page.locator("#film").wait_for(state="hidden")  # it has come to its end
    said = page.evaluate("seen")
    assert {text for text, _ in said} == {"slow motion"}
    assert all("Uₓ = 10.8 nm" in readout for _, readout in said)  # not 10.9, of the increment
    page.wait_for_function("(k) => punch.drawn === k", arg=k)
    page.wait_for_function("document.getElementById('film').hidden")
    assert page.locator("#slow").inner_text() == "Slow motion"


def test_key_m_shows_the_previous_slip_in_slow_motion_until_another_key(look):
    page = look("?preset=loop")
    at_first_slip(page)
    k = page.evaluate("punch.drawn")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.wait_for_function(f"() => punch.drawn === {k + 20}")
    page.keyboard.press("m")
    page.locator("#film").filter(has_text="slow motion").wait_for()
    assert page.evaluate("punch.drawn") == k
    page.keyboard.press("ArrowRight")
    page.locator("#film").wait_for(state="hidden")
    page.wait_for_function(f"() => punch.drawn === {k + 1}")


def test_slow_motion_can_be_paused_and_resumed(look):
    page = look("?preset=fig6")
    at_first_slip(page)
    ends = "[charts.forces.y.start, charts.forces.y.end]"
    before = page.evaluate(ends)
    page.keyboard.press("m")
    page.wait_for_function("punch.instead")
    page.locator("#play", has_text="Pause").wait_for()
    low, high = page.evaluate("(({ F }) => [Math.min(...F), Math.max(...F)])(punch.instead.run.curves)")
    start, end = page.evaluate(ends)
    assert start < low and before[1] < high < end  # F of the motion, drawn beside the slip
    page.keyboard.press(" ")
    page.locator("#play", has_text="Play").wait_for()
    rests = page.evaluate(
        """() => new Promise((then) => {
            const { k } = punch.instead
            setTimeout(() => then(punch.instead?.k === k), 300)  // of 5 s for some dozen states
        })"""
    )
    assert rests
    page.keyboard.press(" ")
    page.locator("#play", has_text="Pause").wait_for()
    page.locator("#film").wait_for(state="hidden")
    page.locator("#play", has_text="Play").wait_for()
    assert page.evaluate(ends) == before


def test_the_slider_of_the_player_leads_out_of_slow_motion(look):
    page = look("?preset=fig6")
    at_first_slip(page)
    k = page.evaluate("punch.drawn")
    page.keyboard.press("m")
    page.wait_for_function("punch.instead")
    assert page.input_value("#scrub") == str(k)
    paused_at(page, k + 30)
    page.locator("#film").wait_for(state="hidden")


def test_slow_motion_without_a_slip_explains_why(look):
    page = look("?preset=fig6&u_x_max=14")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    page.keyboard.press("m")
    said = page.locator("#film")
    said.wait_for()
    assert said.inner_text() == "Slow motion: no slip up to here; the key ] leads to the next."
    said.wait_for(state="hidden")
    at_first_slip(page)
    page.keyboard.press("ArrowRight")
    k = page.evaluate("punch.run.curves.slip[punch.at] = 1, punch.at")  # the server knows better
    page.keyboard.press("m")
    said.filter(has_text="Slow motion: no branch ends here.").wait_for()
    assert page.locator("#slow").inner_text() == "Slow motion" and page.evaluate("punch.at") == k


def test_slow_motion_of_a_predicted_run_is_that_of_its_exact_run_which_comes_at_once(look):
    page = paused(look, "?E=70.6")
    point = grab(page, "delta_bar")
    page.mouse.move(*point(2))
    page.wait_for_function("punch.run.followed && punch.run.scene.delta_bar === 0.02")
    page.mouse.up()
    page.wait_for_function("!punch.run.few")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("End")
    page.keyboard.press("m")
    page.wait_for_function("punch.instead")
    assert not page.evaluate("Boolean(punch.run.followed)")
    page.keyboard.press("m")
