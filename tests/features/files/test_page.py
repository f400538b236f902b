"""The dialog about a measured file, and a measured curve over the run on screen, in Chromium."""

import numpy as np
import pytest
from served import PARABOLA, enter, finished, found_by_axe, from_menu, values_are

from solver import Scene, simulate
from solver.measured.curves import read_measurement

DROP = """async ([name, text, times]) => {
    const dataTransfer = new DataTransfer()
    dataTransfer.items.add(new File([text.repeat(times)], name))
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, cancelable: true, bubbles: true }))
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


def drop(page, text, name="curve.csv", times=1):
    """Drop a file of this text, and wait for what the server sees in it."""
    page.evaluate(DROP, [name, text, times])
    page.get_by_role("dialog", name=name).wait_for()
    page.wait_for_function("document.getElementById('file-sent').hidden")


def use(page):
    page.get_by_role("button", name="Use it").click()
    page.locator("#file-of").wait_for(state="hidden")


def laid(page, text, name="curve.csv"):
    """Drop a file that names everything, use it, and wait until it is compared."""
    drop(page, text, name)
    use(page)
    page.wait_for_function("punch.laid?.apart && !punch.fresh")


def drawn(page, chart, name):
    return page.evaluate(f"charts.{chart}.parts.{name}.x.length")


@pytest.fixture(scope="module")
def run():
    return simulate(Scene(**SCENE))


def sheared(run):
    return [frame for frame in run.frames if frame.stage == "shear"]


def test_a_profile_without_names_and_units_is_asked_about_and_becomes_the_surface(visit):
    page = visit("?u_x_max=4&du_x=0.5")
    drop(page, PARABOLA, "stylus.csv")
    assert page.locator("#file-use").is_disabled()
    page.locator("#file-why", has_text="what kind of data").wait_for()
    page.get_by_label("kind").select_option("surface profile")
    page.locator("#file-why", has_text="x has no unit").wait_for()
    for unit in page.get_by_role("combobox", name="unit").all():
        unit.select_option("nm")
    page.locator("#file-says", has_text="500 nm long, 6.25 nm high").wait_for()
    assert page.locator("#file-drawing polyline").get_attribute("points").count(",") > 20
    use(page)
    values_are(page, surface="measured", width=500)
    assert "points" in page.inner_text("#notes")
    assert page.evaluate("document.activeElement.id") == "menu"


@pytest.mark.thorough
def test_a_part_between_handles_and_the_columns_of_any_table_are_chosen(visit):
    page = visit("?u_x_max=4&du_x=0.5")
    rows = "\n".join(f"{k};{k * 3},0;{3 * np.sin(2 * np.pi * k / 200):.4f}".replace(".", ",") for k in range(201))
    drop(page, f"Stylus 7\nIndex;Weg;Hub\n{rows}", "komma.csv")
    assert page.locator("#file-rows").get_by_text("Stylus 7").is_visible()
    page.get_by_label("Weg: what it is").select_option("x")
    page.get_by_label("Hub: what it is").select_option("z")
    page.locator("#file-why", has_text="x has no unit").wait_for()
    page.get_by_label("Weg: unit").select_option("nm")
    page.get_by_label("Hub: unit").select_option("other …")
    page.get_by_label("Hub: what 1 is").fill("2 nm")
    page.get_by_label("Hub: what 1 is").press("Enter")
    page.locator("#file-says", has_text="600 nm long, 12 nm high").wait_for()
    page.get_by_label("part to").press("PageDown")
    page.locator("#file-says", has_text="540 nm of 600 nm long").wait_for()
    use(page)
    values_are(page, surface="measured", width=540)


@pytest.mark.thorough
def test_a_steep_profile_offers_a_filter_that_makes_it_flat_enough(visit):
    page = visit("?u_x_max=4&du_x=0.5")
    rows = "\n".join(f"{x},{3 * np.sin(x / 60) + 5 * (x % 2):.4f}" for x in range(400))
    drop(page, f"x (nm),z (nm)\n{rows}", "rough.csv")
    page.get_by_role("button", name="Remove waves shorter than").click()
    page.locator("#file-says", has_text="nm long").wait_for()
    use(page)
    values_are(page, surface="measured")


@pytest.mark.parametrize(
    ("name", "text", "times", "said"),
    [
        ("empty.csv", "", 1, "It is empty; choose a file with columns of numbers"),
        ("paper.pdf", "%PDF-1.7\0", 1, "This is a PDF; export its numbers as CSV"),
        ("wide.csv", ",".join("1" * 500) + "\n", 20, "500 columns; allowed: up to 100"),
        ("large.csv", "1,2\n" * 1000, 5001, "It has 20.0 MB, allowed: 20 MB"),
        ("words.txt", "no numbers at all\n", 3, "No points; needed: columns of numbers"),
    ],
)
def test_what_is_no_measurement_is_refused_in_a_sentence_and_the_run_stays(visit, name, text, times, said):
    page = visit("?u_x_max=4")
    drop(page, text, name, times)
    page.locator("#file-why", has_text=said).wait_for()
    assert page.locator("#file-use").is_disabled()
    page.keyboard.press("Escape")
    page.wait_for_function("document.activeElement.id === 'menu'")
    assert page.evaluate("punch.run.number") == 1


@pytest.mark.thorough
def test_after_a_file_that_is_too_large_the_one_before_is_not_used_under_its_name(visit):
    page = visit("?u_x_max=4")
    drop(page, "U_x (nm),F (N/m)\n" + "\n".join(f"{k},{k % 7}" for k in range(40)), "good.csv")
    page.locator("#file-says", has_text="40 points").wait_for()
    drop(page, "1,2\n" * 1000, "large.csv", 5001)
    page.locator("#file-why", has_text="allowed: 20 MB").wait_for()
    assert page.locator("#file-use").is_disabled() and not page.locator("#file-rows").is_visible()
    assert not page.inner_text("#file-says")


CHANGES = """() => {  // the second piece of a file that changes meanwhile cannot be read
    const slice = File.prototype.slice
    File.prototype.slice = function (from, to) {
        return from ? { size: to - from, arrayBuffer: () => Promise.reject(new Error()) } : slice.call(this, from, to)
    }
}"""


@pytest.mark.thorough
def test_a_file_that_changes_while_it_is_read_says_so(visit):
    page = visit("?u_x_max=4")
    page.evaluate(CHANGES)
    page.evaluate(DROP, ["growing.csv", "1,2\n" * 1000, 500])
    page.locator("#file-why", has_text="It has changed").wait_for()


@pytest.mark.thorough
def test_a_file_of_many_pieces_is_read(visit):
    page = visit("?u_x_max=4")
    drop(page, "U_x (nm),F (N/m)\n" + "\n".join(f"{k / 1e4:.5f},{k % 97}" for k in range(1, 160_000)), "long.csv")
    page.locator("#file-says", has_text="159,999 points").wait_for()


@pytest.mark.thorough
def test_a_file_that_is_dropped_as_the_dialog_closes_is_read(visit):
    page = visit("?u_x_max=4")
    drop(page, "U_x (nm),F (N/m)\n" + "\n".join(f"{k},{k % 7}" for k in range(40)), "first.csv")
    # its event `close` comes after the drop
    page.evaluate(DROP.replace("{", "{ document.getElementById('file-of').close()\n", 1), ["second.csv", "1,2\n", 40])
    page.locator("#file-why", has_text="what kind of data").wait_for()


@pytest.mark.thorough
def test_pages_of_one_table_are_chosen_in_the_menu_of_channels(visit):
    page = visit("?u_x_max=4")
    half = [f"{k},{k % 7}" for k in range(80)]
    drop(page, "\n".join(["U_x (nm),F (N/m)", *half[:40], "", "U_x (nm),F (N/m)", *half[40:]]))
    page.locator("#file-why", has_text="2 tables").wait_for()
    page.get_by_label("channel").select_option("all")
    page.locator("#file-says", has_text="80 points").wait_for()


@pytest.mark.thorough
def test_the_dialog_is_accessible_and_fits_a_phone(visit):
    page = visit("?u_x_max=4")
    drop(page, "index,a,b\n" + "\n".join(f"{k},{k},{k % 7}" for k in range(40)))
    assert not found_by_axe(page)
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_function("document.getElementById('file-of').getBoundingClientRect().right <= innerWidth")
    assert not page.evaluate("document.getElementById('file-of').scrollWidth > innerWidth")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("kind", "x", "y", "chart", "points"),
    [
        ("friction", "U_x", "F", "forces", "laid_F"),
        ("area over displacement", "U_x", "A", "area", "laid_A"),
        ("area over force", "F", "A", "own", "points"),
    ],
)
def test_a_dropped_curve_is_drawn_over_its_own_and_says_how_far_as_python_does(visit, run, kind, x, y, chart, points):
    page = visit(ADDRESS)
    frames = sheared(run)
    if x == "F":
        frames = [frame for frame in frames if frame.U_x <= run.first_slip.U_s]
    text = made(frames, x, y, times=1.2)
    laid(page, text)
    assert 20 < drawn(page, chart, points) <= 150
    found = page.evaluate("punch.laid.apart")
    expected = read_measurement(run.scene, text).residuals(run)
    assert found["rms"][y] == pytest.approx(expected.rms[y], rel=2e-3)
    assert found["noise"][y] == pytest.approx(expected.noise[y], rel=1e-6)
    assert abs(found["outside"] - expected.outside) <= 2  # a file is rounded, at either end of the run
    assert kind in page.inner_text("#laid-says") and "rms difference" in page.inner_text("#laid-says")


def test_a_curve_stays_over_the_run_and_the_number_follows_a_dragged_slider(visit, run):
    page = visit(ADDRESS)
    laid(page, made(sheared(run), "U_x", "F"))
    near = page.inner_text("#laid-says b")
    page.focus("#phi_ratio")
    for _ in range(8):
        page.keyboard.press("ArrowLeft")
    page.wait_for_function("(text) => document.querySelector('#laid-says b')?.textContent !== text", arg=near)
    assert drawn(page, "forces", "laid_F") > 20
    page.get_by_role("button", name="Remove your data").click()
    page.wait_for_function("!charts.forces.parts.laid_F.y.length && !punch.laid")


@pytest.mark.thorough
def test_a_curve_longer_than_the_run_is_compared_where_the_run_is_and_drawn_in_its_own_range(visit):
    page = visit("?u_x_max=4")
    laid(page, "U_x (nm),F (N/m)\n" + "\n".join(f"{0.5 * k},{k}" for k in range(61)))
    page.locator("#laid-says", has_text="52 of 61 points lie beyond the run").wait_for()
    assert page.locator("#laid figure").is_visible() and drawn(page, "own", "points") == 61


@pytest.mark.thorough
def test_a_curve_that_no_run_covers_is_drawn_in_its_own_range_and_says_both(visit):
    page = visit("?path=unload&u_x_max=4")
    far = [f"{x},{1e-9 * max(0, x - 1900)}" for x in range(0, 2000, 4)]
    laid(page, "\n".join(["indentation (nm),load (N)", *far, *reversed(far)]))
    page.locator("#laid-says", has_text="nm in the run, so it is drawn in its own range").wait_for()
    assert not drawn(page, "forces", "laid_L") and drawn(page, "own", "points") > 20
    page.get_by_role("button", name="Columns and part").click()
    page.locator("#file-says", has_text="nm of it used").wait_for()


@pytest.mark.thorough
def test_load_over_approach_finds_its_zero_and_asks_for_the_path_that_has_it(visit):
    unloading = simulate(Scene(path="unload"))
    frames = [frame for frame in unloading.frames if frame.stage in ("approach", "unload")]
    rows = [f"{250.0 - frame.delta:.6g},{frame.L:.6g}" for frame in frames]
    page = visit("?path=shear&u_x_max=4")
    drop(page, "\n".join(["height (nm),load (N/m)", *rows]))
    page.locator("#file-why", has_text="L falls as the surfaces approach").wait_for()
    page.get_by_label("load: sign").select_option("1: as in the file")
    use(page)
    page.get_by_role("button", name="Compute that path").click()
    page.wait_for_function("punch.status.values.path === 'unload' && charts.forces.parts.laid_L.y.length")
    page.wait_for_function("Math.abs(punch.laid.apart.set.delta[1] - 250) < 0.2")


@pytest.mark.thorough
def test_the_stiffness_of_a_lever_that_the_file_names_is_in_its_field_and_stays_removed(visit):
    page = visit(ADDRESS)
    rows = "\n".join(f"{1e-6 - 1e-9 * x:.6e} {1e-9 * x:.6e}" for x in range(31))
    drop(page, f"# springConstant: 2 N/m\n# segment: extend\n# columns: height vDeflection\n# units: m N\n{rows}")
    lever = page.get_by_label("stiffness of the lever (N/m)")
    assert lever.input_value() == "2"
    page.locator("#file-says", has_text="over approach, 15 nm,").wait_for()
    lever.fill("")
    lever.press("Enter")
    page.locator("#file-says", has_text="over approach, 30 nm,").wait_for()
    assert lever.input_value() == ""


@pytest.mark.thorough
def test_a_file_without_its_speed_asks_for_it(visit):
    page = visit(ADDRESS)
    drop(page, "time (s),friction (N/m)\n" + "\n".join(f"{0.1 * k},{k % 30}" for k in range(100)))
    page.get_by_label("speed (nm/s)").fill("1,5")
    page.get_by_label("speed (nm/s)").press("Enter")
    page.locator("#file-says", has_text="nm, 100 points").wait_for()


@pytest.mark.thorough
def test_fit_from_here_opens_the_page_with_scene_and_curve(visit, run):
    page = visit(ADDRESS)
    laid(page, made(sheared(run), "U_x", "F"))
    with page.context.expect_page() as opened:
        page.click("#laid-fit")
    opened.value.get_by_text("recognised, noise").wait_for()
    assert "phi_ratio=0.5" in opened.value.url


@pytest.mark.thorough
def test_a_page_opened_again_after_a_lost_connection_asks_for_the_curve(visit, run):
    page = visit(ADDRESS)
    laid(page, made(sheared(run), "U_x", "F"))
    page.evaluate("document.dispatchEvent(new Event('connection-lost'))")
    page.locator("#laid-why").get_by_text("curve.csv: the connection was lost, and the curve with it").wait_for()
    finished(page)
    assert page.evaluate("punch.status.values.phi_ratio") == 0.5


@pytest.mark.thorough
def test_the_entry_of_the_drawer_reads_a_surface(visit, tmp_path):
    page = visit("?u_x_max=4&du_x=0.5")
    from_menu(page, "#parameters")
    (tmp_path / "wave.csv").write_text("x (nm),z (nm)\n" + PARABOLA)
    page.set_input_files("#profile", tmp_path / "wave.csv")
    page.locator("#file-says", has_text="500 nm long").wait_for()
    use(page)
    values_are(page, surface="measured")
    enter(page, "u_x_max", "5")
    finished(page, run=3)
    assert page.evaluate("punch.status.values.surface") == "measured"
