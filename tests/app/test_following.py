"""Predictions during a drag: they match the exact run, skip intermediate positions and end in the exact run."""

import json
import zlib
from dataclasses import replace

import numpy as np
import pytest
from visitor import NoPool, Page, messages, say, slices, unpacked, whole_run

from app.service import metrics, packing, skeletons, worker
from app.service.caller import Lost
from app.service.job import EXACT, SCREEN
from app.service.jobs import Jobs
from app.session import pursuit
from solver import NotFollowed, Scene, follow

SCENE = Scene(u_x_max=16.0)  # slips three times
NEXT = SCENE.changed(delta_bar=0.02)
MOST = 18_500  # bytes of a prediction


@pytest.fixture(scope="module")
def runs():
    """{scene: Frames} of two neighbours."""
    return {scene: whole_run(scene) for scene in (SCENE, NEXT)}


def sheared(run):
    """{column: (n,)} and {field: (n, m)} in nm and GPa of the increments of a run that slide."""
    blocks = [unpacked(block) for block in run.blocks]
    columns = {name: np.concatenate([each[name] for _, each, _ in blocks]) for name in blocks[0][1]}
    slides = columns["stage"] == packing.ORDER.index("shear")
    return {name: values[slides] for name, values in columns.items()}, blocks[-1]


def test_a_prediction_is_small_and_has_the_slips_of_the_exact_run(runs):
    made = skeletons.followed(runs[SCENE].skeleton, NEXT)
    assert len(made.body) < MOST
    head = head_of(made.body)
    exact, _ = sheared(runs[NEXT])
    slips = exact["slip"] > 0
    assert head["scene"]["delta_bar"] == 0.02 and slips.sum() == 3
    loads, *_, areas = np.transpose(head["shear"]["slips"])
    np.testing.assert_allclose(loads, exact["slip_at"][slips], atol=1e-4)
    np.testing.assert_allclose(areas, exact["slip_A"][slips], atol=1e-3 * exact["slip_A"].max())


def head_of(body):
    """The head of a packed skeleton."""
    text = zlib.decompress(body)
    return json.loads(text[4 : 4 + int.from_bytes(text[:4], "little")])


def test_states_farther_apart_than_two_bytes_hold_are_rounded_more_coarsely(runs):
    """A state moved by 10 nm takes 100,000 units of 1e-4 nm."""
    skeleton = runs[SCENE].skeleton
    first, *others = skeleton.branches
    states = [state._replace(v=state.v + 10.0 * (k == 1)) for k, state in enumerate(first.states)]
    branches = replace(first, states=tuple(states)), *others
    moved = replace(skeleton, trace=replace(skeleton.trace, branches=branches))
    assert head_of(skeletons.packed(skeleton))["shear"]["unit"] == skeletons.UNIT
    far = tuple(state._replace(v=state.v + 100.0 * (k == 1)) for k, state in enumerate(first.states))
    with pytest.raises(NotFollowed, match="too far"):
        skeletons.packed(
            replace(skeleton, trace=replace(skeleton.trace, branches=(replace(first, states=far), *others)))
        )
    assert head_of(skeletons.packed(moved))["shear"]["unit"] == 4 * skeletons.UNIT


def test_skeleton_of_a_sliced_run_equals_that_of_a_whole_run(runs):
    parts = list(slices(SCENE, 0.02))
    assert len(parts) > 1
    sliced, whole = parts[-1].skeleton, runs[SCENE].skeleton
    # states of a skeleton are solved to 1e-5 nm, which makes forces right to 1e-4
    np.testing.assert_allclose(sliced.curve([0.0, 5.0, 12.0]), whole.curve([0.0, 5.0, 12.0]), rtol=1e-4, atol=1e-7)


def test_a_prediction_that_is_impossible_gives_a_reason(runs):
    assert (
        skeletons.followed(runs[SCENE].skeleton, SCENE.changed(surface="wave"))
        == "surface does not change continuously"
    )


# the session: who asks for what, and when


class Answered(NoPool):
    """A pool whose calls return when the test says so."""

    def waiting(self, call):
        """Jobs that make this call and still wait."""
        return [job for job in dict.fromkeys(self.jobs) if job.call[0] is call and not job.done()]

    def returns(self, page, call, made):
        """The oldest waiting one returns."""
        self.answer(self.waiting(call)[0], made)
        page.run_all()


