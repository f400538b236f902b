"""Measured profiles, without a browser."""

import sys

import numpy as np
import pytest
from visitor import Page, messages, order, send_file

from app.features.profile import tasks
from app.features.profile.feature import name_of
from app.session import pursuit
from app.session.controls import address_of, scene_from_address, values_of
from solver import Profile, Scene
from solver.presets import presets

X = np.arange(128) / 128


WAVY = Profile(600.0, 3.0 * (1.0 - np.cos(2.0 * np.pi * X)))


ROUGH = Profile(2500.0, presets()["rough"].scene.profile)


MEASURED = Scene(surface="measured", measured=WAVY, width=600.0, nodes=256, u_x_max=2.0)


def asked(address):
    return {name: [text.encode()] for name, text in address.items()}


def test_a_measured_scene_is_restored_exactly_from_its_address():
    address = address_of(MEASURED, "fig6")
    assert scene_from_address(asked(address)) == (MEASURED, "fig6", [])


def test_an_unknown_profile_in_the_address_asks_for_the_file_again():
    assert len(name_of(ROUGH)) < 40
    _, _, notes = scene_from_address({"surface": [b"measured"], "profile": [b"0123456789ab"]})
    assert "Choose the file again" in notes[0]


def test_profiles_of_different_length_have_different_names():
    assert name_of(Profile(600.0, ROUGH.z)) != name_of(Profile(601.0, ROUGH.z))


def test_an_uploaded_text_is_never_taken_for_the_name_of_a_file(tmp_path):
    file = tmp_path / "p.csv"
    file.write_text("x,z\n" + "".join(f"{k},{0.1 * (k % 2)}\n" for k in range(41)))
    chosen = tasks.Chosen("nm", sure=True)
    assert tasks.measured(file.read_bytes(), chosen)[0] is not None
    found, why, _ = tasks.measured(str(file).encode(), chosen)
    assert found is None and why.startswith("line 1: ")


def test_a_file_that_fills_the_memory_is_refused_by_a_worker_that_lives(monkeypatch):
    if not sys.platform.startswith("linux"):
        pytest.skip("the memory of a process is bounded on Linux only")
    monkeypatch.setattr(tasks, "read_trace", lambda content, unit: np.empty(2 * tasks.MEMORY // 8))
    found, why, _ = tasks.measured(b"", tasks.Chosen())
    assert found is None and "takes too much memory" in why
    assert np.empty(2 * tasks.MEMORY // 8).size  # the bound is gone


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


def upload(page, text):
    page.file(text)
    page.run_scheduled(lambda: page.session.scene.surface == "measured" or "profile" in page.status()["errors"])


def test_an_uploaded_profile_is_used_and_its_processing_noted(page):
    upload(page, TEXT)
    page.until("finished")
    assert page.session.scene.width == 600.0 and page.session.scene.surface == "measured"
    assert any("201 points" in note for note in page.status()["notes"])
    assert values_of(page.session.scene)["surface"] == "measured"


def reading_of(session):
    """The task that reads the profile sent last."""
    return next(task for task in reversed(session.jobs.pool.tasks) if task.call[0] is tasks.measured)


def test_sliders_moved_while_a_profile_is_read_are_kept_and_a_preset_replaces_it(session):
    send_file(session, TEXT)
    order(session, "scene", E="200")
    reading_of(session).set_result(tasks.measured(TEXT.encode(), tasks.Chosen()))
    assert (session.scene.surface, session.scene.width, session.scene.E) == ("measured", 600.0, 200.0)
    send_file(session, TEXT.replace("0, ", "0,  ", 1))
    late = reading_of(session)
    order(session, "restore")
    assert late.cancelled() and session.scene == presets()["fig6"].scene


TEXT = "\n".join(["x (nm), z (nm)"] + [f"{x}, {3 * np.sin(2 * np.pi * x / 600):.6f}" for x in range(0, 601, 3)])

LONG = "\n".join(["x (nm), z (nm)"] + [f"{x}, {3 * np.sin(2 * np.pi * x / 500):.6f}" for x in range(0, 40_001, 10)])


ASKED = {  # {what: (the file, what is then chosen)}
    "no unit": (TEXT.replace(" (nm)", ""), {"unit": "nm"}),
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
    send_file(session, TEXT)
    reading_of(session).set_result(tasks.measured(TEXT.encode(), tasks.Chosen()))
    assert session.scene.surface == "flat" and "increments" in session.errors["profile"]


def test_an_invalid_profile_is_rejected_with_line_and_reason(page):
    upload(page, "x (nm), z (nm)\n1, 2\n2, two\n")
    assert "line 3" in page.status()["errors"]["profile"] and "stays" in page.status()["errors"]["profile"]
    assert page.session.run.number == 1 and page.status()["state"] == "finished"
    assert page.session.scene == SHORT
