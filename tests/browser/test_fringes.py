"""The stress per fringe in Chromium."""

import pytest
from served import finished, values_are

pytestmark = [pytest.mark.thorough]
KEY = "document.getElementById('fringe-most').textContent"


def test_stress_per_fringe_changes_only_when_the_user_chooses_it(visit):
    page = visit("?E=71.6")
    finished(page)
    page.wait_for_function(f"{KEY} === '0.6 GPa'")
    page.locator("#delta_bar-entry").fill("0.4")  # pressed harder: the tractions are larger
    page.keyboard.press("Enter")
    values_are(page, delta_bar=0.4)
    page.wait_for_function("!punch.fresh && punch.drawn >= 0")
    assert page.evaluate(KEY) == "0.6 GPa"
    page.locator("#fringe").evaluate("(of) => { of.value = '0.5'; of.dispatchEvent(new Event('change')) }")
    page.wait_for_function(f"{KEY} === '1.5 GPa'")
