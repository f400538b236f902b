"""A run saved as one file: it is seen, played and scrubbed without a server and without a network."""

from dataclasses import replace
from string import ascii_letters, digits

import pytest

from app.stage import Stage
from solver import Scene, simulate
from solver.analysis.work import work_of
from solver.results import Result

SMALL = {"nodes": 256, "width": 625.0}  # the default, a quarter as wide
DRAWN = "globalThis.punch?.drawn > 0 && !punch.fresh"


@pytest.fixture
def opened(browser, tmp_path):
    """opened(result): the saved file of a run in a browser without a network; whatever it asks for is on record."""
    context = browser.new_context(offline=True, viewport={"width": 1366, "height": 768})

    def open_file(result):
        file, page = tmp_path / "punch.html", context.new_page()
        page.asked, page.faults = [], []
        page.on("request", lambda request: page.asked.append(request.url))
        page.on("pageerror", lambda error: page.faults.append(str(error)))
        Stage(result, title="A <b>run</b>").save(file)
        page.goto(file.as_uri())
        page.wait_for_function(DRAWN)
        return page

    yield open_file
    context.close()


@pytest.mark.parametrize(
    "scene",
    [
        Scene(**SMALL, u_x_max=14.0),
        Scene(**SMALL, surface="flat", u_x_max=4.0),
        Scene(**SMALL, path="unload"),
        Scene(**SMALL, path="loop", u_x_max=4.0),
    ],
    ids=lambda scene: f"{scene.surface} {scene.path}",
)
def test_a_saved_run_plays_and_scrubs_without_server_and_network(opened, scene):
    result = simulate(scene)
    page = opened(result)
    at = page.evaluate("punch.at")
    page.wait_for_function(f"punch.at !== {at}")
    page.locator("#play").click()
    page.locator("#scrub").fill("3")
    page.wait_for_function("punch.drawn === 3 && !punch.fresh")
    assert page.locator("#sentence").text_content() and page.locator("#status b").text_content() == "saved"
    assert page.evaluate("punch.run.length") == len(result.frames)
    if scene.path == "loop":  # all its increments had none
        assert page.evaluate("punch.run.curves.work") == pytest.approx(work_of(result.frames), rel=1e-5, abs=1e-6)
    assert all(address.startswith(("file:", "data:")) for address in page.asked) and page.faults == []
    assert page.title() == "A <b>run</b>"
    for part in ("header", ".controls", "#grab", "#lost"):
        assert not page.locator(part).first.is_visible()


KEYS = [*ascii_letters, *digits, *"?[] ", "Home", "End", "ArrowLeft", "ArrowRight", "Shift+ArrowLeft", "Escape"]


def test_no_key_and_no_drag_makes_a_saved_run_wait_for_a_server(opened):
    page = opened(simulate(Scene(**SMALL, u_x_max=14.0)))
    page.evaluate("document.activeElement.blur()")
    for key in KEYS:
        page.keyboard.press(key)
        page.evaluate("document.querySelectorAll('dialog[open]').forEach((dialog) => dialog.close())")
    box = page.locator("#punch-view").bounding_box()
    x, y = box["x"] + 0.3 * box["width"], box["y"] + 0.3 * box["height"]
    for dx, dy in ((0, 90), (0, -90), (90, 0), (-90, 0)):
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + dx, y + dy, steps=9)
        page.mouse.up()
    page.wait_for_function("!punch.fresh")
    waits = "() => [punch.waiting.length, punch.entered, punch.dragging, punch.following, punch.stale]"
    assert page.evaluate(waits) == [0, None, False, False, False]
    page.keyboard.press("r")
    page.wait_for_function("punch.playing && punch.drawn > punch.run.beginning")
    assert page.evaluate("document.querySelector('.hero').ariaBusy") == "false" and page.faults == []


def test_a_saved_run_names_its_scene_and_says_why_it_ended(opened):
    page = opened(replace(simulate(Scene(E=50.0, u_x_max=3.0)), failure="No equilibrium at U_x = 3.1 nm."))
    assert page.locator("#look").text_content() == "u_x_max = 3 nm, E = 50 GPa"
    assert page.locator("#notes").text_content() == "No equilibrium at U_x = 3.1 nm."


def test_a_notebook_shows_a_stage_in_a_frame_of_its_own(browser):
    page = browser.new_page()
    page.set_content(f"<p>above</p>{Stage(simulate(Scene(u_x_max=3.0)))._repr_html_()}")
    frame = page.frame_locator("iframe")
    frame.locator("#status b", has_text="saved").wait_for()
    page.frames[1].wait_for_function(DRAWN)
    page.close()


def test_a_result_without_frames_is_refused():
    with pytest.raises(ValueError, match="no frames"):
        Stage(Result(Scene(), ()))
