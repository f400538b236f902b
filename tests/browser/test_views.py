"""The views of the experiment in Chromium: their models and texts."""

import re

import pytest
from served import finished, paused_at

pytestmark = pytest.mark.thorough


def test_a_deeply_pressed_punch_stays_in_a_fixed_view(look):
    page = look("?E=3000&delta_bar=1&theme=light")
    start = "charts.punch.y.start"
    lowest = page.evaluate("punch.run.lowest")
    low = page.evaluate(start)
    assert low < lowest < -2.0
    for frame in (110, 300):
        paused_at(page, frame)
        assert page.evaluate(start) == low
        assert page.evaluate(f"Math.min(...punch.run.frame({frame}).gap)") >= lowest


def test_weakly_attracted_nodes_are_free_but_not_those_at_a_sign_change(look):
    page = look()
    paused_at(page, 110)
    states = ("free", "adhering", "repulsive", "contact")
    drawn = {s: page.evaluate(f"[...charts.punch.parts.{s}.y]") for s in states}
    tractions = page.evaluate("((at) => [...at.T_n].filter((_, i) => at.state(i) === 'free'))(punch.run.frame(110))")
    peak = page.evaluate("punch.run.head.adhesion")
    assert min(drawn["free"]) > 4.0 and min(tractions) > -0.05 * peak and not drawn["contact"]
    assert max(drawn["repulsive"]) < min(drawn["adhering"]) < 0.1
    assert "5 %" in page.get_attribute("figure .key span[title]", "title")


def test_a_flat_fills_the_view_and_hides_lens_contact_area_and_map(look):
    page = look("?preset=fig4a-blue")
    half = page.evaluate("charts.punch.x.end")
    for frame in (150, 400):
        paused_at(page, frame)
        x = page.evaluate("[...charts.punch.parts.contact.x]")
        assert min(x) <= -half and max(x) >= half
    assert page.evaluate("charts.punch.parts.contact.x.length") == len(x)
    assert page.locator("#lens").is_hidden()
    page.set_viewport_size({"width": 1600, "height": 1100})  # there is room for the key
    page.locator("figure >> nth=0").get_by_text("in contact").wait_for()
    assert "in contact" in page.inner_text("figure >> nth=0") and "adhering" not in page.inner_text("figure >> nth=0")
    for name in ("Contact area", "Contact map"):
        assert page.locator(f"figure[aria-label^='{name}']").is_hidden()
    page.select_option("#preset", "fig6")
    finished(page, run=2)
    page.locator("figure[aria-label^='Contact map'] .view").wait_for(state="visible")


def test_exaggeration_factors_and_zeros_are_plain_numbers(look):
    page = look("?preset=unload")
    page.set_viewport_size({"width": 1280, "height": 4000})  # narrow and high: more than a hundredfold
    finished(page)
    page.locator("#solver-figures").click()
    page.locator("#scales", has_text=re.compile("heights [1-9][0-9]0 times")).wait_for()
    page.keyboard.press("Escape")
    tiny = page.evaluate("punch.run.curves.F_bar.findIndex((F) => F < 0 && F > -4e-7)")
    assert tiny >= 0
    paused_at(page, tiny)
    assert "F = 0 N/m" in page.inner_text("#readout")


def test_jumps_are_marked_on_the_load_curve_during_unloading(look):
    page = look("?preset=unload")
    jumps = page.evaluate("[...charts.forces.parts.slips.y]")
    assert jumps and max(jumps) < -0.05  # 10^-3, tensile; the friction is zero
    assert "jump" in page.inner_text("figure[aria-label^='Friction']")
    page.select_option("#preset", "fig6")
    finished(page, run=2)
    assert min(page.evaluate("[...charts.forces.parts.slips.y]")) > 0.5
    assert "jump" not in page.inner_text("main")


def test_contact_map_of_a_loop_shows_slips_of_the_current_leg_only(look):
    page = look("?preset=loop")
    slips = "charts.map.parts.slips.x.length"
    for stage in ("shear", "back", "forth"):
        paused_at(page, page.evaluate(f"punch.run.curves.stage.lastIndexOf(punch.run.head.stages.indexOf('{stage}'))"))
        own = page.evaluate(
            f"punch.run.curves.slip.filter((slip, k) => slip && punch.run.stage(k) === '{stage}').length"
        )
        assert 0 < own < page.evaluate("punch.run.curves.slip.filter((slip) => slip).length")
        page.wait_for_function(f"() => {slips} === {own}")
