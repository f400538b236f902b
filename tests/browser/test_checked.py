"""A prediction that is checked after the slider rests, in Chromium: exact, and its frames when somebody wants them."""

import csv
import io
import re
from pathlib import Path

import pytest
from served import finished, from_menu

FOUND = re.compile(r"is exact: \d+ states, \d+ folds?, \d+ landings? checked, \d+ force evaluations")
CURVES = "(names) => names.map((name) => [...punch.run.curves[name]])"


def checked(look, start):
    """(page, E of its run): the hand has moved a slider by a key from a place of its own, and rests."""
    page = look(f"?E={start}&u_x_max=14&k=150")
    finished(page)
    page.locator("#E").press("ArrowRight")
    page.wait_for_function("punch.run.checked && punch.status.state === 'finished' && !punch.fresh")
    return page, page.evaluate("punch.run.scene.E")


def test_a_prediction_at_rest_is_exact_and_has_the_approach(look):
    page, E = checked(look, 73.3)
    assert E > 73.3 and not page.evaluate("punch.run.followed || punch.stale")
    assert page.locator("#status b").text_content() == "exact"
    assert FOUND.search(page.locator("#computed").text_content())
    names = ["stage", "index", "U_x", "delta", "F", "L", "A", "slip"]
    own = page.evaluate(CURVES, names)
    assert len(own[0]) == page.evaluate("punch.status.frames") and own[3][0] == -10.0
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Home")
    page.wait_for_function("punch.drawn === 0 && punch.approach")
    assert page.evaluate("() => { const { x } = charts.forces.parts.F; return [x[0], x.at(-1)] }") == [-10.0, 0.0]
    box = page.evaluate("charts.forces.says({ x: -4.6 })")  # beside the mouse; it said 0.0 on the approach
    assert box[0].startswith("δ = −4.6 nm"), box
    page.keyboard.press("]")
    page.wait_for_function("punch.run.curves.slip[punch.drawn] && punch.drawn > punch.run.sheared")
    k = page.evaluate("punch.drawn")
    page.keyboard.press("m")
    page.wait_for_function("punch.instead")  # the motion is on screen, in the exact run's frames
    assert page.evaluate("[punch.run.checked ?? null, punch.run.scene.E, punch.instead.run.length > 10]") == [
        None,
        E,
        True,
    ]
    assert page.evaluate("Math.floor(punch.at)") == k
    frames = page.evaluate(CURVES, names)
    for name, mine, exact in zip(names, own, frames, strict=True):
        within = (
            1.2 if name == "A" else 1e-3 * max(map(abs, exact))
        )  # half a spacing: between nodes A begins like a root
        assert mine == pytest.approx(exact, abs=within), name


def test_a_table_as_csv_has_frames_of_the_solver(look):
    page, _ = checked(look, 76.9)
    from_menu(page, "#take")
    with page.expect_download() as saved:
        page.locator("#save-csv").click()
    _, *lines = Path(saved.value.path()).read_text().splitlines()
    rows = list(csv.DictReader(io.StringIO("\n".join(lines))))
    assert len(rows) == 141 and all(float(row["residual (nm)"]) <= 1e-8 for row in rows)
    page.wait_for_function("!punch.run.checked && punch.status.state === 'finished'")


def test_a_predicted_slip_of_a_wave_is_said_to_land_maybe_elsewhere(look):
    page = look("?surface=wave&u_x_max=20&k=100")
    finished(page)
    page.wait_for_function("punch.drawn === 100")
    page.keyboard.press("]")
    page.wait_for_function("punch.run.curves.slip[punch.drawn] && punch.drawn > punch.run.sheared && !punch.fresh")
    page.locator("#E").focus()
    page.keyboard.down("ArrowRight")
    page.wait_for_function("punch.run.followed && punch.said.includes('Predicted: it may land elsewhere.')")
    page.keyboard.up("ArrowRight")
    page.wait_for_function(
        "!punch.run.followed && punch.status.state === 'finished' && !punch.said.includes('Predicted')"
    )
