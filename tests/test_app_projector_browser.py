"""Projector mode: text and lines for the back row, three views, nothing of the solver."""

import re

import pytest
from served import FAULTS, finished, laid_out

pytestmark = pytest.mark.browser
MODEL = "[...Bokeh.documents[0]._all_models.values()].find((model) => model.name === '{}')"
WIDTH = f"(({{ line_width: w }}) => w.value ?? w)({MODEL.format('forces.F')}.glyph)"
FONT = "[...Bokeh.documents[0]._all_models.values()].find((m) => m.name === 'forces' && m.below).below[0]"
FONT += ".major_label_text_font_size"


def test_a_key_makes_text_and_lines_large_and_the_same_key_takes_it_back(visit):
    page = visit()
    finished(page)
    thin = page.evaluate(WIDTH)
    page.locator("body").press("p")
    assert "view=projector" in page.url
    assert page.evaluate(FONT) == "24px" and page.evaluate(WIDTH) >= 2 * thin
    assert page.locator("main figure:visible").count() == 3
    page.get_by_role("button", name="Projector").click()
    assert "view=" not in page.url
    assert page.evaluate(FONT) == "13px" and page.evaluate(WIDTH) == thin
    assert page.locator("main figure:visible").count() == 5


@pytest.mark.thorough
def test_the_address_opens_it_with_large_values_and_no_words_of_the_solver(visit):
    page = visit("?view=projector&delta_bar=0.2")
    finished(page)
    page.locator("body").press("Space")
    page.keyboard.press("End")
    F, A = page.evaluate("[punch.run.curves.F_bar.at(-1) * punch.run.head.force, punch.run.curves.A_bar.at(-1)]")
    width = page.evaluate("punch.status.values.width")
    shown = page.inner_text("#large")
    assert float(shown.split("F =")[1].split()[0].replace("−", "-")) == pytest.approx(F, rel=0.01)
    assert float(shown.split("A =")[1].split()[0]) == pytest.approx(A * width, abs=0.6)
    page.select_option("#preset", "unload")  # nothing slides there
    finished(page, run=2)
    page.keyboard.press("Escape")
    assert re.fullmatch(r"load L = [−\d.]+ N/m", page.locator("#large span").first.inner_text())
    page.select_option("#preset", "rough")
    finished(page, run=3)
    page.wait_for_function("punch.mapped")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    page.keyboard.press("]")  # 'slip: so many of so many nodes ...'
    slip, view = page.locator("#slip").bounding_box(), page.locator("#punch-view").bounding_box()
    assert view["x"] <= slip["x"] and slip["x"] + slip["width"] <= view["x"] + view["width"]
    said = page.inner_text(".page")
    assert not any(word in said for word in ("increments", "residual", "evaluations"))
    small = page.evaluate(
        """() => [...document.querySelectorAll('.page :is(b, label, select, button, span, figcaption)')]
            .filter((e) => e.checkVisibility() && e.childElementCount === 0 && e.textContent.trim())
            .filter((e) => parseFloat(getComputedStyle(e).fontSize) < 22).map((e) => e.outerHTML)"""
    )
    assert not small
    for size in ((1280, 720), (1920, 1080)):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        laid_out(page)
        assert not page.evaluate(FAULTS)
