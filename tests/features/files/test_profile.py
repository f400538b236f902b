"""Measured profiles, without a browser."""

import sys

import numpy as np
import pytest
from visitor import Page, messages, order, send_file

from app.features.files import tasks
from app.features.files.feature import name_of
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


NM = {"x": "nm", "z": "nm"}


def test_an_uploaded_text_is_never_taken_for_the_name_of_a_file(tmp_path):
    file = tmp_path / "p.csv"
    file.write_text("x,z\n" + "".join(f"{k},{0.1 * (k % 2)}\n" for k in range(41)))
    assert tasks.look(SHORT, file.read_bytes(), tasks.Chosen(units=NM))[1] is not None
    seen, found = tasks.look(SHORT, str(file).encode(), tasks.Chosen(units=NM))
    assert found is None and seen["why"].startswith("line 1: ")


def test_a_file_that_fills_the_memory_is_refused_by_a_worker_that_lives(monkeypatch):
    if not sys.platform.startswith("linux"):
        pytest.skip("the memory of a process is bounded on Linux only")
    monkeypatch.setattr(tasks, "read_block", lambda *how: np.empty(2 * tasks.MEMORY // 8))
    seen, found = tasks.look(SHORT, b"1,2", tasks.Chosen())
    assert found is None and "takes too much memory" in seen["why"]
    assert np.empty(2 * tasks.MEMORY // 8).size  # the bound is gone


def test_of_three_columns_the_coordinate_y_is_not_proposed_as_height():
    rows = "\n".join(f"{k},{0.1 * np.sin(k / 9)},{k % 7}" for k in range(60))
    seen, found = tasks.look(SHORT, f"X (um),Y (um),Intensity (V)\n{rows}".encode(), tasks.Chosen(kind="surface"))
    assert found is None and seen["columns"] == {"x": 0} and "column of z" in seen["why"]


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


def seen_in(messages):
    """What the server says of a file, the last time."""
    return [message["file"] for message in messages if message["kind"] == "seen" and "file" in message][-1]


def upload(page, text, **chosen):
    page.messages.clear()
    page.file(text, **chosen)
    page.run_scheduled(lambda: any("file" in message for message in page.messages))
    return seen_in(page.messages)


def test_an_uploaded_profile_is_used_and_its_processing_noted(page):
    before = page.session.run.number
    upload(page, TEXT)
    page.until("finished")
    assert page.session.run.number == before + 1  # requested once
    assert page.session.scene.width == 600.0 and page.session.scene.surface == "measured"
    assert any("201 points" in note for note in page.status()["notes"])
    assert values_of(page.session.scene)["surface"] == "measured"


def reading_of(session):
    """The job that reads the profile sent last."""
    return next(job for job in reversed(session.jobs.pool.jobs) if job.call[0] is tasks.look)


def answer(session):
    """Let a worker read the file sent last, and the visitor receive what is in it."""
    session.jobs.pool.does(reading_of(session))


def test_sliders_moved_while_a_profile_is_read_are_kept_and_a_preset_replaces_it(session):
    send_file(session, TEXT)
    order(session, "scene", E="200")
    answer(session)
    assert (session.scene.surface, session.scene.width, session.scene.E) == ("measured", 600.0, 200.0)
    send_file(session, TEXT.replace("0, ", "0,  ", 1))
    late = reading_of(session)
    order(session, "restore")
    assert late.cancelled() and session.scene == presets()["fig6"].scene


def waves(heading, size, period, apart, rough=0.0):
    rows = [f"{x}, {3 * np.sin(2 * np.pi * x / period) + rough * (x % 2):.6f}" for x in range(0, size + 1, apart)]
    return "\n".join([heading, *rows])


TEXT, LONG = waves("x (nm), z (nm)", 600, 600, 3), waves("x (nm), z (nm)", 40_000, 500, 10)
ASKED = {  # {what: (the file, what is then chosen, the length that is used)}
    "no unit": (TEXT.replace(" (nm)", ""), {"units": NM}, 600.0),
    "no names": (TEXT.replace("x (nm), z (nm)\n", ""), {"kind": "surface", "units": NM}, 600.0),
    "other names": (
        TEXT.replace("x (nm)", "a").replace("z (nm)", "b"),
        {"columns": {"x": 0, "z": 1}, "units": NM},
        600.0,
    ),
    "no x": (
        "\n".join(f"{3 * np.sin(k / 20):.4f}" for k in range(201)),
        {"kind": "surface", "columns": {"z": 0}, "units": {"z": "nm"}, "spacing": "3 nm"},
        600.0,
    ),
    "steep places": (waves("x (nm), z (nm)", 400, 400, 1, rough=5.0), {"cut_off": 50.0}, 400.0),
}


@pytest.mark.parametrize("what", ASKED)
def test_a_visitor_is_asked_about_a_profile_and_what_he_chooses_is_used(session, what):
    text, chosen, length = ASKED[what]
    sent = messages(session)
    send_file(session, text)
    answer(session)
    asked = seen_in(sent)
    assert session.scene.surface == "circular" and not session.errors
    assert asked["why"] and not asked["says"] and "used" not in asked
    if what != "no x":
        assert len(asked["drawn"]["x"]) == len(asked["drawn"]["y"]) <= tasks.DRAWN + 1
    assert asked["table"]["first"][0][0].startswith("0")
    assert (asked["cut_off"] is not None) == (what == "steep places")
    send_file(session, text, **chosen)
    answer(session)
    assert seen_in(sent)["used"] == "surface" and f"{length:g} nm" in seen_in(sent)["says"]
    assert (session.scene.surface, session.scene.width) == ("measured", length)


def test_of_a_long_profile_the_middle_is_proposed_and_another_part_can_be_chosen(session):
    sent = messages(session)
    order(session, "piece", at=0, of=len(LONG), content=LONG.encode())
    order(session, "choice", turn=1)
    answer(session)
    assert seen_in(sent)["part"] == (0.475, 0.525) and "2,000 nm of 40,000 nm long" in seen_in(sent)["says"]
    order(session, "choice", turn=2, use=True, part=[0.25, 0.275])
    answer(session)
    assert session.scene.width == 1000.0


def test_a_profile_that_makes_the_run_too_long_is_rejected_in_the_dialog(session):
    order(session, "scene", surface="flat", u_x_max="400", nodes="1024")
    sent = messages(session)
    send_file(session, TEXT)
    answer(session)
    assert session.scene.surface == "flat" and "increments" in seen_in(sent)["why"]
    assert "used" not in seen_in(sent)


def test_an_invalid_profile_is_rejected_with_line_and_reason_and_the_run_stays(page):
    seen = upload(page, "x (nm), z (nm)\n1, 2\n2, two\n")
    assert "line 3" in seen["why"] and not seen["says"]
    assert page.session.run.number == 1 and page.status()["state"] == "finished"
    assert page.session.scene == SHORT


def test_a_file_in_pieces_is_one_file_and_a_piece_at_a_wrong_place_is_not_taken(session):
    sent, content = messages(session), TEXT.encode()
    order(session, "piece", at=0, of=len(content), content=content[:1000])
    order(session, "piece", at=500, of=len(content), content=content[500:])
    order(session, "piece", at=1000, of=len(content), content=content[1000:])
    assert [message["got"] for message in sent if "got" in message] == [1000, len(content)]
    order(session, "choice", turn=1, use=True)
    answer(session)
    assert session.scene.surface == "measured"


def test_a_file_beyond_20_mb_is_not_taken(session):
    sent = messages(session)
    order(session, "piece", at=0, of=20_000_001, content=b"1,2\n")
    assert not [message for message in sent if "got" in message]
