"""The tour and the theory page in Chromium."""

from contextlib import suppress

import pytest
from served import FAULTS, SETTLE, TookTooLong, from_menu, laid_out
from tabs import asked, at_stop, imported


@pytest.mark.thorough
def test_tour_goes_back_one_stop_and_reports_a_failed_run(visit):
    page = visit("?tour=2&more=0", rests=False)
    asked(page)
    assert "tour=" not in page.url  # a link from here does not open the tour
    page.evaluate("punch.speed = 40")
    page.locator("button.answer").nth(0).click()
    page.get_by_role("button", name="Previous").wait_for()
    imported(page, "channel", "status").evaluate(
        """() => {  // from now on every run fails
            const { channel: { take }, status: { heard } } = modules
            take("status", (status) => heard({ ...status, state: "failed", why: "It fluttered." }))
        }"""
    )
    page.get_by_role("button", name="Previous").click()
    page.locator("#tour-card h2", has_text="1 of 9").wait_for()
    page.locator("#tour-card p", has_text="The run of this stop failed: It fluttered. Go to another stop.").wait_for()
    page.get_by_role("button", name="Next: The edges").click()
    page.locator("#tour-card h2", has_text="2 of 9").wait_for()


@pytest.mark.thorough
@pytest.mark.parametrize("stop", [2, 6, 7])
def test_a_tour_stop_gives_one_order_for_its_whole_scene(look, stop):
    """A second order for its values showed another scene in between, at worst the answer."""
    page = look("?more=0")
    page.evaluate(
        """() => {
            const stage = Bokeh.documents[0].roots().find(({ name }) => name === 'Wire').data
            const watch = (name) => stage.properties[name].change.connect(() => ordered.push(name))
            window.watching ??= ["scene", "restore"].map(watch)
            window.ordered = []
        }"""
    )
    at_stop(page, stop)
    assert page.evaluate("ordered") == ["restore"]


@pytest.mark.thorough
def test_browser_back_ends_the_tour(visit):
    page = visit("?E=100&more=0")
    page.evaluate("history.pushState({ entry: 1 }, '', location.href)")
    page.locator("#tour").click()
    asked(page)
    page.go_back()
    page.locator("#tour-card").wait_for(state="hidden")


@pytest.mark.thorough
def test_tour_stop_without_load_shows_remaining_friction(look):
    page = at_stop(look("?more=0"), 8)
    page.locator("#tour-card .answer", has_text="about as large").wait_for()
    load = "(run) => run.curves.L[run.sheared]"
    assert abs(page.evaluate(f"({load})(punch.run)")) < 0.1  # N/m, of a friction of some 200
    page.click(".answer:has-text('zero')")
    page.locator("#tour-card p[role=status]", has_text="Not so.").wait_for()


@pytest.mark.thorough
def test_last_tour_stop_asks_about_a_random_scene_and_judges_by_its_run(look):
    page = at_stop(look("?more=0"), 9)
    page.wait_for_function("Object.keys(punch.status.address).length > 0")
    page.evaluate("punch.speed = 40")
    page.locator("button.answer").nth(0).click()
    page.locator("#tour-card [role=status]").wait_for()
    right = page.locator("button[data-mark=right]").inner_text()
    slip = page.evaluate(
        "punch.run.curves.slip_at[punch.run.curves.slip.findIndex((s, k) => s && k > punch.run.sheared)]"
    )
    usual = 10.8  # nm, of the first slip at the default: of the paper's Fig. 6
    assert ("shorter" in right) == (slip < usual - 0.1) and ("longer" in right) == (slip > usual + 0.1)


@pytest.mark.thorough
def test_the_tour_ends_with_friction_over_load_in_twelve_runs(look):
    page = at_stop(look("?more=0"), 9)
    page.evaluate("punch.speed = 40")
    page.locator("button.answer").nth(0).click()
    page.get_by_role("button", name="Your turn").click()
    page.get_by_role("button", name="Friction over load").click()
    page.locator("#load-law", has_text="At L = 0 adhesion alone holds with").wait_for()
    assert page.locator("#tour-card").is_visible()
    page.get_by_role("button", name="Finish").click()
    page.locator("#tour-card").wait_for(state="hidden")


