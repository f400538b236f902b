"""Exports, loops and uploaded profiles in the app, without a browser."""

import blocks
import numpy as np
import pytest
from visitor import Page, messages, order, send_file, slices

from app.service import tasks
from app.session import pursuit
from app.session.controls import values_of
from solver import Scene, load_path
from solver.analysis.work import work_of
from solver.presets import presets

SHORT = Scene(nodes=256, width=625.0, radius=10.0, u_x_max=6.0)


@pytest.fixture
def page(pool, monkeypatch):
    """A visitor whose run came in parts, however fast the solver."""
    monkeypatch.setattr(pursuit, "FIRST", 0.002)
    visit = Page(pool, SHORT)
    visit.order("hello")
    visit.until("finished")
    yield visit
    visit.session.close()


def test_work_of_a_loop_does_not_depend_on_slicing(page):
    scene = SHORT.changed(path="loop", u_x_max=4.0)
    frames = list(load_path(scene))
    expected = work_of(frames)
    works = []
    for piece in slices(scene, 0.005):
        for block in piece.blocks:
            works += list(blocks.columns(block)[1]["work"])
    assert np.asarray(works) == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


WAVY = "\n".join(["x (nm), z (nm)"] + [f"{x}, {3 * np.sin(2 * np.pi * x / 600):.6f}" for x in range(0, 601, 3)])


def upload(page, text):
    page.file(text)
    page.run_scheduled(lambda: page.session.scene.surface == "measured" or "profile" in page.status()["errors"])


def test_an_uploaded_profile_is_used_and_its_processing_noted(page):
    upload(page, WAVY)
    page.until("finished")
    assert page.session.scene.width == 600.0 and page.session.scene.surface == "measured"
    assert any("201 points" in note for note in page.status()["notes"])
    assert values_of(page.session.scene)["surface"] == "measured"


def reading_of(session):
    """The task that reads the profile sent last."""
    return next(task for task in reversed(session.jobs.pool.tasks) if task.call[0] is tasks.measured)


def test_sliders_moved_while_a_profile_is_read_are_kept_and_a_preset_replaces_it(session):
    send_file(session, WAVY)
    order(session, "scene", E="200")
    reading_of(session).set_result(tasks.measured(WAVY.encode(), tasks.Chosen()))
    assert (session.scene.surface, session.scene.width, session.scene.E) == ("measured", 600.0, 200.0)
    send_file(session, WAVY.replace("0, ", "0,  ", 1))
    late = reading_of(session)
    order(session, "restore")
    assert late.cancelled() and session.scene == presets()["fig6"].scene


LONG = "\n".join(["x (nm), z (nm)"] + [f"{x}, {3 * np.sin(2 * np.pi * x / 500):.6f}" for x in range(0, 40_001, 10)])


ASKED = {  # {what: (the file, what is then chosen)}
    "no unit": (WAVY.replace(" (nm)", ""), {"unit": "nm"}),
    "a long trace": (LONG, {"begin": 1e4, "end": 1.2e4}),
    "steep places": ("x (nm), z (nm)\n" + "\n".join(f"{x}, {x % 2 * 5}" for x in range(400)), {"cut_off": 50.0}),
}


@pytest.mark.parametrize("what", ASKED)
def test_a_visitor_is_asked_about_a_profile_and_what_he_chooses_is_used(session, what):
    text, chosen = ASKED[what]
    sent = messages(session)
    send_file(session, text)
    task = reading_of(session)
    task.set_result(task.call[0](*task.call[1:]))
    (asked,) = [message for message in sent if message["kind"] == "trace"]
    assert session.scene.surface == "circular" and not session.errors
    trace = asked["trace"]
    assert trace["named"] == (what != "no unit") and len(trace["x"]) == len(trace["z"]) <= 401
    assert bool(asked["why"]) == (what == "steep places")
    if what == "steep places":
        assert trace["cut_off"] <= 50.0
    send_file(session, text, sure=True, **chosen)
    task = reading_of(session)
    task.set_result(task.call[0](*task.call[1:]))
    assert session.scene.surface == "measured"
    assert session.scene.width == {"a long trace": 2000.0, "no unit": 600.0}.get(what, session.scene.width)


def test_a_profile_that_makes_the_run_too_long_is_rejected(session):
    order(session, "scene", surface="flat", u_x_max="400", nodes="1024")
    send_file(session, WAVY)
    reading_of(session).set_result(tasks.measured(WAVY.encode(), tasks.Chosen()))
    assert session.scene.surface == "flat" and "increments" in session.errors["profile"]


def test_an_invalid_profile_is_rejected_with_line_and_reason(page):
    upload(page, "x (nm), z (nm)\n1, 2\n2, two\n")
    assert "line 3" in page.status()["errors"]["profile"] and "stays" in page.status()["errors"]["profile"]
    assert page.session.run.number == 1 and page.status()["state"] == "finished"
    assert page.session.scene == SHORT
