"""The share dialog in Chromium: link, QR code, pictures, data files and Python code."""

import csv
import io
import json
import re
import signal
import socket
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from served import PARABOLA, Server, finished, from_menu, laid_out, patient

from solver.cli import main as command_line

pytestmark = [pytest.mark.thorough]


@pytest.fixture
def sheet(look):
    """The sheet of a run at rest, opened by keyboard."""
    page = look("?delta_bar=0.4&phi_ratio=0.1&k=209&theme=light")
    page.wait_for_function("punch.drawn === 209")
    from_menu(page, "#take")
    page.locator("#share").wait_for()  # it empties the field of an earlier run
    page.wait_for_function("document.getElementById('share-python').value")
    yield page
    page.keyboard.press("Escape")


def saved(page, button):
    """The bytes of the file that a button saves."""
    with page.expect_download() as download:
        page.locator(button).press("Enter")
    return download.value.path().read_bytes()


@pytest.fixture(scope="module")
def named():
    """A server that accepts another name of this machine than the loopback's."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    running = Server(port=port, BOKEH_ALLOW_WS_ORIGIN=f"127.0.0.2:{port}")
    running.wait_for("visitors open")
    yield running
    running.stop()


def test_link_and_code_of_localhost_carry_the_address_that_other_machines_reach(named, browser):
    page = patient(browser.new_page(viewport={"width": 1280, "height": 720}))
    page.goto(f"{named.address}?u_x_max=4&du_x=0.5&theme=dark")
    finished(page)
    from_menu(page, "#take")
    page.locator("#share-qr").wait_for()
    link = page.input_value("#share-link")
    assert link.startswith(f"http://127.0.0.2:{named.port}/app?")
    assert f'src="http://127.0.0.2:{named.port}/app?' in page.input_value("#share-frame")
    assert not page.locator("#share-here").is_visible()
    other = patient(browser.new_page())
    other.goto(link)
    finished(other)
    other.close()
    page.locator("#enlarge-qr").click()
    page.locator("#qr img").wait_for()
    box = page.locator("#qr img").bounding_box()
    assert box["width"] == box["height"] > 0.9 * 720 and box["y"] >= 0 and box["y"] + box["height"] <= 720
    assert page.inner_text("#qr-link") == link
    page.locator("#qr img").click()
    page.locator("#qr").wait_for(state="hidden")
    page.locator("#share-link").wait_for()  # the dialog below stays
    page.close()


def test_a_link_that_only_this_computer_opens_says_so_with_the_command_for_a_class(sheet):
    assert sheet.inner_text("#share-here").startswith("Only this computer opens the link.")
    if sheet.is_visible("#share-start"):  # otherwise the machine has no address in a network
        port = sheet.evaluate("location.port")
        assert re.search(rf"--port {port} --allow-websocket-origin \S+:{port}", sheet.inner_text("#share-command"))
    assert not sheet.locator("#share-qr").is_visible()  # a phone would open its own localhost


def test_link_restores_scene_and_increment(sheet, visit):
    link = sheet.input_value("#share-link")
    assert "k=209" in link
    again = visit(link[link.index("?") :])
    again.wait_for_function("punch.drawn === 209 && !punch.playing")
    assert again.evaluate("punch.run.curves.F_bar") == sheet.evaluate("punch.run.curves.F_bar")


def test_share_dialog_has_embedding_html_and_names_the_setting_that_allows_it(sheet):
    html = sheet.input_value("#share-frame")
    assert html.startswith("<iframe src=") and "embed=1" in html and "delta_bar=0.4" in html
    assert "APP_FRAME_ANCESTORS" in sheet.inner_text("#share-frames")


CLIPBOARDS = {  # of a browser: how it comes about
    "answers": "",
    "never answers": "board.writeText = () => new Promise(() => {})",
    "is missing": "Object.defineProperty(navigator, 'clipboard', { value: undefined, configurable: true })",
}


@pytest.mark.parametrize("clipboard", CLIPBOARDS)
def test_link_and_python_code_are_copied_whatever_the_clipboard_does(sheet, clipboard):
    """On plain http there is no navigator.clipboard; an unhandled promise was once rejected there."""
    sheet.context.grant_permissions(["clipboard-read", "clipboard-write"])
    sheet.evaluate(f"() => {{ window.board = navigator.clipboard; {CLIPBOARDS[clipboard]} }}")
    for button, field in (("#copy-link", "#share-link"), ("#copy-python", "#share-python")):
        sheet.locator("#share-status").evaluate("(said) => { said.textContent = '' }")
        sheet.locator(button).press("Enter")
        sheet.wait_for_function("document.getElementById('share-status').textContent.includes('copied')")
        assert sheet.evaluate("board.readText()") == sheet.input_value(field)
    sheet.evaluate("() => new Promise((done) => setTimeout(done, 1100))")  # after that for the clipboard's answer
    sheet.evaluate("() => { delete board.writeText; delete navigator.clipboard }")


def test_exported_files_match_those_of_the_command_line(sheet, tmp_path):
    files = {kind: tmp_path / f"run.{kind}" for kind in ("csv", "npz", "json")}
    options = [text for kind, file in files.items() for text in (f"--{kind}", str(file))]
    assert command_line(["run", "--set", "delta_bar=0.4", "phi_ratio=0.1", *options]) == 0
    scene, *lines = saved(sheet, "#save-csv").decode().splitlines()
    assert scene.startswith("# ") and "δ/δ₀ = 0.4" in scene
    own = list(csv.DictReader(lines))
    assert [row["U_x (nm)"] for row in own[:4]] == ["0", "0.1", "0.2", "0.3"]  # not 0.30000001
    rows = [row for row in csv.DictReader(files["csv"].open()) if row["stage"] != "approach"]
    assert len(own) == len(rows) and own[0].keys() == rows[0].keys()
    assert all(one[name] == other[name] for one, other in zip(own, rows, strict=True) for name in ("stage", "slip"))
    for name in ("U_x (nm)", "U_x_top (nm)", "F (N/m)", "L (N/m)", "A (nm)"):
        pairs = zip(own, rows, strict=True)
        assert all(float(a[name]) == pytest.approx(float(b[name]), rel=1e-6, abs=1e-5) for a, b in pairs)
    arrays, expected = np.load(io.BytesIO(saved(sheet, "[data-file=npz]"))), np.load(files["npz"])
    assert arrays.files == expected.files
    report, written = json.loads(saved(sheet, "[data-file=json]")), json.loads(files["json"].read_text())
    assert report.keys() == written.keys()
    assert all(report[name] == written[name] for name in ("version", "method", "scene", "converged", "slips"))


def test_every_view_is_saved_as_a_png_as_on_screen(sheet):
    laid_out(sheet, (1280, 900))
    names = sheet.evaluate("[...document.getElementById('share-view').options].map((one) => one.value)")
    assert names[0] == "punch" and "forces" in names
    for name in names:
        sheet.select_option("#share-view", name)
        picture = Image.open(io.BytesIO(saved(sheet, "#save-png"))).convert("RGB")
        view = sheet.locator("#punch-view" if name == "punch" else f".view[data-view={name}]").bounding_box()
        assert picture.width == round(view["width"]) and picture.height >= int(view["height"])
        assert len(picture.getcolors(1_000_000)) > 50  # axes and curves
    sheet.select_option("#share-view", "punch")
    picture = np.asarray(Image.open(io.BytesIO(saved(sheet, "#save-png"))).convert("RGB")).astype(int)
    bands = picture[int(0.78 * len(picture)) : int(0.95 * len(picture))]
    assert (abs(bands - [0, 122, 90]).max(axis=2) < 20).any()  # --shear, of the lower band
    punch = picture[int(0.25 * len(picture)) : int(0.4 * len(picture)), picture.shape[1] // 2 :]
    assert np.ptp(punch, axis=2).max() > 60  # colours of the fringes, behind the plot


@pytest.mark.thorough
def test_shared_python_code_of_a_measured_surface_reads_its_profile_from_json(look, tmp_path):
    page = look("?u_x_max=4&du_x=0.5")
    (tmp_path / "wave.csv").write_text("x (nm),z (nm)\n" + PARABOLA)
    from_menu(page, "#parameters")
    page.set_input_files("#profile", tmp_path / "wave.csv")
    page.get_by_role("button", name="Use it").click()
    finished(page, run=2)
    page.locator("#drawer").get_by_role("button", name="Close").click()
    from_menu(page, "#take")
    page.locator("#share").wait_for()  # it empties the field of an earlier run
    page.wait_for_function("document.getElementById('share-python').value")
    (tmp_path / "mixed-mode-contact.json").write_bytes(saved(page, "[data-file=json]"))
    lines = page.input_value("#share-python")
    command = [sys.executable, "-c", lines]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=True)
    assert int(ran.stdout.split()[0]) == page.evaluate("punch.run.length")


@pytest.mark.skipif(sys.platform == "win32", reason="no process can be stopped for a while")
def test_a_file_that_a_silent_server_does_not_make_is_given_up_with_the_reason(browser):
    silent = Server()
    silent.wait_for("workers are warm")
    page = patient(browser.new_page())
    page.goto(silent.address)
    finished(page)
    from_menu(page, "#take")
    page.wait_for_function("document.getElementById('share-python').value")
    silent.process.send_signal(signal.SIGSTOP)
    page.locator("[data-file=json]").press("Enter")
    page.locator("#share-status", has_text="server does not answer").wait_for()
    page.locator("#lost", has_text="Connection lost").wait_for()
    silent.process.send_signal(signal.SIGCONT)
    page.close()
    silent.stop()
