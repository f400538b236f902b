"""For everyone: by keyboard alone, for those who hear the page, and nothing that axe finds."""

import pytest
from axe_playwright_python.sync_playwright import Axe
from served import PATIENCE, finished

pytestmark = pytest.mark.browser
# in a sentence a word is as low as its line (WCAG 2.5.8)
TOUCHED = "button:not(p .term), select, input:not([type=checkbox]), label:has([type=checkbox])"
SMALL = f"""() => [...document.querySelectorAll('{TOUCHED}')]
    .filter((e) => e.checkVisibility() && !e.closest('[hidden]'))
    .map((e) => [e.id || e.textContent.trim(), e.getBoundingClientRect()])
    .filter(([, box]) => Math.min(box.width, box.height) < 24).map(([name]) => name)"""


def found_by_axe(page):
    """What axe finds on the page as it is, in words."""
    rules = [*Axe().run(page, options={"iframes": False}).response["violations"]]
    return {rule["id"]: [node["html"][:160] for node in rule["nodes"]] for rule in rules}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing(visit, theme):
    page = visit(f"?theme={theme}&E=7000")  # with a note
    finished(page)
    page.get_by_role("button", name="Pause").click()
    assert not found_by_axe(page)
    page.get_by_role("button", name="Parameters").click()
    page.fill("#nodes-entry", "3")
    page.keyboard.press("Enter")
    page.locator("#nodes-error").wait_for(state="visible")
    assert not found_by_axe(page)
    page.keyboard.press("Escape")
    for view in ("punch", "map"):
        page.locator(f".as-table[data-view={view}]").click()
        page.locator("#table tbody tr").first.wait_for()
        assert not found_by_axe(page)
        page.keyboard.press("Escape")
    page.set_viewport_size({"width": 390, "height": 844})
    assert not found_by_axe(page)


@pytest.mark.parametrize("size", [(1280, 720), (390, 844), (844, 390)])
def test_what_is_touched_is_large_enough(visit, size):
    page = visit()
    page.set_viewport_size({"width": size[0], "height": size[1]})
    finished(page)
    assert not page.evaluate(SMALL)


def test_while_playing_no_live_region_speaks_and_a_pause_says_one_sentence(visit):
    page = visit()
    finished(page)
    page.evaluate(
        """() => {
            window.heard = []
            const live = document.querySelectorAll('[aria-live=polite], [role=status], [role=alert], output')
            for (const region of live) new MutationObserver(() => heard.push(region.textContent))
                .observe(region, { childList: true, characterData: true, subtree: true })
        }"""
    )
    now = page.evaluate("punch.clock")
    page.wait_for_function(f"punch.clock > {now} + 1")
    assert page.evaluate("heard") == []
    page.locator("body").press("Space")
    page.wait_for_function("heard.length >= 2")  # that it is paused, and where
    assert "newtons per metre" in page.inner_text("#told")
    page.locator("body").press("]")
    page.wait_for_function("document.getElementById('told').textContent.startsWith('Slip at')")


def test_a_menu_keeps_the_focus_and_space_plays_after_a_choice(visit):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Pause").click()
    page.focus("#speed")
    page.keyboard.press("ArrowDown")
    assert page.evaluate("document.activeElement.id") == "speed" and page.evaluate("punch.speed") == 8
    page.keyboard.press("Space")
    page.wait_for_function("punch.playing")
    page.focus("#preset")
    page.keyboard.press("ArrowDown")
    finished(page, run=2)
    assert page.evaluate("document.activeElement.id") == "preset"


def test_every_plot_has_its_numbers_as_a_table(visit):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Pause").click()
    page.keyboard.press("End")
    page.wait_for_function("punch.drawn === punch.run.length - 1")
    frames = page.evaluate("punch.run.length - punch.run.sheared")
    nodes = page.evaluate("punch.run.frame(punch.drawn).x.length")
    for view, rows in (("punch", nodes), ("traction", nodes), ("forces", frames), ("area", frames), ("map", frames)):
        page.locator(f".as-table[data-view={view}]").click()
        page.wait_for_function(f"document.querySelectorAll('#table tbody tr').length === {rows}", timeout=PATIENCE)
        page.get_by_role("dialog").get_by_role("button", name="Close").click()
        page.wait_for_function("!document.getElementById('table').open")
    page.locator(".as-table[data-view=forces]").click()
    page.get_by_role("dialog", name="Forces", exact=True).wait_for()
    last = page.locator("#table tbody tr").last.locator("td").all_inner_texts()
    F = page.evaluate("punch.run.values(punch.run.length - 1).F_bar * punch.run.head.force")
    assert last[0] == "shear" and float(last[1]) == pytest.approx(40.0)
    assert float(last[2].replace("−", "-")) == pytest.approx(F, rel=1e-3)


def test_the_menu_says_when_the_scene_is_no_longer_its_preset_and_brings_it_back(visit):
    page = visit("?preset=fig7-case2")
    finished(page)
    assert page.locator("#preset optgroup").count() > 3
    page.fill("#E-entry", "100")
    page.keyboard.press("Enter")
    finished(page, run=2)
    shown = page.evaluate("document.getElementById('preset').selectedOptions[0].textContent")
    assert "changed" in shown and "Stiffness" in page.inner_text("#look")
    page.select_option("#preset", "fig7-case2")
    finished(page, run=3)
    assert page.evaluate("punch.status.values.E") == 70


def test_figures_of_the_solver_are_behind_one_button(visit):
    page = visit()
    finished(page)
    assert "evaluations" not in page.inner_text(".page")
    page.get_by_role("button", name="Figures of the solver").click()
    said = page.locator("#solver").inner_text()
    assert "502 increments" in said and "force evaluations" in said and "1e-8 nm" in said
