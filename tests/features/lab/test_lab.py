"""What research pages share: the menu, tasks in slices, and a view of a scene alone."""

from functools import partial
from math import inf

from visitor import PARTING, in_slices

from app.features.lab import tasks
from app.features.lab.feature import listed
from app.service import worker
from solver import Scene, load_path
from solver.analysis.friction_laws import friction_force

FLAT = Scene(surface="flat", phi_ratio=0.1, u_x_max=40.0, du_x=0.5, damping=inf)


def test_each_page_has_a_title_and_a_place_of_its_own_in_the_menu():
    assert len({page.ORDER for page in listed().values()}) == len({page.TITLE for page in listed().values()})


def test_sliced_frames_of_a_flat_equal_those_of_a_whole_run(monkeypatch):
    monkeypatch.setattr(tasks, "SLICE", 0.0)  # one increment each
    whole = list(load_path(FLAT))
    frames, count = in_slices(tasks.flat_frames, FLAT)
    assert count == len(whole) - 1
    assert [(frame.U_x, frame.F_bar) for frame in frames] == [(frame.U_x, frame.F_bar) for frame in whole]
    assert friction_force(FLAT, frames) == friction_force(FLAT, whole)


def test_a_run_that_pulls_off_has_frames_up_to_there():
    frames, _ = in_slices(tasks.flat_frames, PARTING)
    assert frames[-1].stage == "shear" and frames[-1].U_x < PARTING.u_x_max


def test_a_run_that_runs_out_of_time_reports_where(monkeypatch):
    monkeypatch.setattr(tasks, "SLICE", 0.0)
    monkeypatch.setattr(worker, "SLOW", 0.0)
    failed = in_slices(partial(tasks.tried, tasks.flat_frames), FLAT)[0]
    assert failed.kind == "hang" and "no equilibrium within 0 s" in str(failed)  # which is not cached: see Jobs
