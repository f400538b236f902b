"""The page for the school's technician, in Chromium."""

import pytest

pytestmark = pytest.mark.thorough
SIGNS = "() => [...document.querySelectorAll('#check li')].map(({ dataset }) => dataset.sign).join('')"


def test_check_ticks_what_works_and_says_who_else_may_open_the_address(visit):
    page = visit("?check&u_x_max=4", rests=False)
    page.wait_for_function(f"({SIGNS})() === '✓✓✓✓✓✗'")  # of a server of this computer alone
    assert "only this computer opens http://localhost" in page.inner_text("#check")


def test_check_names_a_script_that_does_not_arrive(server, browser):
    context = browser.new_context()
    context.route("**/*.js*", lambda route: route.abort())
    page = context.new_page()
    page.goto(server.address + "?check")
    page.locator("#check").get_by_text("have not arrived").wait_for()
    context.close()


def test_check_says_what_is_missing_on_a_small_screen(visit):
    page = visit("?check&u_x_max=4", rests=False, viewport={"width": 300, "height": 500})
    page.locator("#check li", has_text="Screen").get_by_text("300 × 500 px; needed: 320 × 360").wait_for()
