"""Closed forms over the curves of the run on screen."""

import numpy as np
import pytest
from served import finished
from tabs import imported

SHOWN = """(view) => {
    const { data_source } = modules.figures.parts[view].theory, { data } = data_source
    const key = document.getElementById(`theory-${view}`)
    const get = (name) => [...(data.get ? data.get(name) : data[name])]
    return { x: get("U_x"), y: get("value"), name: key.hidden ? "" : key.textContent.trim(), limit: key.title }
}"""


def enter(page, name, value):
    entry = page.locator(f"#{name}-entry")
    entry.evaluate(f"(e) => {{ e.value = '{value}'; e.dispatchEvent(new Event('change')) }}")


@pytest.mark.parametrize(
    ("query", "figure", "name", "column"),
    [("?delta_bar=0.4", "area", "Griffith", "A"), ("?preset=fig4a-blue", "forces", "Prandtl–Tomlinson", "F")],
)
def test_a_closed_form_lies_over_the_curve_up_to_its_first_slip_with_its_name_and_limit(
    look, query, figure, name, column
):
    page = imported(look(query), "figures", "theory")
    page.wait_for_function(f"!document.getElementById('theory-{figure}').hidden && !punch.fresh")
    shown = page.evaluate(SHOWN, figure)
    assert shown["name"] == name and "first slip" in shown["limit"]
    assert name in page.locator("#theory-limits").text_content()
    run = page.evaluate(
        f"""() => {{
            const {{ curves, sheared }} = punch.run, end = curves.slip.findIndex((s, k) => s && k > sheared)
            return [curves.U_x.slice(sheared, end), curves.{column}.slice(sheared, end)].map((a) => [...a])
        }}"""
    )
    at, value = np.array(run)
    over = np.interp(at, shown["x"], shown["y"])
    assert np.abs(over - value).max() < 0.04 * value.max() and len(at) > 50
    page.evaluate("punch.following = false; modules.player.goto(0)")  # the approach
    page.wait_for_function("punch.approach && !punch.fresh")
    along = page.evaluate(SHOWN, "area")
    assert along["name"] == ("Maugis" if figure == "area" else "")
    assert page.evaluate(SHOWN, "forces")["x"] == []
    page.locator("#more").click()
    page.wait_for_function(f"document.getElementById('theory-{figure}').hidden")


def test_no_closed_form_is_drawn_over_a_run_that_has_none_or_of_another_scene(look):
    page = imported(look("?delta_bar=0.4"), "figures", "theory", "steer")
    page.wait_for_function("!document.getElementById('theory-area').hidden")
    enter(page, "E", 200)  # Maugis' number is 0.5
    finished(page, run=2)
    page.wait_for_function("punch.charted.scene.E === 200 && punch.charted.whole && !punch.fresh")
    assert page.evaluate(SHOWN, "area")["x"] == []
    assert page.locator("#theory-limits").text_content() == ""
