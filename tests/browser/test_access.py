"""Accessibility: keyboard, screen readers, touch targets, contrast, and axe; of pages in test_pages.py."""

import re

import numpy as np
import pytest
from served import PLAYING, enter, finished, found_by_axe, from_menu, laid_out

pytestmark = pytest.mark.thorough
# the slider does what a mark does (WCAG 2.5.8)
TOUCHED = "button:not(.mark), select, input:not([type=checkbox], [type=radio]), label:has(input)"
SMALL = f"""() => [...document.querySelectorAll('{TOUCHED}')]
    .filter((e) => e.checkVisibility() && !e.closest('[hidden]'))
    .map((e) => [e.id || e.textContent.trim(), e.getBoundingClientRect()])
    .filter(([, box]) => Math.min(box.width, box.height) < 24).map(([name]) => name)"""


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_reports_no_violation_on_the_page_and_in_any_dialog_or_view(look, theme):
    page = look(f"?theme={theme}&E=7000")  # with a note
    assert not found_by_axe(page)
    from_menu(page, "#parameters")
    enter(page, "nodes", "3")
    page.locator("#nodes-error").wait_for(state="visible")
    assert not found_by_axe(page)
    page.locator("#drawer").get_by_role("button", name="Close").click()
    for button, sheet in (("#take", "#share"), ("#open-theory", "#theory"), ("#help", "#keys")):
        from_menu(page, button)
        page.locator(f"{sheet}[open] :is(td, dt, #share-link)").first.wait_for()
        assert not found_by_axe(page), sheet
        page.keyboard.press("Escape")
    from_menu(page, "#pin")
    page.locator(".chip").wait_for()
    assert not found_by_axe(page)
    from_menu(page, "#take")
    page.locator("#show-table").click()
    page.locator("#table tbody tr").first.wait_for()
    assert not found_by_axe(page)
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    page.set_viewport_size({"width": 390, "height": 844})
    assert not found_by_axe(page)
    page.set_viewport_size({"width": 1280, "height": 720})
    page.locator("#tour").click()
    page.locator("button.answer").first.wait_for()
    assert not found_by_axe(page)


def test_touch_targets_measure_at_least_24_pixels(look):
    page = look()
    for width, height in ((1280, 720), (390, 844), (844, 390)):
        laid_out(page, (width, height))
        assert not page.evaluate(SMALL), (width, height)


def test_screen_readers_hear_nothing_during_playback_and_one_sentence_at_a_pause(visit):
    page = visit(**PLAYING)
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
    assert "newtons per metre" in page.inner_text("#announcement")
    page.locator("body").press("]")
    page.wait_for_function("document.getElementById('announcement').textContent.startsWith('Slip at')")
    page.wait_for_function("punch.run.curves.slip[punch.drawn] > 0")
    at = page.evaluate("punch.run.curves.slip_at[punch.drawn].toFixed(1)")  # as the sentence says it
    assert f"displacement of {at} nanometres" in page.inner_text("#announcement")


def test_escape_closes_the_menu_and_space_presses_its_button(look):
    page = look()
    page.click("#menu")
    page.focus("#stress")
    page.keyboard.press("Escape")
    page.locator("#stress").wait_for(state="hidden")
    assert page.evaluate("document.activeElement.id") == "menu"
    page.click("#menu")
    page.focus("#theme")
    theme = page.evaluate("document.documentElement.dataset.theme")
    page.keyboard.press("Space")
    assert page.evaluate("document.documentElement.dataset.theme") != theme and not page.evaluate("punch.playing")
    page.locator("#theme").wait_for(state="hidden")
    assert page.evaluate("document.activeElement.id") == "menu"


def test_a_select_keeps_the_focus_and_space_still_starts_playback(look):
    page = look()
    page.focus("#speed")
    page.keyboard.press("ArrowDown")
    assert page.evaluate("document.activeElement.id") == "speed" and page.evaluate("punch.speed") == 8
    page.keyboard.press("Space")
    page.wait_for_function("punch.playing")
    page.focus("#preset")
    page.keyboard.press("ArrowDown")
    finished(page, run=2)
    assert page.evaluate("document.activeElement.id") == "preset"


