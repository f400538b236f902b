"""Forces are shown in N/m for any stiffness."""

import re

import pytest
from served import enter, finished

pytestmark = pytest.mark.thorough


def drawn(page, part):
    """The values of a curve as they are drawn."""
    return page.evaluate(f"[...charts.forces.parts.{part}.y]")


def axis(page):
    return page.evaluate("charts.forces.up")


def test_a_stiffer_layer_has_larger_forces_and_the_previous_run_keeps_its_own(look):
    page = look("?E=20&du_x=0.5")
    soft = max(drawn(page, "F"))
    assert soft == pytest.approx(20 * 2500 * max(page.evaluate("punch.run.curves.F_bar")), rel=1e-6)
    enter(page, "E", "700")
    finished(page, run=2)
    assert max(drawn(page, "ghost_F")) == pytest.approx(soft, rel=1e-6)
    assert max(drawn(page, "F")) > 2 * soft  # over wE it would fall to less than a tenth
    assert axis(page) == "F, L (N/m)"


def test_an_older_link_to_normalised_forces_opens_with_forces_in_newtons_per_metre(visit):
    page = visit("?force=bar&u_x_max=4&du_x=0.5")
    assert axis(page) == "F, L (N/m)" and not page.inner_text("#notes")
    assert re.search(r"F = \S+ N/m, L = \S+ N/m, A = \S+ nm \(Ā = ", page.inner_text("#readout"))


def test_area_axis_states_a_nonzero_start_and_stacked_plots_align(look):
    page = look()
    start = page.evaluate("charts.area.y.start")
    assert start > 0
    assert re.search(r"axis begins at \d+ nm", page.inner_text("#area-from"))
    lefts = [page.evaluate(f"charts.{name}.box.width") for name in ("forces", "area", "map")]
    assert lefts[0] == lefts[1] == lefts[2] > 0
