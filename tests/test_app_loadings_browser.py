"""Other loadings and surfaces in a real Chromium."""

import pytest
from served import PATIENCE, finished

pytestmark = pytest.mark.browser
AXIS = "[...Bokeh.documents[0]._all_models.values()].find((m) => m.name === 'forces' && m.below).below[0].axis_label"


def test_a_friction_loop_is_drawn_and_its_dissipation_told(visit):
    page = visit("?preset=loop")
    finished(page)
    stages = page.evaluate("[...new Set(punch.run.curves.stage.map((s) => punch.run.head.stages[s]))]")
    assert stages == ["approach", "shear", "back", "forth"]
    assert page.evaluate("[Math.min(...punch.run.curves.U_x), Math.max(...punch.run.curves.U_x)]") == [-20, 20]
    page.wait_for_function("() => document.getElementById('status').textContent.includes('dissipated in a cycle')")
    area = page.evaluate(
        """() => {  // of the loop of F over U_x, nJ/m, straight between the increments
            const { U_x, F_bar: F, stage } = punch.run.curves, scale = 70 * 2500
            const part = (k) => 0.5 * (F[k] + F[k - 1]) * (U_x[k] - U_x[k - 1]) * scale
            return F.reduce((sum, _, k) => sum + (stage[k] >= 2 ? part(k) : 0), 0)
        }"""
    )
    assert page.evaluate("punch.run.dissipated") == pytest.approx(area, rel=0.02)  # slips lie between increments


def test_unloading_is_drawn_along_the_indentation(visit):
    page = visit("?preset=unload")
    finished(page)
    assert "δ" in page.evaluate(AXIS)
    low, high = page.evaluate("punch.run.extent()")
    assert low <= -10 and high == 2
    page.select_option("#preset", "fig6")
    finished(page, run=2)
    assert "Uₓ" in page.evaluate(AXIS)
    assert page.evaluate("punch.ghost") is None  # another experiment: nothing to compare


def test_a_change_can_carry_on_from_the_increment_on_screen(visit):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Pause").click()
    page.evaluate("document.getElementById('scrub').value = 300")
    page.locator("#scrub").dispatch_event("input")
    before = page.evaluate("punch.run.curves.F_bar.slice(0, 301)")
    page.get_by_label("carry on from here").check()
    page.fill("#E-entry", "90")
    page.keyboard.press("Enter")
    finished(page, run=2)
    assert page.evaluate("punch.run.curves.F_bar.slice(0, 301)") == before
    assert page.evaluate("punch.run.curves.U_x[301]") == page.evaluate("punch.run.curves.U_x[300]")
    assert page.evaluate("punch.run.curves.U_x.at(-1)") == 40
    assert page.evaluate("punch.drawn") == 300  # what was looked at stays on screen


def test_a_profile_is_uploaded_and_a_bad_one_leaves_the_run(visit, tmp_path):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Parameters").click()
    (tmp_path / "bad.csv").write_text("x,z\n0,1\n1,one\n")
    page.set_input_files("#profile", tmp_path / "bad.csv")
    page.wait_for_function(
        "() => document.getElementById('profile-error').textContent.includes('line 3')", timeout=PATIENCE
    )
    assert page.evaluate("punch.run.number") == 1
    (tmp_path / "wave.csv").write_text("\n".join(f"{x},{0.0001 * (x - 250) ** 2}" for x in range(0, 501, 5)))
    page.set_input_files("#profile", tmp_path / "wave.csv")
    finished(page, run=2)
    assert (
        page.evaluate("punch.status.values.surface") == "measured" and page.evaluate("punch.status.values.width") == 500
    )
    assert "points" in page.inner_text("#notes") and page.locator("#profile-error").is_hidden()
