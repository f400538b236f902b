"""Terms of the field, explained where they appear: by mouse, keyboard and touch, and all of them below the theory."""

import pytest
from served import FAULTS, finished, laid_out

from app.glossary import forms

pytestmark = [pytest.mark.browser, pytest.mark.thorough]
FETCHED = "performance.getEntriesByType('resource').filter(({ name }) => name.includes('glossary.html')).length"


def test_a_term_is_explained_on_hover_and_nothing_is_loaded_before(look):
    page = look()
    assert page.evaluate(FETCHED) == 0
    page.locator(".term", has_text="Traction").hover()
    tip = page.get_by_role("tooltip").filter(has_text="Force per area")
    tip.wait_for()
    tip.hover()  # it can be reached and read
    assert tip.is_visible() and page.evaluate(FETCHED) == 1
    page.locator("#readout").hover()
    tip.wait_for(state="hidden")


@pytest.mark.thorough
def test_what_the_sentence_and_the_sliders_name_is_explained_there(look):
    page = look()
    page.locator("#sentence .term").first.click()
    page.locator("#term").wait_for()
    page.locator(".control .term", has_text="Stiffness").click()
    page.locator("#term", has_text="Young").wait_for()


@pytest.mark.thorough
def test_what_to_mind_in_a_result_is_said_behind_a_button(look):
    page = look("?preset=rough")
    assert page.locator("#notes").is_hidden()
    page.locator("#caution").click()
    assert "may flutter" in page.inner_text("#cautions")


@pytest.mark.thorough
def test_the_keyboard_shows_it_and_escape_takes_it_away_and_a_press_has_it_read_out(look):
    page = look()
    term = page.locator("#look .term").first
    term.focus()
    tip = page.locator("#term")
    tip.wait_for()
    assert term.get_attribute("aria-describedby") == "term"
    page.keyboard.press("Enter")
    page.wait_for_function(
        "document.getElementById('told').textContent === document.getElementById('term').textContent"
    )
    page.keyboard.press("Escape")
    tip.wait_for(state="hidden")
    assert page.evaluate("document.activeElement.className") == "term"


@pytest.mark.thorough
def test_a_touch_keeps_it_until_the_next_elsewhere_and_it_stays_on_the_screen(visit):
    page = visit(has_touch=True)
    page.set_viewport_size({"width": 390, "height": 844})
    finished(page)
    page.locator("#look .term").last.tap()
    tip = page.locator("#term")
    tip.wait_for()
    laid_out(page)
    box = tip.bounding_box()
    assert box["x"] >= 0 and box["x"] + box["width"] <= 390 and box["y"] >= 0 and box["y"] + box["height"] <= 844
    assert not page.evaluate(FAULTS)
    page.locator("h1").tap()
    tip.wait_for(state="hidden")


@pytest.mark.thorough
def test_every_term_is_listed_with_the_theory(look):
    page = look()
    page.locator("#open-theory").click()
    page.locator("#theory .glossary").wait_for()
    listed = page.locator("#theory .glossary [id^=term-]").evaluate_all("all => all.map((one) => one.id.slice(5))")
    assert set(listed) == set(forms().values()) >= {"traction", "gap", "work", "branch", "fold", "flutter", "peel"}
