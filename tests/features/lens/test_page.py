"""The lens in Chromium."""

import pytest

pytestmark = pytest.mark.thorough


OWN = "?preset=fig6&theme=light"  # of the two tests that leave the page changed


def test_lens_shows_the_trailing_edge_until_it_is_moved(look):
    page = look(OWN)
    lens = page.locator("#lens")
    place = "Number(document.getElementById('lens').getAttribute('aria-valuenow'))"
    assert page.evaluate(place) < -50  # of a contact of some 180 nm
    lens.focus()
    before, drawn = page.evaluate(place), page.evaluate("punch.drawn")
    page.keyboard.press("PageUp")
    page.wait_for_function(f"() => {place} > {before} + 24")
    assert page.evaluate("punch.drawn") == drawn  # the key was the lens's
    assert "gap" in lens.get_attribute("aria-valuetext")


def test_lens_shows_the_first_adhering_crest_before_contact(look):
    page = look("?preset=wave")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    k = page.evaluate("punch.run.curves.slip.findIndex((slip, i) => slip && i > 0)")  # a crest jumps in
    page.evaluate(f"punch.at = {k - 1}")
    page.keyboard.press("ArrowRight")
    page.wait_for_function(f"() => punch.drawn === {k}")
    place = page.locator("#lens")
    assert float(place.get_attribute("aria-valuenow")) == pytest.approx(-625, abs=5)  # a quarter of the cell
    assert place.get_attribute("aria-valuetext").endswith("adhering")
    assert page.inner_text("#readout").endswith("JUMP")
