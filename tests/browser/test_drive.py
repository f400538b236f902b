"""A drive with a stiffness, on the page."""

import csv
from math import inf
from pathlib import Path

import numpy as np
import pytest
from served import enter, finished, from_menu
from tabs import at_stop

from solver import load_path
from solver.presets import preset


@pytest.fixture(scope="module")
def frames():
    return [frame for frame in load_path(preset("soft-drive").scene) if frame.stage != "approach"]


def test_soft_drive_stretches_while_it_sticks_and_relaxes_in_a_slip(look, frames):
    """Top and stage of every increment are those of the solver, in the picture and in the CSV."""
    page = look("?preset=soft-drive&more=1")
    tops = page.evaluate("punch.run.curves.U_x.map((_, k) => punch.run.top(k)).slice(punch.run.sheared)")
    assert tops == pytest.approx([frame.U_x_top for frame in frames], abs=1e-4)
    slip = next(k for k, frame in enumerate(frames) if frame.slips)
    assert tops[slip] - tops[slip - 1] > frames[slip].U_x - frames[slip - 1].U_x  # the spring takes it along

    last = frames[-1]
    page.keyboard.press("End")
    page.get_by_text(f"Uₓ = {last.U_x:.1f} nm (top {last.U_x_top:.1f} nm)").wait_for()

    from_menu(page, "#take")
    with page.expect_download() as download:
        page.locator("#save-csv").click()
    lines = Path(download.value.path()).read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    for name in ("U_x_top", "delta_top"):
        found = [float(row[f"{name} (nm)"]) for row in rows]
        assert found == pytest.approx([getattr(frame, name) for frame in frames], abs=1e-4)


@pytest.mark.thorough
def test_drive_is_entered_in_the_parameters_kept_in_the_address_and_drawn_unless_rigid(look):
    page = look("?drive_t=4&u_x_max=3&more=1")
    assert "drive_t=4" in page.url and page.evaluate("punch.run.driven")
    entered = page.evaluate("punch.status.values")
    assert (entered["drive_t"], entered["drive_n"]) == (4, "inf")
    from_menu(page, "#parameters")
    enter(page, "drive_t", "0")
    page.get_by_text("allowed: 10⁻⁶ to 10⁶ or inf MPa/nm").first.wait_for()
    enter(page, "drive_t", "inf")
    finished(page, run=2)
    assert page.evaluate("punch.status.values.drive_t") == "inf" and not page.evaluate("punch.run.driven")
    assert "drive_t" not in page.url


@pytest.mark.thorough
def test_tour_question_on_a_soft_drive_matches_the_solver(look):
    page = at_stop(look("?more=0"), 7)
    page.evaluate("punch.speed = 40")
    page.locator("button.answer", has_text="after a longer pull, at the same force").click()
    page.locator("#tour-card [role=status]", has_text="Yes.").wait_for()
    scenes = [preset("fig6").scene.changed(drive_t=drive_t) for drive_t in (inf, 10.0)]
    rigid, soft = (next(frame for frame in load_path(scene) if frame.U_x > 0 and frame.slips) for scene in scenes)
    rigid, soft = rigid.slips[0], soft.slips[0]
    assert soft.load > 1.5 * rigid.load and np.isclose(soft.F_bar, rigid.F_bar, rtol=1e-2)
