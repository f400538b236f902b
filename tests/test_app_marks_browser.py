"""Marks beside the sliders: computed for the scene on screen, not true of the default only."""

import pytest
from served import PATIENCE, finished

pytestmark = pytest.mark.browser


def marks(page):
    known = " && ".join(f"punch.status.marks.{name}" for name in ("delta_bar", "phi_ratio", "E"))
    page.wait_for_function(known, timeout=PATIENCE)
    return {name: {said: value for value, said in found} for name, found in page.evaluate("punch.status.marks").items()}


@pytest.mark.thorough
def test_marks_say_where_the_load_turns_and_where_sliding_is_smooth_for_the_scene_on_screen(visit):
    page = visit("?du_x=0.5")
    finished(page)
    first = marks(page)
    assert first["delta_bar"]["L = 0"] == pytest.approx(0.18, abs=0.02)
    assert -0.5 < first["delta_bar"]["jumps in"] < 0
    assert 1500 < first["E"]["slides smoothly"] <= 3000
    assert 0.01 < first["phi_ratio"]["slips"] < 0.03
    tick = page.locator("[data-name=delta_bar] .mark", has_text="L = 0").bounding_box()
    slider = page.locator("#delta_bar").bounding_box()
    place = (tick["x"] + tick["width"] / 2 - slider["x"]) / slider["width"]
    assert place == pytest.approx((1 + 0.183) / 2, abs=0.02)
    page.fill("#E-entry", "20")
    page.keyboard.press("Enter")
    finished(page, run=2)
    page.wait_for_function("punch.status.marks.delta_bar?.[0][0] > 0.3", timeout=PATIENCE)
    page.wait_for_function("document.getElementById('delta_bar-marked').textContent.includes('L = 0 at 0.')")
