"""The research pages in a browser: opened from the menu with the scene, computed, and left with the scene."""

from urllib.parse import parse_qsl, urlencode, urlsplit

import pytest
from served import finished, found_by_axe
from tabs import DESKTOP, Tabs

from app.features.lab.feature import listed
from app.features.lab.look import colours

QUICK = "?nodes=64&width=160&radius=0.6&u_x_max=12&du_x=0.2&du_z=0.5&E=35&theme=dark"
LONG = "area_laws", "stick_slip"  # their runs are those of the paper, in full size
SERIOUS = {"aria-input-field-name", "aria-progressbar-name", "button-name", "color-contrast", "label", "link-name"}


BACKGROUNDS = """Object.fromEntries([...Bokeh.documents[0]._all_models.values()]
    .filter(({ type }) => type === "Figure").map(({ id, background_fill_color }) => [id, background_fill_color]))"""


SMALL = """() => {
    const found = []
    const visit = (root) => {
        for (const e of root.querySelectorAll("*")) {
            const text = [...e.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())
            const shown = (text || e.matches("input")) && !e.matches("style, script") && e.checkVisibility()
            if (shown && parseFloat(getComputedStyle(e).fontSize) < 14) found.push(e.textContent || e.type)
            if (e.shadowRoot) visit(e.shadowRoot)
        }
    }
    visit(document)
    for (const model of Bokeh.documents[0]._all_models.values())
        for (const name of ["axis_label", "major_label", "label"])
            if (parseFloat(model[`${name}_text_font_size`]?.value ?? model[`${name}_text_font_size`]) < 14)
                found.push(`${name} of ${model.type}`)
    return found
}"""


@pytest.fixture(scope="module")
def tab(server, browser):
    """One tab for the tests from the menu, each of which ends where it began."""
    tabs = Tabs(server, browser)
    yield tabs.open(QUICK)
    tabs.close()
    tabs.check()


@pytest.mark.once(2)
@pytest.mark.parametrize("name", sorted(listed(), key=lambda name: name not in ("stick_slip", "fit")))
def test_a_page_opens_from_the_menu_with_the_scene_computes_or_is_cancelled_and_returns_with_it(server, tab, name):
    if "lab=" in tab.url:  # where a test before has failed
        tab.goto(server.address + QUICK)
    tab.set_viewport_size(DESKTOP)
    finished(tab)
    tab.locator("#menu").click()
    tab.locator(f"nav a[data-lab={name}]").click()
    tab.get_by_role("heading", name=listed()[name].TITLE).wait_for()
    assert tab.title() == listed()[name].TITLE and "E=35" in tab.url
    cancel = tab.get_by_role("button", name="Cancel")
    if name in LONG:
        cancel.click()
        tab.get_by_text("Cancelled.").wait_for()
    cancel.wait_for(state="hidden")
    ground = colours(dark=True)["page"]  # of the experiment
    assert set(tab.evaluate(BACKGROUNDS).values()) == {ground}
    tab.wait_for_function("height => document.documentElement.scrollHeight > height", arg=0.9 * DESKTOP["height"])
    tab.wait_for_function(f"() => !({SMALL})().length")  # no text is smaller than 14 pixels
    for width in (820, 390):
        tab.set_viewport_size({"width": width, "height": 1180})
        tab.wait_for_function("document.documentElement.scrollWidth <= innerWidth")
    assert not found_by_axe(tab).keys() & SERIOUS
    tab.get_by_role("link", name="Back to the experiment").click()
    finished(tab)
    values = tab.evaluate("punch.status.values")
    assert values["E"] == 35 and values["nodes"] == 64


@pytest.mark.parametrize("name", listed())
def test_who_comes_back_from_a_page_is_in_the_class_at_the_stop_and_in_the_view_that_was_left(visit, name):
    kept = {"class": "ABCD", "more": "1", "view": "projector", "ask": "F_s", "change": "phi_ratio:0.5", "theme": "dark"}
    page = visit(f"{QUICK}&{urlencode(kept)}")
    page.wait_for_function("punch.lesson?.stop === 0")
    page.locator(f"nav a[data-lab={name}]").dispatch_event("click")
    page.get_by_role("heading", name=listed()[name].TITLE).wait_for()
    page.get_by_role("link", name="Back to the experiment").click()
    page.wait_for_function("window.punch?.lesson?.leads")  # the teacher of the class still is
    assert dict(parse_qsl(urlsplit(page.url).query)).items() >= kept.items()
    shown = page.evaluate("({ ...document.documentElement.dataset })")
    assert (shown["view"], shown["theme"]) == ("projector", "dark")
    assert page.locator("#more").get_attribute("aria-pressed") == "true"


def test_an_unknown_page_is_named_and_the_experiment_is_one_link_away(visit):
    page = visit("?lab=secret&E=35", rests=False)
    page.get_by_text("There is no page “secret”").wait_for()
    assert page.get_by_role("link", name="Back to the experiment").get_attribute("href") == "?E=35"
