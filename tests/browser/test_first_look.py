"""The first look: one idea in sight, and what *More* and the tour add to it."""

import pytest
from served import FAULTS, finished, from_menu, laid_out
from tabs import at_stop

MOST = 16  # controls and marks at first sight
OPERABLE = """() => {
    const what = 'button, input, select, a[href], summary, [role=slider], [tabindex="0"], .mark, .view'
    const seen = (e) => e.checkVisibility({ visibilityProperty: true }) && !e.closest('[hidden], .unseen')
    const inSight = (box) => box.width > 1 && box.height > 1 && box.bottom > 0 && box.top < innerHeight
    return [...document.querySelectorAll(what)].filter(seen)
        .filter((e) => inSight((e.closest('label') ?? e).getBoundingClientRect()))
        .map((e) => e.id || e.textContent.trim() || e.className)
}"""
IDEA = "#punch-view", "#sentence", ".view[data-view=forces]", "#delta_bar", "#phi_ratio", "#E", "#play"
MORE = "#lens", "#bands", ".view[data-view=area]", ".view[data-view=map]", ".mark", "#readout"


@pytest.fixture
def first_visit(server, browser):
    """first_visit(query) -> the app in a browser that has stored nothing of it, once its run is finished."""
    context = browser.new_context(reduced_motion="reduce")

    def opened(query=""):
        page = context.new_page()
        page.goto(f"{server.address}{query}")
        finished(page)
        return page

    yield opened
    context.close()


def visible(page, parts):
    return [part for part in parts if page.locator(f"{part}:visible").count()]


def large(page):
    laid_out(page, (1440, 900))
    return page


def test_the_first_look_has_one_idea_and_at_most_sixteen_controls_and_marks(look):
    page = large(look("?more=0"))
    page.keyboard.press("End")  # with the button of slow motion
    page.locator("#slow").wait_for()
    found = page.evaluate(OPERABLE)
    assert len(found) <= MOST, found
    assert visible(page, IDEA) == list(IDEA) and visible(page, MORE) == []
    areas = [box["width"] * box["height"] for box in (page.locator(part).bounding_box() for part in IDEA)]
    assert areas[0] > 2 * max(areas[1:])  # the punch is the largest


def test_more_adds_its_parts_at_once_and_takes_them_away_again(look):
    page = large(look("?more=0"))
    page.get_by_role("button", name="More").click()
    for part in ("#lens", ".mark"):  # marks are searched after the run
        page.locator(part).first.wait_for()
    assert visible(page, MORE) == list(MORE) and "more=1" in page.url
    laid_out(page)
    assert page.evaluate(FAULTS) == []
    page.get_by_role("button", name="More").click()
    page.locator("#lens").wait_for(state="hidden")
    assert visible(page, MORE) == [] and "more=1" not in page.url


@pytest.mark.thorough
def test_more_is_remembered_and_is_part_of_a_shared_link(server, first_visit):
    page = first_visit()
    assert not page.evaluate("document.getElementById('more').ariaPressed === 'true'")
    page.get_by_role("button", name="More").click()
    from_menu(page, "#take")
    page.wait_for_function("document.getElementById('share-link').value.includes('more=1')")
    page.goto(server.address)
    assert page.evaluate("document.getElementById('more').ariaPressed === 'true'")


@pytest.mark.thorough
def test_a_link_with_more_shows_it_to_a_first_visitor(first_visit):
    page = first_visit("?more=1")
    page.locator("#readout").wait_for()


@pytest.mark.thorough
def test_the_hint_to_drag_goes_with_the_first_move_and_is_not_for_links(server, first_visit):
    page = first_visit()
    hint = page.locator("#grab")
    hint.wait_for()
    page.focus("#E")
    page.keyboard.press("ArrowRight")
    hint.wait_for(state="hidden")
    page.goto(f"{server.address}?preset=fig6")
    finished(page)
    assert hint.is_hidden()


@pytest.mark.thorough
@pytest.mark.parametrize(("stop", "part"), [(1, "#lens"), (2, ".view[data-view=map]"), (5, "#bands")])
def test_a_stop_of_the_tour_brings_one_part_of_more(look, stop, part):
    page = at_stop(large(look("?more=0")), stop)
    page.locator(part).first.wait_for()
    others = [other for other in ("#lens", "#bands", ".view[data-view=map]") if other != part]
    assert visible(page, others) == []
    page.get_by_role("button", name="End tour").click()
    page.locator(part).first.wait_for(state="hidden")
