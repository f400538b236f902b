"""Explanations of terms by click, key and touch, and their list below the theory."""

import pytest
from served import FAULTS, finished, from_menu, laid_out

from app.glossary import forms

pytestmark = [pytest.mark.thorough]
FETCHED = "performance.getEntriesByType('resource').filter(({ name }) => name.includes('glossary.html')).length"


def test_clicking_a_term_shows_its_explanation(look):
    page = look()
    term = page.locator("#narration .term, figcaption .term").first
    term.hover()
    assert page.locator("#term").is_hidden()
    term.click()
    page.locator("#term b").wait_for()
    page.mouse.click(2, 2)
    page.locator("#term").wait_for(state="hidden")


def test_a_term_in_a_caption_explains_and_its_heading_enlarges_the_plot(look):
    page = look()
    term = page.locator(".area figcaption .term").first
    if term.is_hidden():
        page.locator("#chosen label", has_text="Contact area").click()
        page.locator("#chosen label", has_text="Forces").click()
    main, heading = page.locator("main"), "document.querySelector('.{} figcaption > b').click()"
    page.evaluate(heading.format("forces"))
    page.evaluate("document.querySelector('.area figcaption .term').click()")
    page.locator("#term b").wait_for()
    assert main.get_attribute("data-chosen") == "forces"
    page.evaluate("document.getElementById('term').hidePopover()")
    page.evaluate(heading.format("area"))
    assert main.get_attribute("data-chosen") == "area" and page.locator("#term").is_hidden()
    assert not page.locator("main :is(.forces, .area, .map) figcaption > b .term").count()


@pytest.mark.thorough
def test_terms_in_the_sentence_are_explained_and_a_label_focuses_its_entry(look):
    page = look()
    page.locator("#sentence .term").first.click()
    page.locator("#term").wait_for()
    page.keyboard.press("Escape")
    page.locator(".control label", has_text="Stiffness").click()
    assert page.evaluate("document.activeElement.id") == "E-entry"
    assert not page.locator("label button").count()


@pytest.mark.thorough
def test_cautions_about_a_result_appear_behind_their_button(look):
    page = look("?preset=inertia")
    assert page.locator("#notes").is_hidden()
    page.locator("#caution").click()
    assert "may flutter" in page.inner_text("#cautions")


@pytest.mark.thorough
def test_enter_shows_and_announces_an_explanation_and_escape_hides_it(look):
    page = look()
    term = page.locator("#look .term").first
    term.focus()
    page.keyboard.press("Enter")
    page.locator("#term b").wait_for()
    assert page.inner_text("#announcement") == page.inner_text("#term")
    page.keyboard.press("Escape")
    page.locator("#term").wait_for(state="hidden")
    assert page.evaluate("document.activeElement.className") == "term"


@pytest.mark.thorough
def test_touching_a_term_loads_and_shows_its_explanation_on_screen_until_the_next_touch(visit):
    page = visit(has_touch=True)
    page.set_viewport_size({"width": 390, "height": 844})
    finished(page)
    assert page.evaluate(FETCHED) == 0
    page.locator("#sentence .term").last.tap()
    tip = page.locator("#term")
    tip.wait_for()
    laid_out(page)
    box = tip.bounding_box()
    assert box["x"] >= 0 and box["x"] + box["width"] <= 390 and box["y"] >= 0 and box["y"] + box["height"] <= 844
    assert page.evaluate(FETCHED) == 1 and not page.evaluate(FAULTS)
    page.locator("h1").tap()
    tip.wait_for(state="hidden")


@pytest.mark.thorough
def test_theory_lists_every_term_of_the_glossary(look):
    page = look()
    from_menu(page, "#open-theory")
    page.locator("#theory .glossary").wait_for()
    listed = page.locator("#theory .glossary [id^=term-]").evaluate_all("all => all.map((one) => one.id.slice(5))")
    assert set(listed) == set(forms().values()) >= {"traction", "gap", "work", "branch", "fold", "flutter", "peel"}