@pytest.fixture
def page(runs):
    """A visitor who looks at the finished run of SCENE."""
    jobs = Jobs(Answered())
    call = worker.compute, SCENE
    jobs.results.put(call, (call, runs[SCENE]))
    visit = Page(None, SCENE, jobs=jobs)
    visit.order("hello")
    visit.pool = jobs.pool
    yield visit
    visit.session.close()


def move(page, value):
    """Drag the slider to this value."""
    order = {"do": "scene", "values": {"delta_bar": value}, "held": True, "n": 100 * value}
    say(page.session, order)


def test_only_the_newest_slider_position_is_predicted_next(page):
    for value in (0.01, 0.02, 0.03, 0.04):
        move(page, value)
    assert page.status()["acknowledged"] not in (1.0, 2.0, 3.0, 4.0)  # the predictions acknowledge these orders
    assert [job.call[2].delta_bar for job in page.pool.waiting(skeletons.followed)] == [0.01]
    page.pool.returns(page, skeletons.followed, skeletons.Followed(b"!", b"skeleton"))
    assert page.messages == [{"kind": "skeleton", "acknowledged": 1.0, "body": b"!"}]
    (job,) = page.pool.waiting(skeletons.followed)
    assert job.call[1:] == (b"skeleton", SCENE.changed(delta_bar=0.04)) and job.rank == SCREEN
    assert not page.pool.waiting(worker.compute)  # no run


def test_a_drag_whose_prediction_waits_in_the_queue_is_acknowledged_within_a_second(page):
    """The page gave the connection up after 12 s, and loaded itself again."""
    move(page, 0.01)
    assert page.status()["acknowledged"] != 1.0
    page.session.look()  # a timer of the server, every second
    page.run_next()
    assert page.status()["acknowledged"] == 1.0
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, skeletons.Followed(b"!", b"skeleton"))
    assert [job.call[2].delta_bar for job in page.pool.waiting(skeletons.followed)] == [0.02]


def test_only_what_has_changed_is_sent_again(page):
    sent = messages(page.session)
    say(page.session, {"do": "scene", "values": {"E": "a lot"}, "n": 5})
    (status,) = sent
    assert status.keys() == {"kind", "acknowledged", "errors"}


def test_a_part_of_a_run_carries_its_run_state_and_count(page):
    sent = messages(page.session)
    page.order("scene", phi_ratio=0.5)
    (job,) = page.pool.waiting(worker.compute)
    part = worker.compute(job.call[1], None, 0.02)
    page.pool.returns(page, worker.compute, part)
    page.pool.returns(page, worker.compute, worker.compute(job.call[1], part.state, np.inf, np.inf))
    runs = [message for message in sent if message["kind"] == "run"]
    assert [(m["run"], m["state"]) for m in (runs[0], runs[-1])] == [(2, "running"), (2, "finished")]
    assert (runs[0]["frames"], runs[-1]["frames"]) == (part.made.frames, page.status()["frames"])


def test_a_late_prediction_is_dropped_after_another_scene_was_chosen(page):
    move(page, 0.01)
    (job,) = page.pool.waiting(skeletons.followed)
    page.order("restore", preset="fig7-case1")
    assert job.cancelled() and page.pool.waiting(worker.compute)
    page.run_all()
    assert page.messages == []


@pytest.fixture
def rested(page, runs):
    """The same visitor: a prediction of NEXT is on screen, and its slider has been released for a second."""
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, skeletons.followed(runs[SCENE].skeleton, NEXT))
    page.order("release")
    assert not page.pool.waiting(skeletons.certified)
    page.run_next()  # the second is over
    return page


