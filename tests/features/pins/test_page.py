"""Pinned runs in Chromium."""

import pytest
from served import finished, from_menu

from solver import Scene, load_path

pytestmark = pytest.mark.thorough


def lines(page, view):
    """How many lines of pinned runs a figure has."""
    return page.evaluate(f"charts.{view}.parts.pins.list.length")


def test_a_run_can_be_pinned_hidden_and_removed_by_keyboard(look):
    page = look()
    page.locator("body").press("End")
    from_menu(page, "#pin")
    chip = page.locator(".chip")
    chip.wait_for()
    name = chip.get_by_role("button", name="Show")
    page.wait_for_function("""() => {  // chips are made anew at each change
        const { color, backgroundColor } = getComputedStyle(document.querySelector(".chip button"))
        return color && color !== backgroundColor
    }""")
    page.focus("#E")
    page.keyboard.press("ArrowRight")
    finished(page, run=2)
    assert [lines(page, view) for view in ("forces", "area", "map", "punch")] == [2, 1, 2, 1]
    assert not page.locator(".key .ghost").is_visible()  # nothing pale over it
    # the force of the pinned run in N/m, whatever the stiffness of the run on screen
    pinned = page.evaluate("charts.forces.parts.pins.list[0].y[50]")
    first = next(frame for frame in load_path(Scene()) if frame.stage == "shear" and frame.index == 50)
    assert pinned == pytest.approx(first.F_bar * 70 * 2500, rel=1e-4)  # N/m
    assert page.evaluate("charts.forces.parts.pins.list[0].ink") == "--pin-1"
    name.press("Enter")
    page.wait_for_function("() => charts.forces.parts.pins.list.length === 0")
    assert name.get_attribute("aria-pressed") == "false"
    name.press("Space")
    chip.get_by_role("button", name="Remove Stick, peel, slip").press("Enter")
    page.wait_for_function("() => charts.forces.parts.pins.list.length === 0")
    assert page.locator("#pins").is_hidden() and page.evaluate("document.activeElement.id") == "menu"


def test_pins_stay_out_of_links_and_an_older_link_with_pins_opens_without_them(visit):
    page = visit("?u_x_max=4&du_x=0.5&pin=Soft*E*20")
    assert not page.locator(".chip").count() and not page.inner_text("#notes")
    from_menu(page, "#pin")
    page.locator(".chip").wait_for()
    from_menu(page, "#take")
    assert "pin=" not in page.input_value("#share-link") and page.url.count("pin=") == 1  # that of the older link
