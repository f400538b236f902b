"""Restoring and exporting scenes without a browser: addresses, profiles, files, Python code."""

import sys

import numpy as np
import pytest
from visitor import Page, messages, say

from app.service import tasks, worker
from app.session import share
from app.session.controls import address_of, name_of, scene_from_address
from app.session.share import SCANNED, python_lines
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


@pytest.mark.slow
def test_restoring_a_scene_reuses_a_known_run_and_resets_the_preset(page):
    page.order("hello")
    page.until("finished")
    page.order("restore", preset="fig7-case2")
    page.order("restore", delta_bar="0", u_x_max="6")
    page.until("finished")
    assert page.session.preset == "fig6" and page.status()["known"]
    assert page.status()["address"] == {"u_x_max": "6"}


def test_share_dialog_has_a_qr_code_unless_the_link_is_too_long(page):
    page.order("share", link="h" * (SCANNED + 1))
    assert page.messages.pop()["qr"] == "" and not page.session.sharing.code.waiting
    page.order("share", link="h" * SCANNED)
    assert page.messages.pop()["qr"] == ""  # the Python lines come at once, the code once a worker has drawn it
    page.run_next()
    assert page.messages.pop()["qr"].startswith("data:image/svg+xml")


def test_exported_files_larger_than_the_limit_are_rejected(page, monkeypatch):
    for largest, why in ((share.LARGEST, ""), (10, share.LARGE)):
        monkeypatch.setattr(share, "LARGEST", largest)
        page.order("export", kind="json")
        page.run_scheduled(lambda: page.messages)
        file = page.messages.pop()
        assert file["kind"] == "file" and file["why"] == why and (len(file["body"]) > 1000) == (not why)


def test_two_files_asked_for_at_once_both_come(page):
    kinds = ["npz", "json"]
    for kind in kinds:
        page.order("export", kind=kind)
    page.run_scheduled(lambda: len(page.messages) > 1)
    assert sorted(file["ending"] for file in page.messages) == sorted(kinds)
    assert all(file["body"] and not file["why"] for file in page.messages)


@pytest.mark.slow
def test_a_finished_run_is_stored_with_its_cautions_for_all_visitors_and_dropped_by_its_own(page, pool):
    page.session.scene = Scene(nodes=4096, u_x_max=1.0, E=1000.0)
    page.order("hello")
    assert page.status()["cautions"] == []
    page.until("finished")
    assert "smoothed away" in page.status()["cautions"][0]
    made, results = page.session.run.packed, page.session.jobs.results
    assert (made.blocks, made.skeleton) == ((), None) and (worker.compute, page.session.scene) in results
    other = Page(pool, page.session.scene, jobs=page.session.jobs)
    other.order("hello")
    assert other.status()["state"] == "finished" and other.session.pursuit.job is None
    assert other.status()["cautions"] == page.status()["cautions"]
    assert other.session.run.packed.widest == made.widest > 0.0
    np.testing.assert_array_equal(other.curve("F_bar"), page.curve("F_bar"))
    other.session.close()


@pytest.mark.parametrize("name", presets())
def test_python_code_of_a_preset_reproduces_its_scene(name):
    scene = presets()[name].scene
    call = python_lines(scene).split("\n")[1].removeprefix("frames = list(load_path(").removesuffix("))")
    assert eval(call, {"Scene": Scene}) == scene


def test_exports_use_the_newest_scene_while_it_waits(session):
    session.hello()
    session.jobs.pool.tasks[-1].set_running_or_notify_cancel()
    session.change({"E": "90"})
    assert session.pursuit.requested and session.pursuit.scene == session.scene


def test_many_orders_for_files_leave_few_tasks_and_no_memory(session):
    session.hello()
    for k in range(2000):
        say(session, {"do": "export", "kind": ("npz", "json")[k % 2], "n": k})
    say(session, {"do": "export", "kind": "py", "n": 2000})  # is refused, and ends no other
    left = [task for task in session.jobs.pool.tasks if not task.cancelled()]
    assert len([task for task in left if task.call[0] is worker.compute]) == 1
    assert len([task for task in left if task.call[0] is tasks.file_of_run]) == 2
    assert len(session.jobs._shared) <= 1 and len(session.sharing.waiting) == 2


def test_a_file_that_takes_too_long_is_refused_with_advice_by_a_worker_that_lives(session, monkeypatch):
    monkeypatch.setattr(tasks, "LONGEST_FILE", 0.0)
    sent = messages(session)
    say(session, {"do": "export", "kind": "json"})
    (task,) = session.jobs.pool.tasks
    task.set_result(task.call[0](*task.call[1:]))
    assert sent == [{"kind": "file", "ending": "json", "why": share.SLOW, "body": b""}]


def test_an_uploaded_text_is_never_taken_for_the_name_of_a_file(tmp_path):
    file = tmp_path / "p.csv"
    file.write_text("U_x,F\n" + "".join(f"{k},{0.1 * (k % 2)}\n" for k in range(41)))
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