def test_a_prediction_is_checked_a_second_after_the_release_behind_predictions_of_others(rested):
    (job,) = rested.pool.waiting(skeletons.certified)
    assert job.call[1] == job.state[0].scene == NEXT and job.rank == EXACT
    assert rested.status()["state"] == "refining"
    made = skeletons.certified(*job.call[1:], *job.state)
    sent = len(rested.chunks)
    rested.pool.returns(rested, skeletons.certified, made)
    assert rested.messages[-1] == {"kind": "skeleton", "checked": made.checked, "body": made.body}
    exact = whole_run(NEXT)
    status = rested.status()
    assert (status["state"], status["frames"], status["notes"]) == ("finished", exact.frames, [])
    assert status["residual"] <= NEXT.tolerance and status["evaluations"] == made.about.evaluations
    assert len(rested.chunks) == sent and not rested.pool.waiting(worker.compute)
    move(rested, 0.03)
    assert rested.pool.waiting(skeletons.followed)[0].call[1] is made.skeleton


def test_a_prediction_that_is_not_the_run_of_its_scene_is_computed(rested):
    (job,) = rested.pool.waiting(skeletons.certified)
    made = skeletons.certified(NEXT.changed(E=80.0), job.state[0])  # the states are those of another E
    assert made.failure == "" or made.body == b""
    wrong = replace(job.state[0], scene=NEXT.changed(E=80.0))
    made = skeletons.certified(wrong.scene, wrong)
    assert made.failure and not made.body
    rested.pool.returns(rested, skeletons.certified, made)
    assert rested.pool.waiting(worker.compute)[0].call[1] == NEXT
    rested.pool.returns(rested, worker.compute, whole_run(NEXT))
    assert rested.status()["state"] == "finished" and rested.chunks


def test_frames_of_a_checked_prediction_come_when_somebody_wants_them(rested):
    (job,) = rested.pool.waiting(skeletons.certified)
    rested.pool.returns(rested, skeletons.certified, skeletons.certified(*job.call[1:], *job.state))
    rested.order("release")
    rested.run_all()
    assert not rested.pool.waiting(worker.compute)
    rested.order("release", exact=True)
    (job,) = rested.pool.waiting(worker.compute)
    assert job.call[1] == NEXT and rested.status()["state"] == "refining"
    rested.pool.returns(rested, worker.compute, whole_run(NEXT))
    rested.order("release", exact=True)  # they are there
    assert rested.status()["state"] == "finished" and not rested.pool.waiting(worker.compute)


def test_a_check_is_given_up_for_frames_that_somebody_wants(rested):
    (job,) = rested.pool.waiting(skeletons.certified)
    rested.order("release", exact=True)
    assert job.cancelled() and rested.pool.waiting(worker.compute)[0].call[1] == NEXT


def test_a_run_that_is_known_is_shown_in_place_of_a_check(page, runs):
    call = worker.compute, NEXT
    page.session.jobs.results.put(call, (call, runs[NEXT]))
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, skeletons.followed(runs[SCENE].skeleton, NEXT))
    page.order("release")
    page.run_next()
    assert page.status()["state"] == "finished" and page.status()["known"]


def test_predictions_of_a_wave_are_checked_as_soon_as_the_slider_is_released(page, runs):
    page.session._own = page.session.scene = page.session.scene.changed(surface="wave")
    page.session.pursuit.shown, page.session.pursuit.skeleton = page.session.scene, b"skeleton"
    page.order("release")
    assert page.pool.waiting(skeletons.certified)


def test_the_approach_of_a_scene_serves_other_depths(runs):
    """In the worker that has certified it; the cautions of a certificate are those of the run."""
    skeletons._known.clear()
    first = skeletons.certified(NEXT, follow(runs[SCENE].skeleton, NEXT))
    deeper = NEXT.changed(delta_bar=0.05)
    again = skeletons.certified(deeper, follow(first.skeleton, deeper))
    skeletons._known.clear()
    alone = skeletons.certified(deeper, follow(first.skeleton, deeper))
    assert again.about.evaluations < 0.7 * alone.about.evaluations
    exact = whole_run(deeper)
    assert again.about.widest == pytest.approx(exact.widest, abs=0.03)
    assert again.about.safe_damping == pytest.approx(exact.safe_damping, abs=0.05)
    assert again.about.sensitive == exact.sensitive


def test_a_slider_that_moves_again_within_a_second_has_no_exact_run_in_between(page, runs):
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, skeletons.followed(runs[SCENE].skeleton, NEXT))
    page.order("release")
    move(page, 0.03)
    page.run_all()
    assert not page.pool.waiting(worker.compute) and not page.pool.waiting(skeletons.certified)


