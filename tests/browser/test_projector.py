"""Projector mode: large text and lines, the punch and one curve."""

import pytest
from served import finished, from_menu

pytestmark = [pytest.mark.thorough]
MODEL = "[...Bokeh.documents[0]._all_models.values()].find((model) => model.name === '{}')"
WIDTH = f"(({{ line_width: w }}) => w.value ?? w)({MODEL.format('forces.F')}.glyph)"
FONT = "[...Bokeh.documents[0]._all_models.values()].find((m) => m.name === 'forces' && m.below).below[0]"
FONT += ".major_label_text_font_size"


def test_key_p_switches_projector_mode_with_large_text_and_lines_on_and_off(look):
    page = look()
    finished(page)
    thin = page.evaluate(WIDTH)
    page.locator("body").press("p")
    assert "view=projector" in page.url
    page.wait_for_function(f"() => {FONT} === '19px'")
    assert page.evaluate(WIDTH) >= 2 * thin
    assert page.locator("main figure:visible").count() == 2  # the punch and one curve
    from_menu(page, "#projector")
    assert "view=projector" not in page.url and "more=1" in page.url
    page.wait_for_function(f"() => {FONT} === '13px'")
    assert page.evaluate(WIDTH) == thin
    assert page.locator("main figure:visible").count() > 2  # with more in sight, as before


@pytest.mark.thorough
def test_projector_mode_has_no_small_text_and_no_solver_statistics(look):
    page = look("?view=projector&delta_bar=0.2")
    finished(page)
    page.keyboard.press("End")
    said = page.inner_text(".page")
    assert not any(word in said for word in ("increments", "residual", "evaluations"))
    small = page.evaluate(
        """() => [...document.querySelectorAll('.page :is(b, p, label, select, button, span, figcaption)')]
            .filter((e) => e.checkVisibility() && !e.closest('.unseen, #row, .hero .key'))
            .filter((e) => e.childElementCount === 0 && e.textContent.trim())
            .filter((e) => parseFloat(getComputedStyle(e).fontSize) < 17).map((e) => e.outerHTML)"""
    )
    assert not small
    page.keyboard.press("c")
    assert page.locator("figure.area").is_visible() and not page.locator("figure.forces").is_visible()
