"""Browser history, and addresses that restore scene, increment and page."""

import pytest
from served import FAULTS, PARABOLA, PATIENCE, PLAYING, enter, from_menu, laid_out, values_are

pytestmark = pytest.mark.thorough


def test_back_and_forward_go_through_settled_changes_and_presets(visit):
    page = visit("?du_x=0.5&u_x_max=10")
    page.focus("#delta_bar")
    for _ in range(5):  # one movement of the hand is one change
        page.keyboard.press("ArrowRight")
    values_are(page, delta_bar=0.05)
    enter(page, "E", "200")
    values_are(page, delta_bar=0.05, E=200)
    page.wait_for_url("**E=200**")
    page.go_back()
    values_are(page, delta_bar=0.05, E=70)
    assert "E=" not in page.url and "delta_bar=0.05" in page.url
    page.go_back()
    values_are(page, delta_bar=0, E=70)
    page.go_forward()
    values_are(page, delta_bar=0.05, E=70)
    page.go_forward()
    values_are(page, delta_bar=0.05, E=200)
    assert page.input_value("#E-entry") == "200"
    page.select_option("#preset", "fig7-case2")
    values_are(page, delta_bar=0.4)
    page.wait_for_url("**preset=fig7-case2**")
    page.go_back()
    values_are(page, delta_bar=0.05, E=200)
    page.wait_for_function("punch.status.preset === 'fig6'")
    page.go_forward()
    values_are(page, delta_bar=0.4)
    page.wait_for_function("document.getElementById('preset').value === 'fig7-case2'")


def test_back_after_reset_restores_the_parameter_that_was_changed_last(visit):
    page = visit()
    enter(page, "E", "80")
    values_are(page, E=80)
    page.wait_for_url("**E=80**")
    page.get_by_role("button", name="Reset", exact=True).click()
    values_are(page, E=70)
    page.wait_for_function("!location.search.includes('E=')")
    page.go_back()
    values_are(page, E=80)


def test_back_after_reset_restores_an_uploaded_profile(visit, tmp_path):
    page = visit("?u_x_max=4&du_x=0.5")
    from_menu(page, "#parameters")
    (tmp_path / "wave.csv").write_text("x (nm),z (nm)\n" + PARABOLA)
    page.set_input_files("#profile", tmp_path / "wave.csv")
    page.get_by_role("button", name="Use it").click()
    values_are(page, surface="measured")
    curve = page.evaluate("punch.run.curves.F_bar")
    page.locator("#drawer").get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Reset", exact=True).click()
    values_are(page, surface="circular", width=2500)
    page.wait_for_function("!location.search.includes('profile=')")
    page.go_back()
    values_are(page, surface="measured", width=500)
    assert page.evaluate("punch.run.curves.F_bar") == curve
    page.reload()
    page.wait_for_function("() => window.punch?.status.values")
    values_are(page, surface="measured", width=500)
    assert page.evaluate("punch.run.curves.F_bar") == curve


def test_address_holds_the_increment_of_a_paused_run(visit):
    page = visit("?v=1&delta_bar=0.1&k=209")
    page.wait_for_function("punch.drawn === 209 && !punch.playing")
    page.locator("body").press("ArrowRight")
    page.wait_for_function("new URLSearchParams(location.search).get('k') === '210'")
    page.locator("body").press("Space")
    page.wait_for_function("!new URLSearchParams(location.search).has('k')")


def test_invalid_increments_in_the_address_are_harmless(visit):
    page = visit("?k=99999")
    page.wait_for_function("punch.drawn === punch.run.length - 1 && !punch.playing")
    page = visit("?k=-3", **PLAYING)
    page.wait_for_function("punch.drawn > punch.run.sheared + 1")  # it plays


def test_an_embedded_page_hides_header_and_pages_and_nothing_else(visit):
    page = visit("?embed=1&delta_bar=0.1&k=150&page=law&more=0")
    page.wait_for_function("punch.drawn === 150 && !punch.playing")
    assert not page.locator("header, .sheet").locator("visible=true").count()
    assert page.locator(".controls input[type=range]:visible").count() == 3
    assert page.locator("#play").is_visible() and page.locator("#scrub").is_visible()
    assert page.locator("figure:visible").count() == 2 and page.locator("#sentence").is_visible()  # punch and forces
    for width, height in ((960, 600), (800, 600), (844, 390), (600, 400), (400, 300), (320, 256)):
        laid_out(page, (width, height))
        assert page.locator("#punch-view").bounding_box()["height"] >= 140, (width, height)
        assert not page.evaluate(FAULTS), (width, height)
    enter(page, "delta_bar", "0.12")
    values_are(page, delta_bar=0.12)


def test_back_closes_a_page_also_before_the_server_has_answered(server, browser):
    page, errors = browser.new_page(reduced_motion="reduce"), []
    page.on("pageerror", lambda error: errors.append(error))
    page.route("**/bokeh.min.js", lambda route: None)  # so that nothing connects
    page.goto(server.address, wait_until="commit")
    page.wait_for_function("window.punch?.run?.stored && !punch.fresh", timeout=PATIENCE)
    from_menu(page, "nav [data-page=law]")
    page.locator("#law").wait_for()
    page.evaluate("history.back()")
    page.locator("#law").wait_for(state="hidden")
    assert not errors
    page.close()
