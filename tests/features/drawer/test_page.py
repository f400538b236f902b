"""The parameter drawer: its layout, search, restoring values and error messages."""

import pytest
from served import FAULTS, enter, finished, from_menu, laid_out

pytestmark = pytest.mark.thorough
QUICK = "nodes=256&width=625&radius=600&u_x_max=4"  # a run that is soon there


@pytest.mark.once
@pytest.mark.parametrize("size", [(1440, 900), (1024, 768), (390, 844)])
def test_views_make_room_for_the_parameter_drawer(look, size):
    page = look()
    page.set_viewport_size({"width": size[0], "height": size[1]})
    finished(page)
    from_menu(page, "#parameters")
    drawer = page.get_by_role("dialog", name="Parameters")
    drawer.wait_for()
    laid_out(page)
    assert page.evaluate(FAULTS) == []
    page.locator("main figure:visible").last.scroll_into_view_if_needed()
    page.mouse.wheel(0, 5000)
    page.wait_for_function("() => scrollY + innerHeight >= document.documentElement.scrollHeight - 1")
    figure, box = page.locator("main figure:visible").last.bounding_box(), drawer.bounding_box()
    assert figure["x"] + figure["width"] <= box["x"] + 1 or figure["y"] + figure["height"] <= box["y"] + 1
    page.keyboard.press("Escape")
    drawer.wait_for(state="hidden")
    page.wait_for_function("document.activeElement.id === 'menu'")


def test_drawer_shows_applicable_parameters_searches_and_restores_them(look):
    page = look(f"?surface=rough&{QUICK}")
    from_menu(page, "#parameters")
    shown = lambda name: page.locator(f"#{name}-entry").is_visible()  # noqa: E731
    page.locator("#hurst-entry").wait_for()
    assert shown("u_x_max") and not shown("radius") and not shown("amplitude")
    page.select_option("#surface-entry", "wave")
    finished(page, run=2)
    page.wait_for_function("() => document.getElementById('amplitude-entry').checkVisibility()")
    assert not shown("hurst")
    page.get_by_label("Find a parameter").fill("surface energy")  # another word for it
    assert shown("phi_n") and not shown("nu")
    page.get_by_label("Find a parameter").fill("poisson")
    assert shown("nu") and not shown("amplitude")
    enter(page, "nu", "0,3")
    finished(page, run=3)
    assert page.evaluate("punch.status.values.nu") == 0.3 and "decimal point" in page.inner_text("#notes")
    page.get_by_role("button", name="Poisson's ratio of the layer: as in the preset").click()
    finished(page, run=4)
    assert page.evaluate("punch.status.values.nu") == 0.45


def test_a_rejected_surface_falls_back_with_a_reason(look):
    page = look()
    from_menu(page, "#parameters")
    page.select_option("#surface-entry", "measured")
    page.locator("#surface-error").wait_for()
    assert page.input_value("#surface-entry") == "circular"
