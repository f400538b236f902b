"""Continued runs, loops and uploaded profiles in the app, without a browser."""

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
    assert page.status()["after"] == (1, frame)
    assert page.curve("F_bar") == pytest.approx([f.F_bar for f in expected], rel=1e-6)
    assert page.status()["frames"] == frame + 1 + len(expected) == page.status()["total"]


@pytest.mark.slow
def test_a_continued_run_can_continue_from_earlier_and_later_increments(page):
    first = page.status()["frames"] - 20
    change(page, (1, first), E=90)
    change(page, (2, first + 5), E=100)
    assert page.session.run.history == ((SHORT, first + 1), (SHORT.changed(E=90.0), 5))
    change(page, (3, first - 5), E=110)
    assert page.session.run.history == ((SHORT, first - 4),)


def test_exports_of_a_continued_run_contain_every_part_with_its_own_stiffness(page):
    """Exports once contained only the last parameters, and frames did not state their E."""
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
    first = page.session.run_cache.get(SHORT).frames
    shown = shown[: frame + 1] + shown[first:]
    assert [(f.scene.E, f.F) for f in made["frames"]] == [(E, pytest.approx(F, rel=1e-5, abs=1e-6)) for E, F in shown]
    with np.load(io.BytesIO(tasks.file_of_run(legs, "npz"))) as data:
        F = [f.F for f in made["frames"] if f.stage != "approach"]
        assert data["F_bar"] * data["E"] * SHORT.width == pytest.approx(F, rel=1e-9, abs=1e-9)
    report = json.loads(tasks.file_of_run(legs, "json"))
    assert report["converged"] and [part["E"] for part in report["changes"]] == [70.0, 90.0]


def test_a_continued_run_is_not_stored_as_a_run_from_the_start(page):
    change(page, (1, page.status()["frames"] - 10), E=90)
    assert page.session.run_cache.get(SHORT.changed(E=90.0)) is None


def test_a_change_of_the_grid_restarts_the_run_with_a_note(page):
    change(page, (1, page.status()["frames"] - 10), nodes=250)
    assert page.status()["after"] is None and "starts from the beginning" in page.status()["notes"][0]


def test_a_run_that_cannot_continue_shows_a_reason(page):
    page.session.change({"u_x_max": "2"}, (1, page.status()["frames"] - 1))
    page.session.publish()
    page.until("failed")
    assert "u_x_max" in page.status()["why"]


def test_work_of_a_loop_does_not_depend_on_slicing(page):
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


def test_an_uploaded_profile_is_used_and_its_processing_noted(page):
    upload(page, WAVY)
    page.until("finished")
    assert page.session.scene.width == 600.0 and page.session.scene.surface == "measured"
    assert any("201 points" in note for note in page.status()["notes"])
    assert values_of(page.session.scene)["surface"] == "measured"


def reading_of(session):
    """The task that reads the profile sent last."""
    return next(task for task in reversed(session.pool.tasks) if task.call[0] is tasks.measured)


def test_sliders_moved_while_a_profile_is_read_are_kept_and_a_preset_replaces_it(session):
    send_file(session, "profile", WAVY)
    order(session, "scene", E="200")
    reading_of(session).set_result(tasks.measured(WAVY))
    assert (session.scene.surface, session.scene.width, session.scene.E) == ("measured", 600.0, 200.0)
    send_file(session, "profile", WAVY.replace("0, ", "0,  ", 1))
    late = reading_of(session)
    order(session, "restore")
    assert late.cancelled() and session.scene == presets()["fig6"].scene


def test_a_profile_that_makes_the_run_too_long_is_rejected(session):
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
def test_an_invalid_profile_is_rejected_with_line_and_reason(page, text, said):
    upload(page, text)
    assert said in page.status()["errors"]["profile"] and "stays" in page.status()["errors"]["profile"]
    assert page.session.run.number == 1 and page.status()["state"] == "finished"
    assert page.session.scene == SHORT