UNSEEN = """([curve, phase, springs]) => {
    // what of a stop is not wholly in sight, is cut, or lies over something else
    const card = document.getElementById('tour-card'), view = document.querySelector(`.view[data-view=${curve}]`)
    const wanted = phase === 'ask' ? ['.question', ...[1, 2, 3].map((i) => `.answers > :nth-child(${i})`)]
        : ['[role=status]', '.ways', ...(springs ? ['.springs'] : [])]
    const parts = { punch: document.querySelector('.punch'), contact: document.getElementById('punch-view'),
        [curve]: view, card, ...Object.fromEntries(wanted.map((what) => [what, card.querySelector(what)])) }
    const box = (e) => e.getBoundingClientRect(), around = box(card), said = []
    for (const [name, part] of Object.entries(parts)) {
        if (!part) { said.push(`${name} is missing`); continue }
        const { width, height, top, bottom, left, right } = box(part), least = name === '.springs' ? 50 : 10
        if (width < 20 || height < least) said.push(`${name} is ${width} x ${height} px`)
        if (top < -1 || bottom > innerHeight + 1 || left < -1 || right > innerWidth + 1)
            said.push(`${name} is out of sight`)
        if (card.contains(part) && bottom > around.bottom + 1) said.push(`${name} leaves the card`)
    }
    if (card.scrollHeight > card.clientHeight + 1) said.push('the card is cut')
    const under = (a, b) => a.bottom <= b.top + 1, beside = (a, b) => a.right <= b.left + 1
    const apart = (a, b) => under(a, b) || under(b, a) || beside(a, b) || beside(b, a)
    for (const part of [parts.punch, view]) if (!apart(box(part), around)) said.push('the card covers a view')
    return said
}"""
UNCUT = "(({ scrollHeight, clientHeight }) => scrollHeight <= clientHeight + 1)(document.getElementById('tour-card'))"
STOPS = {1: "forces", 2: "map", 3: "area", 4: "forces", 5: "area", 6: "forces", 7: "forces", 8: "forces", 9: "forces"}
SPRINGS = 1, 4  # stops whose reason has a picture
SIZES = ((1920, 1080), (1366, 768), (1280, 720), (1024, 768), (390, 844))


def unseen_at(page, stop, phase, size):
    """What a stop leaves out of sight, cut or overlapping on a screen of this size, once the page is laid out."""
    of = STOPS[stop], phase, stop in SPRINGS
    laid_out(page, size)
    with suppress(TookTooLong):
        page.wait_for_function(f"(of) => !({UNSEEN})(of).length", arg=of, timeout=SETTLE)
    return [*page.evaluate(UNSEEN, of), *page.evaluate(FAULTS)]


def unseen(page, stop, phase):
    """{size: what unseen_at finds}, where it finds anything; the page is as large as before in the end."""
    before = page.viewport_size
    found = {size: faults for size in SIZES if (faults := unseen_at(page, stop, phase, size))}
    laid_out(page, before.values())
    return found


