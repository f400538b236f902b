"""Other loadings and surfaces in the app, without a browser: runs that go on, loops, profiles that are uploaded."""

import io
import json
from itertools import islice

import numpy as np
import pytest
from visitor import PATIENCE, Page, order, send_file, slices

from app.service import packing, tasks
from app.session.controls import values_of
from app.session.share import python_lines
from solver import Scene, carried_path, load_path
from solver.analysis.energy_balance import work_of
from solver.presets import presets

SHORT = Scene(nodes=256, width=625.0, radius=10.0, u_x_max=6.0)


@pytest.fixture
def page(pool):
    visit = Page(pool, SHORT)
    visit.order("hello")
    visit.until("finished")
    yield visit
    visit.session.close()


def carried_frames(scene, count, changed):
    return list(islice(carried_path([(scene, count), (changed, None)]), count, None))


def change(page, after, **values):
    page.session.change({name: str(value) for name, value in values.items()}, after)
    page.session.publish()
    page.until("finished")


@pytest.mark.slow
def test_a_run_continues_from_the_increment_on_screen(page):
    frame = page.status()["frames"] - 20
    change(page, (1, frame), E=90)
    expected = carried_frames(SHORT, frame + 1, SHORT.changed(E=90.0))
    assert page.status()["after"] == [1, frame]
    assert page.curve("F_bar") == pytest.approx([f.F_bar for f in expected], rel=1e-6)
    assert page.status()["frames"] == frame + 1 + len(expected) == page.status()["total"]


@pytest.mark.slow
def test_a_run_that_went_on_can_go_on_again_from_before_and_after_that(page):
    first = page.status()["frames"] - 20
    change(page, (1, first), E=90)
    change(page, (2, first + 5), E=100)
    assert page.session.run.history == ((SHORT, first + 1), (SHORT.changed(E=90.0), 5))
    change(page, (3, first - 5), E=110)
    assert page.session.run.history == ((SHORT, first - 4),)


def test_what_is_taken_away_of_a_run_that_went_on_is_the_whole_of_it_in_newtons_per_metre(page):
    """Lines, NPZ and JSON once began anew with the last parameters; frames did not say what their E was."""
    frame = page.status()["frames"] - 20
    change(page, (1, frame), E=90)
    legs = page.session.pursuit.legs
    assert legs == ((SHORT, frame + 1), (SHORT.changed(E=90.0), None))
    made = {}
    exec(python_lines(legs), made)
    assert len(made["frames"]) == page.status()["frames"]
    shown = []  # (E, N/m) of every frame, as the browser holds them
    for _, head, curves, _ in page.chunks:
        assert head["force"] == head["scene"]["E"] * SHORT.width
        shown += [(head["scene"]["E"], head["force"] * F) for F in curves["F_bar"]]
    first = page.session.shelf.get(SHORT).frames
    shown = shown[: frame + 1] + shown[first:]
    assert [(f.scene.E, f.F) for f in made["frames"]] == [(E, pytest.approx(F, rel=1e-5, abs=1e-6)) for E, F in shown]
    with np.load(io.BytesIO(tasks.file_of_run(legs, "npz"))) as data:
        F = [f.F for f in made["frames"] if f.stage != "approach"]
        assert data["F_bar"] * data["E"] * SHORT.width == pytest.approx(F, rel=1e-9, abs=1e-9)
    report = json.loads(tasks.file_of_run(legs, "json"))
    assert report["converged"] and [part["E"] for part in report["changes"]] == [70.0, 90.0]


def test_a_run_that_went_on_is_not_taken_for_one_from_the_start(page):
    change(page, (1, page.status()["frames"] - 10), E=90)
    assert page.session.shelf.get(SHORT.changed(E=90.0)) is None


def test_another_surface_starts_anew_and_says_so(page):
    change(page, (1, page.status()["frames"] - 10), nodes=250)
    assert page.status()["after"] is None and "starts from the beginning" in page.status()["notes"][0]


def test_a_run_that_cannot_continue_shows_the_reason(page):
    page.session.change({"u_x_max": "2"}, (1, page.status()["frames"] - 1))
    page.session.publish()
    page.until("failed")
    assert "u_x_max" in page.status()["why"]


def test_the_work_of_a_loop_is_the_solver_s_however_it_is_sliced(page):
    scene = SHORT.changed(path="loop", u_x_max=4.0)
    frames = list(load_path(scene))
    expected = work_of(scene, frames).top
    works = []
    for piece in slices(scene, 0.005):
        for block in piece.blocks:
            works += list(packing.columns(block)[1]["work"])
    assert np.asarray(works) == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


WAVY = "\n".join(["x, z"] + [f"{x}, {3 * np.sin(2 * np.pi * x / 600):.6f}" for x in range(0, 601, 3)])


def upload(page, text):
    page.file("profile", text)
    while page.session.scene.surface != "measured" and "profile" not in page.status()["errors"]:
        page.calls.get(timeout=PATIENCE)()


def test_an_uploaded_profile_is_shown_with_what_was_done_to_it(page):
    upload(page, WAVY)
    page.until("finished")
    assert page.session.scene.width == 600.0 and page.session.scene.surface == "measured"
    assert any("201 points" in note for note in page.status()["notes"])
    assert values_of(page.session.scene)["surface"] == "measured"


def reading_of(session):
    """The task that reads the profile sent last."""
    return next(task for task in reversed(session.pool.tasks) if task.call[0] is tasks.measured)


def test_a_profile_keeps_the_sliders_moved_while_it_was_read_and_gives_way_to_a_preset_chosen_meanwhile(session):
    send_file(session, "profile", WAVY)
    order(session, "scene", E="200")
    reading_of(session).set_result(tasks.measured(WAVY))
    assert (session.scene.surface, session.scene.width, session.scene.E) == ("measured", 600.0, 200.0)
    send_file(session, "profile", WAVY.replace("0, ", "0,  ", 1))
    late = reading_of(session)
    order(session, "restore")
    assert late.cancelled() and session.scene == presets()["fig6"].scene


def test_a_profile_that_makes_the_run_too_long_is_refused(session):
    order(session, "scene", surface="flat", u_x_max="400", nodes="1024")
    send_file(session, "profile", WAVY)
    reading_of(session).set_result(tasks.measured(WAVY))
    assert session.scene.surface == "flat" and "increments" in session.errors["profile"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x, z\n1, two\n", "line 3"),
        (WAVY.replace("\n30, ", "\n3, ", 1), "line 12"),
        ("1\n2\n3\n", "line"),
        ("\n".join(f"{x}, {x % 2 * 5}" for x in range(40)), "line"),
        ("x" * 10_000_001, "MB"),
        ("", "points"),
    ],
    ids=["text", "descending", "one column", "steep", "10 MB", "empty"],
)
def test_a_bad_profile_is_refused_with_line_and_reason_and_the_run_stays(page, text, said):
    upload(page, text)
    assert said in page.status()["errors"]["profile"] and "stays" in page.status()["errors"]["profile"]
    assert page.session.run.number == 1 and page.status()["state"] == "finished"
    assert page.session.scene == SHORT
