"""Loops, unloading, paths through points and uploaded profiles in Chromium."""

import csv
import io
import re

import pytest
from served import finished, from_menu, paused_at

pytestmark = pytest.mark.thorough
AXIS = "charts.forces.across"


def test_a_friction_loop_is_plotted_with_its_dissipated_energy(look):
    page = look("?preset=loop")
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


def test_unloading_is_plotted_over_indentation(look):
    page = look("?preset=unload")
    assert "δ" in page.evaluate(AXIS)
    dashes = "document.querySelectorAll('main .forces .key > :not([hidden]) > .dashed').length"
    assert page.evaluate(dashes) == 0  # both ways pass the same places: the load is a whole line, as in its key
    low, high = page.evaluate("punch.run.extent()")
    assert low <= -10 and high == 2
    page.select_option("#preset", "fig6")
    finished(page, run=2)
    assert "Uₓ" in page.evaluate(AXIS) and page.evaluate(dashes) == 1
    assert page.evaluate("punch.ghost") is None  # another experiment: nothing to compare


def test_a_run_through_points_is_plotted_over_path_length(look):
    page = look("?path=points&points=0,-1;0,0.2;4,0.2;6,-1&nodes=256&width=625")
    assert page.evaluate(AXIS) == "length of the path (nm)"
    assert page.evaluate("punch.run.head.stages") == ["approach", "2 shear", "3 move"]
    along = page.evaluate("[...punch.run.along]")
    assert along == sorted(along) and along[-1] == pytest.approx(4 + (2**2 + 12**2) ** 0.5, abs=1e-4)
    assert page.evaluate("punch.run.extent()") == pytest.approx([0, along[-1]], abs=1e-4)
    assert page.locator("#delta_bar").is_disabled()  # the points set the depth
    page.select_option("#preset", "fig6")
    finished(page, run=2)
    assert page.locator("#delta_bar").is_enabled()


WORDS = """() => {  // what is written over the punch, from now on
    const pen = CanvasRenderingContext2D.prototype, { fillText } = pen
    if (window.words) return
    window.words = []
    pen.fillText = function (text, ...place) {
        window.words.push(text)
        return fillText.call(this, text, ...place)
    }
}"""


def forces_of(page, k):
    """{place on the page: friction of increment k in N/m}."""
    page.mouse.move(0, 0)  # over a curve it would show the increment there
    page.evaluate("window.words = []")
    paused_at(page, k)
    page.wait_for_function(f"punch.drawn === {k} && !punch.fresh")
    from_menu(page, "#take")
    page.locator("#show-table").wait_for()
    page.locator("#show-table").press("Enter")
    page.locator("#table").wait_for()
    at = f"[{k} - punch.run.sheared]"
    row = page.evaluate(f"[...document.querySelectorAll('#table tbody tr')]{at}.cells[2].textContent")
    page.keyboard.press("Escape")
    page.locator("#table").wait_for(state="hidden")
    page.keyboard.press("Escape")
    page.locator("#share").wait_for(state="hidden")
    said, words = page.inner_text("#readout"), " ".join(page.evaluate("window.words"))
    spoken = page.text_content("#announcement")
    seen = {
        "punch": re.findall(r"F = (\S+) N/m", words)[-1],
        "readout": re.search(r"F = (\S+) N/m", said)[1],
        "table": row,
        "spoken": re.search(r"friction (\S+) newtons", spoken)[1] if "friction" in spoken else "0",
        "curve": page.evaluate(f"punch.run.shear('F'){at}"),
    }
    return {name: float(str(value).replace("−", "-")) for name, value in seen.items()}


def test_punch_readout_table_curve_announcement_and_csv_show_the_same_force(look):
    page = look()
    page.evaluate(WORDS)
    slips = page.evaluate("punch.run.curves.slip.flatMap((slip, k) => (slip && k >= punch.run.sheared ? [k] : []))")
    shown = forces_of(page, slips[1])  # where it rests, the page says its forces aloud
    for name, value in shown.items():
        assert value == pytest.approx(shown["curve"], rel=5e-3), name
    from_menu(page, "#take")
    page.locator("#save-csv").wait_for()
    with page.expect_download() as download:
        page.locator("#save-csv").press("Enter")
    text = download.value.path().read_text()
    rows = list(csv.DictReader(io.StringIO("".join(line for line in text.splitlines(True) if line[0] != "#"))))
    F = [float(row["F (N/m)"]) for row in rows]
    assert pytest.approx(F, rel=1e-5, abs=1e-3) == page.evaluate("[...punch.run.shear('F')]")
    page.keyboard.press("Escape")
    page.locator("#share").wait_for(state="hidden")