def test_exact_run_starts_at_once_for_those_who_need_it(page, runs):
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, skeletons.followed(runs[SCENE].skeleton, NEXT))
    page.order("release", exact=True)
    (job,) = page.pool.waiting(worker.compute)
    assert job.call[1] == NEXT


def test_a_new_drag_cancels_the_exact_run(page, runs):
    move(page, 0.02)
    page.order("release", exact=True)
    assert not page.pool.waiting(worker.compute)  # one call at a time: the prediction comes first
    page.pool.returns(page, skeletons.followed, skeletons.followed(runs[SCENE].skeleton, NEXT))
    (job,) = page.pool.waiting(worker.compute)
    move(page, 0.03)
    assert job.cancelled() and page.pool.waiting(skeletons.followed)


def test_exact_run_starts_at_once_if_a_prediction_fails_and_the_reason_is_counted(page):
    move(page, 0.02)
    move(page, 0.05)
    page.pool.returns(page, skeletons.followed, 'the contact is "lost"')
    (job,) = page.pool.waiting(worker.compute)
    assert job.call[1] == SCENE.changed(delta_bar=0.05) and job.rank == SCREEN  # the newest position
    assert page.status()["state"] == "running"
    assert b'contact_not_followed_total{reason="the contact is \\"lost\\""} 1.0\n' in metrics.text()
    job.slot = "a worker"
    move(page, 0.06)
    assert not page.pool.waiting(skeletons.followed)
    page.pool.returns(page, worker.compute, whole_run(job.call[1]))
    (job,) = page.pool.waiting(skeletons.followed)  # from the run that has just ended
    assert job.call[2].delta_bar == 0.06 and page.session.run.scene.delta_bar == 0.05


def test_a_long_exact_run_is_ended_for_the_newest_position(page, monkeypatch):
    monkeypatch.setattr(pursuit, "SOON", 0.0)
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, "no reason")
    (job,) = page.pool.waiting(worker.compute)
    job.slot = "a worker"
    for value in (0.03, 0.04):
        move(page, value)
    page.pool.returns(page, worker.compute, worker.compute(job.call[1], None, 0.0))
    (job,) = page.pool.waiting(skeletons.followed)
    assert job.call[2].delta_bar == 0.04


def test_skip_starts_the_newest_position_that_waits(page):
    """It was forgotten: the picture stayed that of the run skipped."""
    page.order("scene", phi_ratio=0.5)
    (job,) = page.pool.waiting(worker.compute)
    job.slot = "a worker"
    page.order("scene", phi_ratio=0.6)
    page.order("skip")
    assert page.pool.waiting(worker.compute)[-1].call[1].phi_ratio == 0.6
    assert page.session.run.scene.phi_ratio == 0.6


def test_a_new_scene_waits_for_a_started_slice_for_a_limited_time(page):
    page.order("scene", phi_ratio=0.5)
    (job,) = page.pool.waiting(worker.compute)
    job.slot = "a worker"
    page.order("scene", phi_ratio=0.6)
    assert page.pool.waiting(worker.compute) == [job] and page.status()["acknowledged"] is not None
    page.run_all()  # the time is over
    assert job.cancelled()
    assert [job.call[1].phi_ratio for job in page.pool.waiting(worker.compute)] == [0.6]


def test_a_prediction_lost_with_its_worker_starts_an_exact_run(page):
    move(page, 0.02)
    page.pool.returns(page, skeletons.followed, Lost("hang", "no answer within 20 s"))
    assert page.pool.waiting(worker.compute)


def test_a_predicted_state_that_is_not_finite_counts_as_not_followed(runs, monkeypatch):
    def broken(skeleton, scene):
        there = follow(skeleton, scene)
        first, *others = there.branches
        states = [state._replace(v=np.full_like(state.v, np.nan)) for state in first.states]
        return replace(there, trace=replace(there.trace, branches=(replace(first, states=states), *others)))

    monkeypatch.setattr(skeletons, "follow", broken)
    assert "not finite" in skeletons.followed(runs[SCENE].skeleton, NEXT)
