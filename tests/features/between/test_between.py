"""The unstable branches of a visitor's run, without a browser."""

from types import SimpleNamespace

import numpy as np
import pytest
from visitor import ended, messages, order

from app.features.between import tasks
from solver import Scene, skeleton_of, unstable_branch

SCENE = Scene(phi_ratio=0.03, u_x_max=8.0)


@pytest.fixture(scope="module")
def skeleton():
    return skeleton_of(SCENE)


def test_every_slip_has_its_branch_in_newtons_per_metre(skeleton):
    branches, why = tasks.branches(skeleton)
    assert len(branches) == len(skeleton.slips) and "next site" in why
    for slip, branch in zip(skeleton.slips, branches, strict=True):
        assert branch["U_x"][0] == pytest.approx(slip.load, rel=1e-5)
        assert branch["F"][0] == pytest.approx(slip.F_bar * SCENE.width * SCENE.E, rel=1e-4)
    last = unstable_branch(skeleton, len(branches) - 1)
    np.testing.assert_allclose(branches[-1]["A"], last.A_bar * SCENE.width, rtol=1e-5, atol=1e-9)


def test_a_smooth_run_says_that_it_has_no_slips():
    assert tasks.branches(skeleton_of(Scene(phi_ratio=0.01))) == ([], "This run has no slips.")


def test_branches_are_computed_only_while_they_are_shown_and_go_with_their_scene(session, skeleton):
    made = session.features["between"]
    made.ended(SimpleNamespace(scene=SCENE), skeleton)
    assert not made.waiting
    sent = messages(session)
    order(session, "unstable", shown=True)
    (call,) = made.waiting
    made._answered(call, call[0](*call[1:]))
    assert len(sent[-1]["list"]) == len(skeleton.slips)
    made.requested(Scene())
    assert sent[-1]["list"] == [] and not made.waiting
    made.ended(SimpleNamespace(scene=SCENE), skeleton)
    order(session, "unstable", shown=False)
    assert not made.waiting


def test_while_a_slider_is_held_one_branch_after_the_other_is_computed_and_then_that_of_the_run(session, skeleton):
    made, sent = session.features["between"], messages(session)
    order(session, "unstable", shown=True)
    others = [skeleton_of(SCENE.changed(E=E)) for E in (71.0, 72.0, 73.0)]
    session.pursuit.held = True
    later = []
    session.doc.add_timeout_callback = lambda call, ms: later.append(call)
    for other in others:  # the pictures of a drag, which come faster than branches
        made.requested(other.scene)
        made.predicted(other)
    (call,) = made.waiting
    assert call[1] is others[0]
    made._answered(call, call[0](*call[1:]))
    assert not sent[-1]["exact"] and len(sent[-1]["list"]) == len(others[0].slips)
    assert not made.waiting  # for a while predictions have the workers
    made.predicted(others[1])
    made.predicted(others[2])
    assert not made.waiting
    (go_on,) = later
    ended(go_on())
    (call,) = made.waiting
    assert call[1] is others[-1]
    made.ended(SimpleNamespace(scene=SCENE), skeleton)  # the exact run takes the place of what is left
    (call,) = made.waiting
    made._answered(call, call[0](*call[1:]))
    assert sent[-1]["exact"] and call[1] is skeleton and not made.waiting


def test_the_branch_of_a_prediction_takes_few_points():
    skeleton = skeleton_of(Scene(delta_bar=1.0))  # its branch has 156
    (branch, *_), _ = tasks.branches(skeleton, exact=False)
    assert len(branch["U_x"]) <= tasks.SOON + 1 < len(tasks.branches(skeleton)[0][0]["U_x"])


def test_a_preset_and_a_run_that_cannot_be_followed_leave_no_branch_of_a_prediction(session, skeleton):
    made, sent = session.features["between"], messages(session)
    order(session, "unstable", shown=True)
    for ends in (lambda: made.ended(SimpleNamespace(scene=SCENE), None), lambda: made.requested(Scene())):
        made.pauses = False
        made.predicted(skeleton)
        (call,) = made.waiting
        made._answered(call, call[0](*call[1:]))
        assert sent[-1]["list"] and not sent[-1]["exact"]
        ends()
        assert not made.waiting and sent[-1]["list"] == [] and sent[-1]["why"] == "" and sent[-1]["exact"]
