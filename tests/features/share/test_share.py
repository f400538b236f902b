"""Files, links and Python lines of a run, without a browser."""

import io
import json

import numpy as np
import pytest
from visitor import PARTING, Page, messages, say

from app.features.share import feature as share
from app.features.share import tasks
from app.features.share.feature import SCANNED, python_lines
from app.service import worker
from app.session import pursuit
from solver import Scene
from solver.presets import presets


def test_share_dialog_has_a_qr_code_unless_the_link_is_too_long(page):
    page.order("share", link="h" * (SCANNED + 1))
    assert page.messages.pop()["qr"] == "" and not page.session.features["share"].code.waiting
    page.order("share", link="h" * SCANNED)
    assert page.messages.pop()["qr"] == ""  # the Python lines come at once, the code once a worker has drawn it
    page.run_scheduled(lambda: page.messages)
    assert page.messages.pop()["qr"].startswith("data:image/svg+xml")


def test_exported_files_larger_than_the_limit_are_rejected(page, monkeypatch):
    for largest, why in ((share.LARGEST, ""), (10, share.LARGE)):
        monkeypatch.setattr(share, "LARGEST", largest)
        page.order("export", kind="json")
        page.run_scheduled(lambda: page.messages)
        file = page.messages.pop()
        assert file["kind"] == "file" and file["why"] == why and (len(file["body"]) > 1000) == (not why)


def test_the_file_of_a_run_that_pulls_off_reports_no_failure():
    """As `run --json` and `Result.failure`: all equilibria of the path were computed."""
    report = json.loads(tasks.file_of_run(PARTING, "json"))
    assert (report["outcome"], report["converged"], report["failure"]) == ("pulled off", True, None)


def test_two_files_asked_for_at_once_both_come(page):
    kinds = ["npz", "json"]
    for kind in kinds:
        page.order("export", kind=kind)
    page.run_scheduled(lambda: len(page.messages) > 1)
    assert sorted(file["ending"] for file in page.messages) == sorted(kinds)
    assert all(file["body"] and not file["why"] for file in page.messages)


@pytest.mark.parametrize("name", presets())
def test_python_code_of_a_preset_reproduces_its_scene(name):
    scene = presets()[name].scene
    call = python_lines(scene).split("\n")[1].removeprefix("frames = list(load_path(").removesuffix("))")
    assert eval(call, {"Scene": Scene}) == scene


def test_exports_use_the_newest_scene_while_it_waits(session):
    session.hello()
    session.jobs.pool.jobs[-1].slot = "a worker"
    session.change({"E": "90"})
    assert session.pursuit.requested and session.pursuit.scene == session.scene


def test_many_orders_for_files_leave_few_jobs_and_no_memory(session):
    session.hello()
    for k in range(2000):
        say(session, {"do": "export", "kind": ("npz", "json")[k % 2], "n": k})
    say(session, {"do": "export", "kind": "py", "n": 2000})  # is refused, and ends no other
    left = [job for job in session.jobs.pool.jobs if not job.cancelled()]
    assert len([job for job in left if job.call[0] is worker.compute]) == 1
    assert len([job for job in left if job.call[0] is tasks.file_of_run]) == 2
    assert len(session.jobs._shared) <= 1 and len(session.features["share"].waiting) == 2


def test_a_file_that_takes_too_long_is_refused_with_advice_by_a_worker_that_lives(session, monkeypatch):
    monkeypatch.setattr(tasks, "LONGEST_FILE", 0.0)
    sent = messages(session)
    say(session, {"do": "export", "kind": "json"})
    (job,) = session.jobs.pool.jobs
    session.jobs.pool.does(job)
    assert sent == [{"kind": "file", "ending": "json", "why": share.SLOW, "body": b""}]


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


def test_exported_files_and_python_lines_repeat_the_run_on_screen(page):
    made = {}
    exec(python_lines(page.session.pursuit.scene), made)
    shown = np.concatenate([head["force"] * curves["F_bar"] for _, head, curves, _ in page.chunks])
    assert len(page.chunks) > 1
    assert [frame.F for frame in made["frames"]] == pytest.approx(shown, rel=1e-5, abs=1e-6)
    with np.load(io.BytesIO(tasks.file_of_run(SHORT, "npz"))) as data:
        F = [frame.F for frame in made["frames"] if frame.stage != "approach"]
        assert data["F"] == pytest.approx(F, rel=1e-9, abs=1e-5)
    report = json.loads(tasks.file_of_run(SHORT, "json"))
    assert report["converged"] and report["scene"]["E"] == SHORT.E
