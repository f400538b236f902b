"""Views of unusual runs: approach, no shear, no contact, loops, increments without an equilibrium."""

from itertools import pairwise

import pytest
from served import finished

pytestmark = pytest.mark.thorough


def column(page, part, name):
    view, label = part.split(".")
    return page.evaluate(f"[...charts.{view}.parts.{label}.{name}]")


def along(page):
    return page.evaluate("charts.forces.across")


def test_approach_is_plotted_over_indentation_and_marks_the_jump_into_contact(look):
    page = look("?du_x=0.5")
    page.locator("body").press("Home")
    page.wait_for_function("!punch.fresh && punch.mapped && punch.approach")
    assert along(page) == "indentation δ (nm)"
    delta = column(page, "forces.L", "x")
    assert (delta[0], delta[-1]) == (-10, pytest.approx(0))
    assert column(page, "forces.slips", "x") == [pytest.approx(-4.153, abs=0.01)]  # the jump into contact
    page.locator("body").press("End")
    page.wait_for_function("!punch.approach")
    assert along(page).startswith("displacement")
    assert len(column(page, "forces.L", "x")) == 81


@pytest.mark.once
@pytest.mark.parametrize("query", ["?u_x_max=0", "?path=unload&delta_bar=-1", "?delta_bar=-1&du_x=1"])
def test_runs_without_shear_or_contact_have_valid_axes_and_an_explanation(look, query):
    page = look(query)
    start, end = page.evaluate("[charts.forces.x.start, charts.forces.x.end]")
    assert start < end
    assert len(column(page, "forces.L", "x")) > 0
    apart = "faint pull" in page.inner_text("#sentence")
    assert apart == ("delta_bar=-1" in query)


def test_arrows_show_the_direction_of_loops_and_unloading(look):
    page = look("?path=loop&u_x_max=10&du_x=0.5")
    assert column(page, "forces.ways", "marker") == ["right", "right", "left", "left", "right", "right"]
    page.locator("main .map figcaption").click()  # large, it has room for its key
    page.locator("#branch").wait_for()  # the edges on the way that is not shown have a key
    page.select_option("#preset", "fig6")
    finished(page, run=2)
    assert column(page, "forces.ways", "marker") == []
    assert page.locator("#branch").is_hidden()
    page.select_option("#preset", "unload")
    finished(page, run=3)
    places = sorted(column(page, "forces.ways", "x"))  # both ways lie on each other here, their heads do not
    assert min(b - a for a, b in pairwise(places)) > 0.05 * 12


def test_increments_without_an_equilibrium_are_hatched_and_labelled(look):
    page = look("?du_x=0.5&u_x_max=39")  # of this test alone, as it spoils the run
    assert page.locator("#unrested").is_hidden()
    page.evaluate(
        """() => { // as if the surface had not come to rest in the three increments before its last slip
            const k = punch.run.curves.slip.lastIndexOf(1)
            for (const list of [punch.run.places, ...Object.values(punch.run.curves)]) list.splice(k - 3, 3)
            punch.look++
        }"""
    )
    page.locator("#unrested").wait_for(state="visible")
    assert [width for _, width in column(page, "map.unrested", "list")] == [pytest.approx(1.5)]
