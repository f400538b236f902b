"""The map of regimes in Chromium."""

import pytest
from served import finished

thorough = pytest.mark.thorough


DRAWN = {  # page: condition that its result is drawn
    "law": "(charts.law_shear_map?.parts.stick.x.length > 50 && document.getElementById('law-stick').textContent)",
    "load": "(parseInt(document.getElementById('load-count').textContent) > 0)",
    "matters": "(document.querySelectorAll('#matters-bars button').length > 5)",
    "regimes": "document.getElementById('regimes-text').textContent.includes(' points')",  # its first tile
}


TINY = "nodes=64&width=160&radius=0.6&du_x=0.5&du_z=0.5"  # for pages of many runs


@thorough
def test_choosing_the_same_parameter_for_both_map_axes_swaps_them(look):
    page = look("?page=regimes")
    page.wait_for_function("document.getElementById('regimes-text').textContent")
    page.select_option("#regimes-x", "phi_ratio")
    assert page.input_value("#regimes-y") == "delta_bar"
    page.select_option("#regimes-y", "phi_ratio")
    assert page.input_value("#regimes-x") == "delta_bar"


@thorough
def test_a_drag_on_the_map_ends_where_the_button_is_let_go_also_outside_and_the_right_button_drags_nothing(look):
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}")
    page.wait_for_function("charts.regimes_map.box && charts.regimes_map.parts.map.picture")
    box = page.locator("#regimes .view").bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down(button="right")
    page.mouse.move(x + 40, y + 20)
    page.mouse.up(button="right")
    assert page.evaluate("[punch.dragging, punch.waiting.length]") == [False, 0]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y + 20)
    page.wait_for_function("punch.dragging")
    page.mouse.move(x + 40, box["y"] - 30)
    page.mouse.up()
    page.wait_for_function("!punch.dragging && !punch.waiting.length && punch.status.values.phi_ratio === 2")
    there = page.evaluate("JSON.stringify(punch.status.values)")
    page.mouse.move(x, y)
    page.mouse.move(x - 40, y)
    page.wait_for_function("!punch.fresh")
    assert page.evaluate("[punch.dragging, JSON.stringify(punch.status.values)]") == [False, there]


@thorough
def test_the_choices_of_the_map_are_those_of_what_is_shown_when_it_is_opened_again(look):
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}")
    page.select_option("#regimes-of", "A_s")
    page.select_option("#regimes-x", "E")
    page.wait_for_function("charts.regimes_map.across.startsWith('stiffness')")
    page.locator("#regimes .close").click()
    page.wait_for_function("() => Bokeh.documents[0].roots()[0].data.opened.open === undefined")
    page.evaluate("document.querySelector('nav [data-page=regimes]').click()")
    page.wait_for_function("charts.regimes_map.across.startsWith('press')")
    assert [page.input_value(f"#regimes-{name}") for name in ("x", "y", "of")] == ["delta_bar", "phi_ratio", "F_s"]


@thorough
def test_clicking_the_map_shows_the_scene_of_that_place(look):
    """The axes of the map are delta_bar and phi_ratio; what is pointed at is read out, and a click goes there."""
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}")
    before = page.evaluate("(({ delta_bar, phi_ratio }) => [delta_bar, phi_ratio])(punch.status.values)")
    frame = page.evaluate("(({ left, top, width, height }) => ({ left, top, width, height }))(charts.regimes_map.box)")
    box = page.locator("#regimes .view").bounding_box()
    x, y = box["x"] + frame["left"] + 0.7 * frame["width"], box["y"] + frame["top"] + 0.3 * frame["height"]
    page.mouse.move(x, y)
    said = page.wait_for_function(
        "(({ pointed }) => pointed && charts.regimes_map.says(charts.regimes_map.placeOf(pointed)))(charts.regimes_map)"
    ).json_value()
    assert [line.split(":")[0] for line in said[:2]] == ["press depth δ/δ₀", "friction / adhesion φₜ/φₙ"]
    page.mouse.click(x, y)
    changed = f"punch.status.values.delta_bar > {before[0]} && punch.status.values.phi_ratio !== {before[1]}"
    page.wait_for_function(changed)
    finished(page, run=2)
    assert page.evaluate("punch.run.scene.delta_bar === punch.status.values.delta_bar && !punch.run.followed")