def test_the_increments_of_the_run_can_be_read_as_a_table(look):
    page = look()
    from_menu(page, "#take")
    page.locator("#show-table").wait_for()
    page.locator("#show-table").press("Enter")
    page.get_by_role("dialog", name="Increments of the run").wait_for()
    assert page.locator("#table tbody tr").count() == page.evaluate("punch.run.length - punch.run.sheared")
    names = ["Uₓ (nm)", "δ (nm)", "friction F (N/m)", "load L (N/m)", "contact area A (nm)", "slip"]
    assert page.locator("#table th").all_inner_texts() == names
    cells = page.locator("#table tbody tr").last.locator("td").all_inner_texts()
    last = page.evaluate("(({ U_x, delta, F, L, A }) => [U_x, delta, F, L, A])(punch.run.values(punch.run.length - 1))")
    assert [float(cell.replace("−", "-")) for cell in cells[:5]] == pytest.approx(last, rel=1e-3, abs=5e-3)
    slips = page.evaluate("punch.run.curves.slip.filter((slip, k) => slip && k >= punch.run.sheared).length")
    assert page.locator("#table tbody td:last-child", has_text="slip").count() == slips > 0
    page.keyboard.press("Escape")
    page.locator("#table").wait_for(state="hidden")
    assert page.locator("#share").is_visible() and not page.locator("figcaption button").count()
    page.keyboard.press("Escape")


STOP = """() => {
    const e = document.activeElement
    if (e === document.body) return null
    const box = e.getBoundingClientRect(), look = getComputedStyle(e)
    const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2)
    const name = e.getAttribute("aria-label") || e.labels?.[0]?.textContent || e.textContent
    return { id: e.id, name: name.trim(), ring: look.outlineStyle === "solid" ? parseFloat(look.outlineWidth) : 0,
        seen: e === top || e.contains(top) || Boolean(top?.closest("label")?.contains(e)) }
}"""


def to(page, stop, most=140):  # two rounds of the page, and what takes the focus on the way
    """Tab on to the element with this id."""
    for _ in range(most):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == stop:
            return
    raise AssertionError(f"{stop} is not reached by the tab key")


def test_tab_key_reaches_visible_named_controls_in_order_without_a_trap(visit):
    page = visit()  # where the tab key begins cannot be set back
    stops = []
    for _ in range(75):
        page.keyboard.press("Tab")
        page.wait_for_function(f"() => {{ const stop = ({STOP})(); return !stop || stop.seen }}")
        stop = page.evaluate(STOP)
        if stop is None:
            break
        stops.append(stop)
    else:
        raise AssertionError("the tab key does not leave the page")
    assert 20 < len(stops) < 60
    assert not [stop for stop in stops if not (stop["name"] and stop["ring"] >= 2)]
    wanted = ["preset", "tour", "more", "menu", "lens", "delta_bar", "play", "scrub"]
    found = [stop["id"] for stop in stops if stop["id"] in wanted]
    assert found == wanted  # in the order of the page
    page.keyboard.press("Shift+Tab")
    assert page.evaluate("document.activeElement.id") == "speed"