def test_a_tour_stop_hides_the_result_until_a_guess_then_explains_it_with_all_of_it_in_sight_at_every_size(look):
    page = at_stop(look("?more=0"), 2)
    assert "2 of 9: The edges" in page.locator("#tour-card").inner_text()
    page.wait_for_function("punch.drawn === punch.run.sheared && punch.status.preset === 'fig7-case2'")
    hidden, view = (page.locator(f".view[data-view=map]{what}").bounding_box() for what in (" .future", ""))
    assert hidden["width"] > 0.8 * view["width"] - 90
    # nothing but the question: neither words nor a preset's name answer it beforehand
    for what in ("#scrub", "#narration", "#row", "#menu"):
        assert page.locator(what).is_hidden()
    assert not unseen(page, 2, "ask")
    page.evaluate("punch.speed = 40")
    page.locator("button.answer", has_text="leading edge").click()
    page.locator("#tour-card [role=status]").wait_for()
    assert page.locator("#tour-card [role=status]").inner_text().startswith("Not so.")
    assert "trailing edge" in page.locator("button[data-mark=right]").inner_text()
    assert page.evaluate("punch.run.curves.U_x[punch.drawn]") == pytest.approx(12.5, abs=0.11)  # not behind the slip
    assert page.locator(".future:visible").count() == 1  # what comes next answers other stops
    assert not unseen(page, 2, "why")
    page.get_by_role("button", name="Your turn").click()
    page.wait_for_function("!document.querySelector('.future:not([hidden])')")
    assert page.locator("#tour-card .question").inner_text().startswith("Pull instead of pushing")
    assert page.evaluate("document.activeElement.id") == "delta_bar" and page.locator("#scrub").is_visible()
    page.get_by_role("button", name="Next: The slip").click()
    asked(page)
    page.get_by_role("button", name="End tour").click()
    assert "tour=" not in page.url


@pytest.mark.thorough
@pytest.mark.parametrize("stop", STOPS)
@pytest.mark.parametrize("query", ["?view=projector", "?more=0"])  # the first has More as well
def test_a_stop_has_question_answers_reason_picture_and_contact_in_sight_at_every_size(look, query, stop):
    page = look(query)
    page.evaluate("Math.random = () => 0.99")  # of the scenes at stop 9 the one with the longest name
    at_stop(page, stop)
    assert not unseen(page, stop, "ask")
    page.evaluate("punch.speed = 40")
    page.locator("button.answer").nth(1).click()
    page.locator("#tour-card [role=status]").wait_for()
    assert not unseen(page, stop, "why")


@pytest.mark.thorough
@pytest.mark.parametrize("query", ["?more=0", "?view=projector"])
def test_a_page_opened_within_the_tour_leaves_punch_and_card_in_sight_and_back_closes_it_only(look, query):
    page = at_stop(look(query), 8)
    page.evaluate("punch.speed = 40")
    page.locator("button.answer").nth(0).click()
    page.get_by_role("button", name="Your turn").click()
    from_menu(page, "nav [data-page=load]")
    page.wait_for_function("() => parseInt(document.getElementById('load-count').textContent) > 0")
    for width, height in SIZES:
        laid_out(page, (width, height))
        assert not page.evaluate(FAULTS), (width, height)
        punch, card, plot = (
            page.locator(what).bounding_box() for what in ("#punch-view", "#tour-card", "#load figure .view")
        )
        assert punch["width"] > 150 and punch["height"] > 100 and plot["width"] > 150, (width, height)
        assert punch["y"] + punch["height"] <= card["y"] + 1, (width, height)
        assert card["x"] + card["width"] <= plot["x"] + 1 or card["y"] + card["height"] <= plot["y"], (width, height)
        assert page.evaluate(UNCUT), (width, height)
    page.go_back()
    page.locator("#load").wait_for(state="hidden")
    assert page.locator("#tour-card").is_visible()


def test_theory_is_typeset_without_external_requests_and_ends_with_the_glossary(look):
    page = look()
    from_menu(page, "#open-theory")
    page.locator("#theory math").first.wait_for()
    assert page.locator("#theory math").count() >= 11
    assert "Khajeh Salehani" in page.locator("#theory").inner_text()
    listed = page.locator("#theory .glossary [id^=term-]").evaluate_all("all => all.map((one) => one.id.slice(5))")
    assert set(listed) >= {"traction", "gap", "work", "branch", "fold", "flutter", "peel"}
    page.keyboard.press("Escape")
    page.locator("#theory").wait_for(state="hidden")
    assert not page.locator("#sentence button, #look button, .key button").count()
