"""Marks beside the sliders, computed for the scene on screen."""

import pytest
from served import enter, finished


def marks(page):
    known = " && ".join(f"punch.status.marks.{name}" for name in ("delta_bar", "phi_ratio", "E"))
    page.wait_for_function(known)
    return {name: {said: value for value, said in found} for name, found in page.evaluate("punch.status.marks").items()}


@pytest.mark.thorough
@pytest.mark.parametrize("query", ["", "?preset=fig4a-blue"])
def test_slider_mark_labels_cover_their_tick_and_a_flat_has_no_fringe_legend(look, query):
    page = look(query)
    page.set_viewport_size({"width": 1440, "height": 900})
    marks(page)
    places = """() => [...document.querySelectorAll('.mark span')].map((words) => {
        const of = words.parentElement.getBoundingClientRect(), { left, right } = words.getBoundingClientRect()
        return [left, of.left + of.width / 2, right]
    })"""
    assert all(left <= at <= right for left, at, right in page.evaluate(places))
    assert page.locator(".key .fringe").is_visible() == ("preset" not in query)


@pytest.mark.thorough
def test_slider_marks_show_zero_load_and_smooth_sliding_of_the_current_scene(look):
    page = look("?du_x=0.5")
    first = marks(page)
    assert first["delta_bar"]["no load"] == pytest.approx(0.18, abs=0.02)
    assert -0.5 < first["delta_bar"]["jumps in"] < 0
    assert 1500 < first["E"]["slides smoothly"] <= 3000
    assert 0.01 < first["phi_ratio"]["slips above"] < 0.03
    tick = page.locator("[data-name=delta_bar] .mark", has_text="no load").bounding_box()
    slider = page.locator("#delta_bar").bounding_box()
    place = (tick["x"] + tick["width"] / 2 - slider["x"]) / slider["width"]
    assert place == pytest.approx((1 + 0.183) / 2, abs=0.02)
    enter(page, "E", "20")
    finished(page, run=2)
    page.wait_for_function("punch.status.marks.delta_bar?.[0][0] > 0.3")
    page.wait_for_function("document.getElementById('delta_bar-marked').textContent.includes('no load at 0.')")


@pytest.mark.thorough
def test_clicking_a_mark_moves_the_slider_there(look):
    page = look("?du_x=0.5")
    marks(page)
    page.locator("[data-name=delta_bar] .mark", has_text="no load").click()
    page.wait_for_function("Math.abs(punch.status.values.delta_bar - 0.18) <= 0.02")
    finished(page, run=2)
