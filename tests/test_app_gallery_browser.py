"""The gallery of presets, in a real Chromium."""

import pytest
from served import FAULTS, PATIENCE, finished, laid_out, values_are

from solver.presets import presets

pytestmark = [pytest.mark.browser, pytest.mark.thorough]


def test_a_preset_is_chosen_by_its_picture_with_the_keyboard(visit):
    page = visit()
    finished(page)
    opener = page.get_by_role("button", name="Gallery")
    opener.press("Enter")
    gallery = page.get_by_role("dialog", name="Presets")
    gallery.wait_for()
    assert page.evaluate("document.activeElement.dataset.preset") == "fig6"  # that on screen
    cards = [(one.name, one.title, one.figure) for one in presets().values()]
    shown = page.eval_on_selector_all(
        ".card",
        "all => all.map((e) => [e.dataset.preset, ...[...e.children].slice(1).map((part) => part.textContent)])",
    )
    assert sorted(map(tuple, shown)) == sorted(cards)
    assert gallery.locator("h3").all_inner_texts() == list(dict.fromkeys(one.group for one in presets().values()))
    page.locator("#gallery .picture svg").first.wait_for(timeout=PATIENCE)
    page.keyboard.press("Escape")
    gallery.wait_for(state="hidden")
    assert opener.evaluate("(e) => e === document.activeElement")
    opener.press("Enter")
    gallery.wait_for()
    page.keyboard.press("Tab")
    name = page.evaluate("document.activeElement.dataset.preset")
    assert name != "fig6"
    page.keyboard.press("Enter")
    gallery.wait_for(state="hidden")
    values_are(page, delta_bar=presets()[name].scene.delta_bar)
    assert page.input_value("#preset") == name and f"preset={name}" in page.url
    opener.press("Enter")
    gallery.wait_for()
    assert page.locator(".card[aria-current=true]").get_attribute("data-preset") == name


@pytest.mark.thorough
def test_every_preset_gets_its_picture_and_the_gallery_fits_every_screen(visit):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Gallery").click()
    gallery = page.get_by_role("dialog", name="Presets")
    page.wait_for_function(
        f"document.querySelectorAll('#gallery .picture svg').length === {len(presets())}",
        timeout=len(presets()) * PATIENCE,
    )
    for width, height in ((1440, 900), (1024, 768), (844, 390), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        laid_out(page)
        assert not page.evaluate(FAULTS), (width, height)
        assert gallery.evaluate("(e) => e.scrollWidth <= e.clientWidth")
