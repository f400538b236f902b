"""The page *What matters* in Chromium."""

import pytest
from served import finished

thorough = pytest.mark.thorough


@thorough
def test_page_what_matters_marks_the_punch_while_it_is_open_and_a_bar_raises_its_parameter(look):
    page = look()
    colours = """(() => {
        const { canvas } = charts.punch, pen = canvas.getContext("2d")
        return [...pen.getImageData(0, 0, canvas.width, canvas.height).data].reduce((sum, value) => sum + value, 0)
    })()"""
    finished(page)
    page.wait_for_function("!punch.fresh && punch.drawn === punch.run.length - 1")
    alone = page.evaluate(colours)
    page.evaluate("document.querySelector('nav button[data-page=matters]').click()")
    page.locator("#matters-bars button").first.wait_for()
    names = page.locator("#matters-bars span").all_inner_texts()
    assert len(names) > 5 and not any("periodic cell" in name for name in names)
    page.wait_for_function(f"() => !punch.fresh && {colours} !== {alone}")
    page.evaluate("document.querySelector('nav button[data-page=\"\"]').click()")
    page.wait_for_function(f"() => !punch.fresh && {colours} === {alone}")
    page.evaluate("document.querySelector('nav button[data-page=matters]').click()")
    page.locator("#matters-bars button", has_text="tiffness").click()
    page.wait_for_function("punch.status.values.E === 73.5")
    finished(page, run=2)
