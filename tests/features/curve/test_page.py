"""A measured curve over the run on screen, in Chromium."""

import io

import numpy as np
import pytest
from served import finished
from tabs import imported

from solver import Scene, simulate
from solver.measured.curves import read_measurement

pytestmark = pytest.mark.thorough

DROP = """([name, text]) => {
    const dataTransfer = new DataTransfer()
    dataTransfer.items.add(new File([text], name))
    document.dispatchEvent(new DragEvent("drop", { dataTransfer, cancelable: true, bubbles: true }))
}"""
SCENE = {"u_x_max": 16.0, "phi_ratio": 0.5}
ADDRESS = "?" + "&".join(f"{name}={value}" for name, value in SCENE.items())


def made(frames, x, y, times=1.0, plus=0.0, every=2):
    """A CSV of two quantities of frames, y times a factor, plus a zero and noise of 1 %."""
    values = np.array([(getattr(frame, x), getattr(frame, y)) for frame in frames[::every]])
    noise = 0.01 * np.abs(values[:, 1]).max() * np.random.default_rng(1).normal(size=len(values))
    unit = {"U_x": "nm", "delta": "nm", "A": "nm", "F": "N/m", "L": "N/m"}
    rows = zip(values[:, 0], times * values[:, 1] + plus + noise, strict=True)
    return "\n".join([f"{x} ({unit[x]}),{y} ({unit[y]})", *(f"{a:.8g},{b:.8g}" for a, b in rows)])


def dropped(page, text, name="curve.csv"):
    page.evaluate(DROP, [name, text])
    page.wait_for_function("(name) => document.getElementById('laid')?.innerText.includes(name)", arg=name)
    page.wait_for_function("!punch.fresh")


@pytest.fixture(scope="module")
def run():
    return simulate(Scene(**SCENE))


@pytest.mark.parametrize(
    ("kind", "x", "y", "chart"),
    [("friction", "U_x", "F", "forces"), ("area", "U_x", "A", "area"), ("area over force", "F", "A", "relation")],
)
def test_a_dropped_curve_is_drawn_over_its_own_and_says_how_far_as_python_does(visit, run, kind, x, y, chart):
    page = visit(ADDRESS)
    frames = [frame for frame in run.frames if frame.stage == "shear"]
    if x == "F":
        frames = [frame for frame in frames if frame.U_x <= run.first_slip.U_s]
    text = made(frames, x, y, times=1.2)
    dropped(page, text)
    points, found = imported(page, "features/curve/measured").evaluate(
        """(y) => {
            const { laid: { curve, set }, charted } = punch, { pointsOf, laidOver } = modules.measured
            return [pointsOf(curve, y, charted, set), laidOver(curve, charted).apart(set)]
        }""",
        y,
    )
    assert 20 < page.evaluate(f"charts.{chart}.parts.laid_{y}.x.length") <= 150
    measured = read_measurement(run.scene, io.StringIO(text))
    (segment,) = measured.segments
    assert np.allclose(points["x"], segment.x) and np.allclose(points["y"], segment.values[y])
    expected = measured.residuals(run)
    assert found["rms"] == pytest.approx(expected.rms[y], rel=2e-3)
    assert found["noise"] == pytest.approx(expected.noise[y], rel=1e-6)
    assert abs(found["outside"] - expected.outside) <= 2  # a file is rounded, at either end of the run
    assert f"{kind}" in page.inner_text("#laid-says") and "rms difference" in page.inner_text("#laid-says")


def test_a_curve_longer_than_the_run_is_drawn_and_compared_where_the_run_is(visit):
    page = visit("?u_x_max=4")
    dropped(page, "U_x (nm),F (N/m)\n" + "\n".join(f"{0.5 * k},{k}" for k in range(61)))
    page.locator("#laid-says").get_by_text("52 of 61 points lie beyond the run").wait_for()
    assert page.evaluate("charts.forces.parts.laid_F.y.length") > 20


