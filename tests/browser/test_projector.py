"""Projector mode: large text and lines, the punch and one curve."""

import pytest
from served import from_menu

pytestmark = pytest.mark.thorough
PAINTED = """() => {  // the largest width of a line of the forces, and the font of their axes
    const pen = charts.forces.canvas.getContext("2d"), { stroke } = pen, widths = []
    pen.stroke = () => { widths.push(pen.lineWidth); stroke.call(pen) }
    charts.forces.changed = true
    charts.forces.paint()
    delete pen.stroke
    return [Math.max(...widths), pen.font.split(" ")[0]]
}"""


def test_key_p_switches_projector_mode_with_large_text_and_lines_on_and_off(look):
    page = look()
    thin, _ = page.evaluate(PAINTED)
    page.locator("body").press("p")
    assert "view=projector" in page.url
    page.wait_for_function(f"({PAINTED})()[1] === '19px'")
    assert page.evaluate(PAINTED)[0] >= 2 * thin
    assert page.locator("main figure:visible").count() == 2  # the punch and one curve
    from_menu(page, "#projector")
    assert "view=projector" not in page.url and "more=1" in page.url
    assert page.evaluate(PAINTED) == [thin, "13px"]
    assert page.locator("main figure:visible").count() > 2  # with more in sight, as before


def test_projector_mode_has_no_small_text_and_no_solver_statistics(look):
    page = look("?view=projector&delta_bar=0.2")
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
