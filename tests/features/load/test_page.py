"""The page "Friction over load": the first slips of the runs that a visitor has seen."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from served import enter
from tabs import imported

from app.features.load.page import DEPTHS
from solver import Scene, load_path

COARSE = {"nodes": 256, "width": 625.0, "du_x": 0.2, "du_z": 0.5, "u_x_max": 20.0}
ADDRESS = "&".join(f"{name}={value:g}" for name, value in COARSE.items())
POINTS = "document.getElementById('load-count').textContent === '{} point{}'"
COLUMN = "[...charts.load_slips.parts['{}'].{}]"  # of a part, along an axis


def first_slip(**changed):
    scene = Scene(**COARSE | changed)
    slip = next(frame.slips[0] for frame in load_path(scene) if frame.stage == "shear" and frame.slips)
    return slip.L_bar * scene.width * scene.E, slip.F_bar * scene.width * scene.E


def has_points(page, count):
    page.wait_for_function(POINTS.format(count, "" if count == 1 else "s"))


def said(page, name):
    """What the chart says where the mouse points at the first mark of a part."""
    return page.evaluate(
        """(name) => {
            const chart = charts.load_slips, { x, y } = chart.parts[name], { X, Y } = chart.box
            return chart.says(null, { x: X(x[0]), y: Y(y[0]) })
        }""",
        name,
    )


def cleared(look, address):
    """The app at an address, without the points of the runs before.

    A point names the one parameter that differs from those of the run before: here several do.
    """
    page = look(f"?{ADDRESS}&E=50&phi_ratio=0.9")
    imported(page, "features/load/slips").evaluate("modules.slips.clear()")
    return look(address)


@pytest.fixture
def page(look):
    page = cleared(look, f"?page=load&{ADDRESS}")
    has_points(page, 1)
    return page


def test_each_run_adds_the_load_and_force_of_its_first_slip_by_changed_parameter(page):
    page.locator("#E").focus()
    page.keyboard.press("ArrowRight")
    has_points(page, 2)
    E = page.evaluate("punch.status.values.E")
    enter(page, "delta_bar", "-0.3")
    has_points(page, 3)
    expected = {"several": {}, "E": {"E": E}, "delta_bar": {"E": E, "delta_bar": -0.3}}
    for name, changed in expected.items():
        points = [page.evaluate(COLUMN.format(name, column)) for column in "xy"]
        assert np.ravel(points) == pytest.approx(first_slip(**changed), rel=1e-4)  # single precision, and round-off
    assert said(page, "E")[0] == f"E = {E:g} GPa"
    L, F = first_slip(**expected["delta_bar"])
    assert L < 0 < F  # adhesion alone holds


@pytest.mark.thorough
def test_repeated_scenes_and_runs_without_a_slip_add_no_point(page):
    for value, count in (("80", 2), ("70", 2)):
        enter(page, "E", value)
        page.wait_for_function(f"punch.status.values.E === {value}")
        page.wait_for_function(f"punch.run.head.scene.E === {value} && punch.run.whole && !punch.run.followed")
        has_points(page, count)
    enter(page, "phi_ratio", "0")
    page.wait_for_function("punch.run.head.scene.phi_ratio === 0 && punch.run.whole && !punch.fresh")
    has_points(page, 2)


@pytest.mark.thorough
def test_points_stay_while_the_page_is_closed_and_clear_removes_them(page):
    page.locator("#load .close").click()
    page.wait_for_function("document.getElementById('load').hidden")
    enter(page, "E", "80")
    page.wait_for_function("punch.run.head.scene.E === 80 && punch.run.whole && !punch.fresh")
    page.evaluate("document.querySelector('nav button[data-page=load]').click()")
    has_points(page, 2)
    page.locator("#load-clear").click()
    has_points(page, 0)
    page.wait_for_function("!charts.load_slips.changed")
    enter(page, "E", "90")
    has_points(page, 1)
    assert len(page.evaluate(COLUMN.format("E", "x"))) == 1  # compared with the run before


def test_run_through_points_leaves_the_first_slip_of_its_path_named_as_such(look):
    points = "0,-1; 0,0.2; 4,0.2; 4,-1"
    page = cleared(look, f"?page=load&{ADDRESS}&path=points&points={points}")
    has_points(page, 1)
    frames = load_path(Scene(**COARSE | {"path": "points", "points": points}))
    frame = next(frame for frame in frames if frame.stage != "approach" and frame.slips)
    assert frame.stage == "3 unload"  # the shear ends before a slip, and the pull-off is one
    point = [page.evaluate(COLUMN.format("several", column))[0] for column in "xy"]
    event = frame.slips[0]
    assert point == pytest.approx([event.L_bar * frame.unit, event.F_bar * frame.unit], rel=1e-4, abs=1e-3)
    assert said(page, "several")[0] == "first slip of the path" and said(page, "several")[1] == "in stage 3 unload"


@pytest.mark.thorough
def test_points_are_exported_as_csv(page):
    enter(page, "E", "80")
    has_points(page, 2)
    with page.expect_download() as download:
        page.locator("#load-csv").click()
    rows = list(csv.DictReader(Path(download.value.path()).read_text(encoding="utf-8").splitlines()))
    assert [(row["changed"], float(row["E"])) for row in rows] == [("", 70.0), ("E", 80.0)]
    for row in rows:
        point = [float(row[name]) for name in ("L (N/m)", "F_s (N/m)")]
        assert point == pytest.approx(first_slip(E=float(row["E"])), rel=1e-4)


@pytest.mark.thorough
def test_a_single_point_without_load_lies_on_axes_of_the_size_of_forces(look):
    """Flats at zero gap bear no load. An axis of 0.2 N/m or less would suggest that its numbers mean something."""
    page = cleared(look, "?preset=fig4a-red&page=load")
    has_points(page, 1)
    L = page.evaluate("(({ start, end }) => [start, end])(charts.load_slips.x)")
    assert L[0] < -1.0 and L[1] > 1.0


def test_sweep_of_the_press_depth_adds_twelve_runs_of_one_interface_and_their_force_without_load(page):
    page.get_by_role("button", name="Sweep the press depth").click()
    has_points(page, 12)  # the run on screen is one of them
    page.wait_for_function("!charts.load_slips.changed")  # painted, also while nothing plays
    joined = np.array([page.evaluate(COLUMN.format("runs", column)) for column in "xy"])
    expected = np.array([first_slip(delta_bar=depth) for depth in DEPTHS]).T
    np.testing.assert_allclose(joined, expected, rtol=1e-3, atol=0.05)
    held = np.interp(0.0, *expected)
    slope, offset = np.polyfit(*expected, 1)
    line = np.array([page.evaluate(COLUMN.format("law", column)) for column in "xy"])
    np.testing.assert_allclose(np.polyfit(*line, 1), [slope, offset], rtol=1e-3)
    said = page.inner_text("#load-law")
    numbers = [float(text) for text in re.findall(r"\d+\.?\d*(?= N/m)", said)]
    miss = np.abs(slope * expected[0] + offset - expected[1]).max()
    assert "At L = 0 adhesion alone holds" in said
    assert numbers == pytest.approx([held, offset, miss], rel=0.01)
    enter(page, "E", "90")  # another interface, of one run so far
    has_points(page, 13)
    assert not page.evaluate(COLUMN.format("runs", "x"))
    assert "adhesion" not in page.inner_text("#load-law")
    page.locator("#load-clear").click()
    has_points(page, 0)
