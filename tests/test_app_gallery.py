"""The pictures of the presets: what a worker draws, against runs of its own, and what is asked of workers."""

import json

import pytest
from visitor import order

from app.service import tasks
from app.service.pool import LATER
from app.service.requests import LIVES
from solver import NotConverged, load_path
from solver.continuation.state import OutOfTime
from solver.presets import presets


def drawn(scene):
    """The rows (load, force, area) of a picture."""
    kept = None
    while isinstance(result := tasks.thumbnail(scene, kept), tasks.Part):
        kept = result.kept
    return list(zip(result["along"], result["force"], result["area"], strict=True))


def test_the_picture_of_a_preset_has_its_increments_and_the_ends_of_its_branches():
    scene = presets()["fig7-case2"].scene.changed(u_x_max=14.0, du_x=0.5)
    shear = [frame for frame in load_path(scene) if frame.stage == "shear"]
    slips = [slip for frame in shear for slip in frame.slips]
    expected = [(f.U_x, f.F_bar, f.A_bar) for f in shear] + [(s.load, s.F_bar, s.A_bar) for s in slips]
    assert slips and sorted(drawn(scene)) == [pytest.approx(row, rel=5e-3, abs=1e-9) for row in sorted(expected)]


@pytest.mark.slow
def test_where_nothing_slides_the_picture_is_the_load_over_the_indentation():
    scene = presets()["unload"].scene.changed(du_z=0.5, tolerance=1e-6)
    unload = [frame for frame in load_path(scene) if frame.stage == "unload"]
    rows = drawn(scene)
    for frame in unload:
        assert pytest.approx((frame.delta, frame.L_bar, frame.A_bar), rel=5e-3, abs=1e-9) in rows


def test_the_gallery_asks_for_every_preset_once_and_sends_nothing_of_one_that_fails(session):
    sent = []
    session.wire.on_change("thumbnail", lambda attribute, old, new: sent.append(json.loads(new)))
    order(session, "gallery")
    order(session, "gallery")
    asked = session.pool.tasks
    assert len(asked) == len(presets()) and {task.rank for task in asked} == {LATER}
    asked[0].set_result({"along": [0.0, 1.0], "force": [0.0, 1.0], "area": [1.0, 1.0]})
    asked[1].set_result(NotConverged("it fluttered"))
    assert [news["preset"] for news in sent] == list(presets())[:2]
    assert sent[0]["drawn"]["force"] == [0.0, 1.0] and sent[1]["drawn"] is None
    session.close()
    assert all(task.done() for task in asked)


def test_a_picture_that_a_busy_machine_never_finishes_is_given_up(session):
    sent = []
    session.wire.on_change("thumbnail", lambda attribute, old, new: sent.append(json.loads(new)))
    order(session, "gallery")
    first = session.pool.tasks[0]
    for again in range(LIVES):
        asked = [task for task in session.pool.tasks if task.call == first.call]
        assert len(asked) == again + 1 and not sent
        asked[-1].set_result(OutOfTime("0.5 s"))
    assert [(news["preset"], news["drawn"]) for news in sent] == [(next(iter(presets())), None)]
    assert len([task for task in session.pool.tasks if task.call == first.call]) == LIVES
