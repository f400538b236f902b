"""The tour and the theory page, in a real Chromium."""

import pytest
from served import FAULTS, PATIENCE, laid_out

pytestmark = pytest.mark.browser


def asked(page):
    page.locator("#tour-card button.answer").first.wait_for(timeout=PATIENCE)


def test_a_stop_hides_the_future_until_a_guess_then_plays_and_says_why(visit):
    page = visit("?tour=2")
    asked(page)
    assert "2 of 6: Peel" in page.locator("#tour-card").inner_text()
    assert page.evaluate("punch.drawn === punch.run.sheared && punch.status.preset") == "fig7-case2"
    hidden = page.locator(".future").first.bounding_box()
    assert hidden["width"] > 0.8 * page.locator(".view[data-view=forces]").bounding_box()["width"] - 90
    assert page.locator("#scrub").is_hidden()  # nothing but the question
    page.evaluate("punch.speed = 20")
    page.locator("button.answer", has_text="leading edge").click()
    page.locator("#tour-card [role=status]").wait_for(timeout=PATIENCE)
    assert page.locator("#tour-card [role=status]").inner_text().startswith("Not so.")
    assert "trailing edge" in page.locator("button[data-mark=right]").inner_text()
    assert page.evaluate("punch.run.curves.U_x[punch.drawn]") == pytest.approx(12.5, abs=0.11)  # not behind the slip
    assert page.locator(".future:visible").count() == 0
    page.get_by_role("button", name="Your turn").click()
    assert page.evaluate("document.activeElement.id") == "delta_bar" and page.locator("#scrub").is_visible()
    page.get_by_role("button", name="Next: Slip and reattach").click()
    asked(page)
    assert "tour=3" in page.url


@pytest.mark.thorough
def test_a_curve_can_be_sketched_before_the_run_draws_itself(visit):
    page = visit("?tour=3")
    asked(page)
    box = page.locator("#tour-sketch").bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.4 * box["height"], steps=8)
    page.mouse.up()
    inked = (
        "(() => { const c = document.getElementById('tour-sketch');"
        " return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v) })()"
    )
    page.wait_for_function(inked)
    page.get_by_role("button", name="End tour").click()
    page.locator("#tour-card").wait_for(state="hidden")
    assert "tour=" not in page.url and page.locator(".future:visible").count() == 0


COVERED = """() => {
    const box = (e) => e.getBoundingClientRect(), card = box(document.getElementById('tour-card'))
    const views = [...document.querySelectorAll('main figure')].filter((e) => e.checkVisibility())
    return [views.length, views.filter((e) => box(e).bottom > card.top + 1 && box(e).right > card.left + 1
        && box(e).top < card.bottom).length, card.bottom > innerHeight]
}"""


@pytest.mark.thorough
@pytest.mark.parametrize("query", ["", "&view=projector"])
def test_the_card_leaves_punch_forces_and_area_in_sight(visit, query):
    page = visit(f"?tour=3{query}")
    asked(page)
    for phase in ("ask", "why", "turn"):
        for width, height in ((1920, 1080), (1440, 900), (1280, 720), (1024, 768)):
            page.set_viewport_size({"width": width, "height": height})
            laid_out(page)
            assert page.evaluate(COVERED) == [3, 0, False] and not page.evaluate(FAULTS), (phase, width)
        if phase == "ask":
            page.evaluate("punch.speed = 20")
            page.locator("button.answer").first.click()
            page.locator("#tour-card [role=status]").wait_for(timeout=PATIENCE)
        elif phase == "why":
            page.get_by_role("button", name="Your turn").click()


@pytest.mark.thorough
def test_on_a_phone_the_punch_is_above_the_question(visit):
    page = visit("?tour=1")
    page.set_viewport_size({"width": 390, "height": 844})
    asked(page)
    laid_out(page)
    forces, card = page.locator("div[data-view=forces]").bounding_box(), page.locator("#tour-card").bounding_box()
    assert page.locator("#punch-view").bounding_box()["y"] > 0
    assert forces["y"] + forces["height"] < card["y"] and card["y"] + card["height"] <= 844
    assert not page.evaluate(FAULTS)


def test_the_theory_is_typeset_without_loading_anything_from_elsewhere(look):
    page = look()
    page.locator("#open-theory").click()
    page.locator("#theory math").first.wait_for()
    assert page.locator("#theory math").count() >= 11
    assert "Khajeh Salehani" in page.locator("#theory").inner_text()
    page.keyboard.press("Escape")
    page.locator("#theory").wait_for(state="hidden")