def test_match_finds_scale_and_zero_and_the_number_follows_a_dragged_slider(visit, run):
    page = visit(ADDRESS)
    frames = [frame for frame in run.frames if frame.stage == "shear"]
    dropped(page, made(frames, "U_x", "F", times=0.5, plus=3.0))
    page.click("#laid summary")
    page.click("#laid-match")
    page.wait_for_function("Math.abs(punch.laid.set.scale - 2) < 0.02 && Math.abs(punch.laid.set.zero + 6) < 0.5")
    near = page.inner_text("#laid-says b")
    page.focus("#phi_ratio")
    for _ in range(8):
        page.keyboard.press("ArrowLeft")
    page.wait_for_function("(text) => document.querySelector('#laid-says b').textContent !== text", arg=near)
    assert page.evaluate("charts.forces.parts.laid_F.y.length") > 20
    page.click("#laid-plain")
    page.wait_for_function("punch.laid.set.scale === 1 && punch.laid.set.zero === 0")
    page.click("#laid-remove")
    page.wait_for_function("!charts.forces.parts.laid_F.y.length && !punch.laid")


def test_load_over_approach_finds_its_zero_and_asks_for_the_path_that_has_it(visit):
    unloading = simulate(Scene(path="unload"))
    frames = [frame for frame in unloading.frames if frame.stage in ("approach", "unload")]
    rows = [f"{250.0 - frame.delta:.6g},{frame.L:.6g}" for frame in frames]
    page = visit("?path=shear&u_x_max=4")
    dropped(page, "\n".join(["height (nm),load (N/m)", *rows]))
    assert "this run has no retraction" in page.inner_text("#laid-says")
    page.click("#laid-path")
    page.wait_for_function("punch.status.values.path === 'unload' && charts.forces.parts.laid_L.y.length")
    page.wait_for_function("Math.abs(punch.laid.set.shift - 250) < 0.2")


def test_a_curve_that_no_zero_brings_over_the_run_is_not_drawn(visit):
    far = [f"{x},{-1e-9 * x}" for x in range(0, 2000, 4)]  # N over 2 um, falling as the surfaces approach
    page = visit("?path=unload&u_x_max=4")
    dropped(page, "\n".join(["height (nm),load (N)", *far, *reversed(far)]))
    page.locator("#laid-says").get_by_text("no zero and positive scale").wait_for()
    assert not page.evaluate("charts.forces.parts.laid_L.y.length")


def test_a_file_without_its_speed_asks_for_it_and_an_empty_one_loses_nothing(visit):
    page = visit(ADDRESS)
    dropped(page, "time (s),F (N/m)\n" + "\n".join(f"{0.1 * k},{k % 30}" for k in range(100)))
    page.fill("#laid-asked", "1.5")
    page.click("#laid-ask button")
    page.locator("#laid-says").get_by_text("0.0 to 14.9 nm").wait_for()
    dropped(page, "", "empty.csv")
    page.locator("#laid-why").get_by_text("it is empty").wait_for()
    assert page.evaluate("charts.forces.parts.laid_F.y.length") > 20


def test_fit_from_here_opens_the_page_with_scene_and_curve(visit, run):
    page = visit(ADDRESS)
    dropped(page, made([frame for frame in run.frames if frame.stage == "shear"], "U_x", "F"))
    with page.context.expect_page() as opened:
        page.click("#laid-fit")
    opened.value.get_by_text("recognised, noise").wait_for()
    assert "phi_ratio=0.5" in opened.value.url


def test_a_page_opened_again_after_a_lost_connection_asks_for_the_curve(visit, run):
    page = visit(ADDRESS)
    dropped(page, made([frame for frame in run.frames if frame.stage == "shear"], "U_x", "F"))
    page.evaluate("document.dispatchEvent(new Event('connection-lost'))")
    page.locator("#laid-why").get_by_text("curve.csv: the connection was lost, and the curve with it").wait_for()
    finished(page)
    assert page.evaluate("punch.status.values.phi_ratio") == 0.5
