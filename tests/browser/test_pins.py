"""Pinned runs in Chromium: overlays and links."""

import pytest
from served import MODEL, PATIENCE, finished, from_menu

from solver import Scene, load_path

pytestmark = [pytest.mark.thorough]


def lines(page, view):
    """How many lines of pinned runs a figure has."""
    return page.evaluate(f"{MODEL.format(f'{view}.pins')}.data_source.data.xs.length")


@pytest.mark.thorough
def test_a_run_can_be_pinned_hidden_and_removed_by_keyboard(look):
    page = look()
    finished(page)
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
    assert page.locator(".page").get_attribute("data-ghost") == "false"  # nothing pale over it
    # the force of the pinned run in N/m, whatever the stiffness of the run on screen
    pinned = page.evaluate(f"{MODEL.format('forces.pins')}.data_source.data.ys[0][50]")
    first = next(frame for frame in load_path(Scene()) if frame.stage == "shear" and frame.index == 50)
    assert pinned == pytest.approx(first.F_bar * 70 * 2500, rel=1e-4)  # N/m
    style = page.evaluate(
        f"(({{ colour, dash }}) => [colour[0], dash[0]])({MODEL.format('forces.pins')}.data_source.data)"
    )
    assert style == page.evaluate(
        "['--pin-1', '--pin-1-dash'].map((name) => getComputedStyle(document.documentElement).getPropertyValue(name))"
    )
    name.press("Enter")
    page.wait_for_function(f"() => {MODEL.format('forces.pins')}.data_source.data.xs.length === 0")
    assert name.get_attribute("aria-pressed") == "false"
    name.press("Space")
    chip.get_by_role("button", name="Remove Stick, peel, slip").press("Enter")
    page.wait_for_function(f"() => {MODEL.format('forces.pins')}.data_source.data.xs.length === 0")
    assert page.locator("#pins").is_hidden() and page.evaluate("document.activeElement.id") == "menu"


@pytest.mark.thorough
def test_pinned_runs_are_restored_from_the_address(visit):
    page = visit("?E=100&pin=Soft*E*20&pin=*preset*fig7-case2")
    finished(page)
    page.wait_for_function(f"() => {MODEL.format('area.pins')}.data_source.data.xs.length === 2", timeout=PATIENCE)
    assert page.locator(".chip").all_inner_texts()[0].startswith("Soft") or "Soft" in page.inner_text("#chips")
    assert page.evaluate("punch.status.values.E") == 100 and page.evaluate("punch.run.number") == 1
    page.get_by_role("button", name="Remove Soft").click()
    assert "Soft" not in page.url and "fig7-case2" in page.url


@pytest.mark.thorough
def test_a_pinned_run_of_a_link_that_fails_shows_why_and_can_be_removed(visit):
    page = visit("?pin=Lifted*nodes*64*width*160*radius*0.6*E*30*hold*load*delta_bar*-0.1")
    chip = page.locator(".chip", has_text="Lifted: failed")
    chip.wait_for(timeout=PATIENCE)
    assert page.inner_text("#pins-status").startswith("Lifted failed: ")
    page.get_by_role("button", name="Remove Lifted").click()
    assert not page.locator(".chip").count() and not page.locator("#pins").is_visible()
