"""The unstable branch in Chromium."""

import pytest
from served import finished

DASHED = "charts.forces.parts.between_F.list"


@pytest.mark.thorough
def test_the_unstable_branch_is_drawn_when_it_is_asked_for_and_goes_when_it_is_not(look):
    page = look("?phi_ratio=0.03&u_x_max=8&du_x=0.5")
    finished(page)
    assert page.evaluate(f"{DASHED}.length") == 0
    click = "document.getElementById('unstable').click()"
    page.evaluate(click)
    page.wait_for_function(f"{DASHED}.length === 1 && punch.unstable.length >= 2")
    assert page.evaluate(f"{DASHED}[0].dash.length") > 0
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")  # before all slips
    page.wait_for_function(f"{DASHED}[0].x[0] === punch.unstable[0].U_x[0]")
    page.keyboard.press("End")
    page.wait_for_function(f"{DASHED}[0].x[0] > punch.unstable[0].U_x[0]")  # that of the slip to come, or the last
    page.evaluate(click)
    page.wait_for_function(f"{DASHED}.length === 0")


@pytest.mark.thorough
def test_it_follows_a_held_slider_in_grey_until_the_run_is_exact(look):
    page = look("?phi_ratio=0.03&u_x_max=8&du_x=0.5")
    finished(page)
    page.evaluate("document.getElementById('unstable').click()")
    page.wait_for_function(f"{DASHED}.length === 1")
    own = page.evaluate(f"{DASHED}[0].ink")
    slider = page.locator(".control[data-name='phi_ratio'] input[type='range']")
    box = slider.bounding_box()
    middle = box["y"] + box["height"] / 2
    at = box["x"] + box["width"] * float(slider.evaluate("s => (s.value - s.min) / (s.max - s.min)"))
    page.mouse.move(at, middle)
    page.mouse.down()
    for step in range(1, 4):
        page.mouse.move(at + 2 * step, middle)
    page.wait_for_function(f"punch.run.followed && punch.follows && {DASHED}.length === 1")
    assert page.evaluate(f"{DASHED}[0].ink") != own
    page.mouse.up()
    page.wait_for_function(f"!punch.run.followed && !punch.follows && {DASHED}.length === 1")
    assert page.evaluate(f"{DASHED}[0].ink") == own
