"""Restoring and exporting scenes without a browser: addresses, profiles, files, Python code."""

import sys

import numpy as np
import pytest
from visitor import Page

from app.service import tasks, worker
from app.session.controls import address_of, name_of, scene_from_address
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