def test_the_whole_page_works_with_the_keyboard_alone(visit):
    page = visit(**PLAYING)
    press = page.keyboard.press

    def choose(button):
        for stop in ("menu", button):
            to(page, stop)
            press("Enter")

    press("Space")
    choose("open-theory")
    page.locator("#theory math").first.wait_for()
    press("Escape")
    choose("parameters")
    page.get_by_label("Find a parameter").wait_for()
    press("Escape")
    page.wait_for_function("document.activeElement.id === 'menu'")
    choose("pin")
    page.locator(".chip").wait_for()
    choose("take")
    page.wait_for_function("document.getElementById('share-python').value.includes('Scene')")
    press("Escape")
    to(page, "delta_bar")  # the punch itself: down
    press("ArrowRight")
    finished(page, run=2)
    to(page, "lens")
    before = page.get_attribute("#lens", "aria-valuenow")
    press("ArrowRight")
    page.wait_for_function(f"document.getElementById('lens').getAttribute('aria-valuenow') !== '{before}'")
    to(page, "scrub")  # and along the run
    press("Home")
    page.wait_for_function("punch.drawn === 0")
    press("Escape")
    page.evaluate("document.activeElement.blur()")
    press("]")
    page.wait_for_function("punch.run.values(punch.drawn).slip")
    press("p")
    page.wait_for_function("document.documentElement.dataset.view === 'projector'")
    press("p")
    to(page, "tour")
    press("Enter")
    page.wait_for_function("document.activeElement.className === 'answer'")
    press("Enter")
    page.locator("#tour-card [role=status]").wait_for()
    press("Escape")
    page.wait_for_function("document.activeElement.id === 'tour'")


def test_solver_statistics_appear_only_behind_their_button(look):
    page = look()
    assert "evaluations" not in page.inner_text(".page")
    page.locator("#solver-figures").click()
    said = page.locator("#solver").inner_text()
    assert "502 increments" in said and "force evaluations" in said and "1e-8 nm" in said


def test_cautions_about_a_result_appear_behind_their_button(look):
    page = look("?preset=inertia")
    assert page.locator("#notes").is_hidden()
    page.locator("#caution").click()
    assert "may flutter" in page.inner_text("#cautions")


def test_a_label_focuses_its_entry_and_has_no_button(look):
    page = look()
    page.locator(".control label", has_text="Stiffness").click()
    assert page.evaluate("document.activeElement.id") == "E-entry"
    assert not page.locator("label button").count()


def test_previous_run_has_enough_contrast_in_the_dark_theme(look):
    colours = """() => {
        const root = document.documentElement, before = root.dataset.theme, style = getComputedStyle(root)
        root.dataset.theme = "dark"
        const found = ["--ghost", "--soft", "--page"].map((name) => style.getPropertyValue(name).trim())
        root.dataset.theme = before
        return found
    }"""

    def light(colour):
        parts = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
        return np.dot(
            [0.2126, 0.7152, 0.0722], [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        )

    line, text, page = map(light, look().evaluate(colours))
    assert (line + 0.05) / (page + 0.05) >= 3.0 and (text + 0.05) / (page + 0.05) >= 4.5  # of WCAG


def test_single_letters_can_be_switched_off_for_good(visit):
    """WCAG 2.1.4: who dictates says letters that are not meant as keys."""
    page = visit("?E=100")
    page.locator("body").press("?")
    page.get_by_label("letters and signs are keys").uncheck()
    page.keyboard.press("Escape")
    page.reload()
    finished(page)
    for key in ("r", "p", "c", "?", "]"):
        page.locator("body").press(key)
    assert "E=100" in page.url and "projector" not in page.url and not page.locator("#keys").is_visible()
    page.locator("body").press(" ")  # is no letter
    page.wait_for_function("punch.playing")


def test_slider_names_have_the_unit_and_values_the_number_and_a_summary_says_what_happens(look):
    page = look("?E=200&delta_bar=0.1")
    page.keyboard.press("End")
    page.wait_for_function("punch.drawn === punch.run.length - 1 && !punch.fresh")
    told = {name: page.get_attribute(f"#{name}", "aria-valuetext") for name in ("E", "delta_bar", "phi_ratio", "scrub")}
    assert told == {"E": "200", "delta_bar": "0.1", "phi_ratio": "1", "scrub": "shear increment 400"}
    page.get_by_role("slider", name="Stiffness E in GPa").wait_for()
    assert re.fullmatch(r"x = −?\d+\.\d, gap −?\d+\.\d\d, \w+", page.get_attribute("#lens", "aria-valuetext"))
    summary = page.locator("section[aria-label=Summary]").text_content()
    sentence = page.locator("#sentence").text_content()
    assert "elastic punch" in summary and "sliders" in summary and sentence in summary
    assert "newtons per metre" in summary
