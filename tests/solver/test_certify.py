"""A certificate holds where a followed run is the run of its scene, and names what is wrong where it is not."""

import pickle
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from solver import Scene, certify, follow, load_path, skeleton_of
from solver.continuation.trace import Branch, Point

SMALL = Scene(nodes=128, width=312.5, delta_bar=0.1, u_x_max=20.0)  # an eighth of the default
PUNCH = Scene(nodes=256, width=625.0, radius=4.0, E=30.0, delta_bar=0.1, u_x_max=20.0)  # it jumps into contact
MOVES = {
    "punch": (PUNCH, {"E": 28.0}),
    "held load": (SMALL.changed(hold="load"), {"E": 60.0}),
    "drive": (SMALL.changed(drive_t=50.0), {"drive_t": 60.0}),
    "wave": (SMALL.changed(surface="wave", amplitude=2.0), {"delta_bar": 0.12}),
    "rough": (SMALL.changed(surface="rough", E=30.0, rms_slope=0.01, cut_off=0.2), {"E": 31.0}),
    "slipping flat": (SMALL.changed(surface="flat", phi_ratio=0.05, delta_bar=0.0), {"phi_ratio": 0.051}),
    "smooth flat": (SMALL.changed(surface="flat", phi_ratio=0.01), {"phi_ratio": 0.011}),
    "overdamped": (SMALL.changed(damping=inf), {"phi_ratio": 1.1}),
    "other law": (SMALL.changed(law="xu-needleman", delta_bar=-0.05), {"E": 65.0}),
}
LOADS = np.linspace(0.05, 19.9, 57)


@pytest.fixture(scope="module")
def punch():
    return skeleton_of(PUNCH)


@pytest.mark.once(4)
@pytest.mark.parametrize("kind", MOVES)
def test_a_certified_run_is_the_exact_one(kind):
    """Slips to what solves leave near a fold; F and L between states to 1e-3 of their largest, as followed runs are."""
    base, move = MOVES[kind]
    found = certify(follow(skeleton_of(base), base.changed(**move)))
    assert found.holds, found
    exact = skeleton_of(base.changed(**move))
    assert [e.load for e in found.skeleton.slips] == pytest.approx([e.load for e in exact.slips], abs=1e-6)
    assert [e.sensitive for e in found.skeleton.slips] == [e.sensitive for e in exact.slips]
    near_slip = np.abs(LOADS[:, None] - [e.load for e in exact.slips]).min(axis=1, initial=inf) < 1e-3
    for mine, theirs in zip(found.skeleton.curve(LOADS)[:2], exact.curve(LOADS)[:2], strict=True):
        scale = max(np.abs(exact.curve(LOADS)[0]).max(), np.abs(exact.curve(LOADS)[1]).max())
        assert np.abs(mine - theirs)[~near_slip].max() < 1e-3 * scale
    assert found.skeleton.residual <= base.tolerance


def test_a_certificate_counts_what_was_checked_and_costs_less_than_the_run(punch):
    found = certify(punch)
    assert (found.folds, found.landings) == (len(punch.trace.jumps) + len(punch.branches),) * 2
    assert found.states > sum(len(branch.states) - 1 for branch in punch.branches)
    assert found.evaluations < punch.evaluations and found.skeleton.evaluations == punch.evaluations + found.evaluations
    assert repr(found).startswith(f"Certificate: {found.states} states, {found.folds} folds")
    assert pickle.loads(pickle.dumps(found)).skeleton.slips[0].load == pytest.approx(punch.slips[0].load, abs=1e-6)


def test_a_slip_that_depends_on_details_of_the_motion_is_sensitive_in_the_skeleton(punch):
    """As in the frames of its run; skeletons never carried it. Which slips are may depend on the processor."""
    scene = Scene(nodes=256, width=625.0, E=10.0, delta_bar=0.3, phi_ratio=2.0, u_x_max=30.0)
    seen = [event.sensitive for frame in load_path(scene) if frame.stage == "shear" for event in frame.slips]
    assert [e.sensitive for e in certify(skeleton_of(scene)).skeleton.slips] == seen
    (branch,) = punch.branches
    unsure = replace(branch, slip=branch.slip._replace(sensitive=True))
    assert all(e.sensitive for e in replace(punch, trace=replace(punch.trace, branches=(unsure,))).slips)


WRONG = (
    *("lands two sites on", "states of another E", "states of another ratio", "states of another nu"),
    *("states of another depth", "a state moved", "a missing slip", "a slip too many", "a missing jump"),
    *("a jump too many", "too short a run"),
)


def on_purpose(skeleton):
    """{what: (a Skeleton made wrong, what is found)}."""
    scene, trace, branch = skeleton.scene, skeleton.trace, skeleton.branches[0]
    long = Branch.of(np.append(branch.loads[:-1], branch.end + 0.3), np.vstack([branch.v[:-1], branch.v[-1]]))
    early = branch.without(np.array([len(branch.states) - 1]))
    fold = branch.slip._replace(load=early.end, v=early.states[-1].v)
    middle = len(branch.states) // 2
    moved = Point(branch.states[middle].load, branch.states[middle].v + 0.1)
    off = replace(branch, states=(*branch.states[:middle], moved, *branch.states[middle + 1 :]))

    def traced(**changes):
        return replace(skeleton, trace=replace(trace, **changes))

    return {
        "lands two sites on": (traced(period=2.0 * skeleton.period), "landing"),
        "states of another E": (replace(skeleton, scene=scene.changed(E=1.06 * scene.E)), ""),
        "states of another ratio": (replace(skeleton, scene=scene.changed(phi_ratio=1.02 * scene.phi_ratio)), ""),
        "states of another nu": (replace(skeleton, scene=scene.changed(nu=0.42)), ""),
        "states of another depth": (replace(skeleton, scene=scene.changed(delta_bar=scene.delta_bar + 0.02)), "end"),
        "a state moved": (traced(branches=(off,)), "state"),
        "a missing slip": (traced(branches=(long,), period=0.0), "state"),
        "a slip too many": (traced(branches=(replace(early, slip=fold),)), "fold"),
        "a missing jump": (traced(jumps=()), "jump"),
        "a jump too many": (traced(jumps=(*trace.jumps, trace.jumps[-1]._replace(load=scene.delta - 0.1))), "jump"),
        "too short a run": (replace(skeleton, scene=scene, trace=replace(trace, period=0.0)), "landing"),
    }


@pytest.mark.parametrize("what", WRONG)
def test_a_prediction_made_wrong_is_refused_and_what_is_wrong_is_named(punch, what):
    wrong, named = on_purpose(punch)[what]
    found = certify(wrong)
    assert not found.holds and found.skeleton is wrong
    assert not named or found.found[0].what == named, found


def test_a_state_held_under_a_load_is_checked():
    held = skeleton_of(SMALL.changed(hold="load"))
    assert certify(held).holds
    moved = replace(held, held=replace(held.held, v=held.held.v + 0.03))
    other = replace(held, held=replace(held.held, kind="control"))
    assert certify(moved).found[0].what == "end" and certify(other).found[0].what == "held load"


def test_a_jump_that_following_lost_is_found_again(punch):
    found = certify(replace(punch, lost=True, trace=replace(punch.trace, jumps=())))
    assert found.holds and not found.skeleton.lost
    assert [j.load for j in found.skeleton.trace.jumps] == pytest.approx([j.load for j in punch.trace.jumps], abs=1e-6)


def test_a_slip_over_another_number_of_sites_is_found():
    """Followed, a flat slips at 16.8 nm for the second time, not at 14.4: only the landing tells."""
    flat = Scene(surface="flat", phi_ratio=0.05)
    followed = follow(skeleton_of(flat), flat.changed(phi_ratio=0.06))
    exact = skeleton_of(flat.changed(phi_ratio=0.06))
    assert abs(followed.slips[1].load - exact.slips[1].load) > 1.0
    assert certify(followed).found[0].what == "landing" and certify(exact).holds


def test_the_approach_of_a_certificate_serves_other_depths_and_no_other_scene(punch):
    known = certify(punch)
    deeper = follow(punch, PUNCH.changed(delta_bar=0.15))
    first, again = certify(deeper), certify(deeper, known=known)
    assert first.holds and again.holds and again.evaluations < 0.8 * first.evaluations
    assert [e.load for e in again.skeleton.slips] == pytest.approx([e.load for e in first.skeleton.slips], abs=1e-9)
    shallow = certify(follow(punch, PUNCH.changed(delta_bar=0.05)), known=again)  # whose states came from another one
    assert shallow.holds
    softer = follow(punch, PUNCH.changed(E=29.0))
    assert certify(softer, known=known).evaluations == certify(softer).evaluations


def test_a_limit_of_evaluations_ends_a_certificate_without_a_verdict(punch):
    found = certify(punch, limit=200)
    assert not found.holds and found.found[-1].what == "limit" and "200 force evaluations" in repr(found)
    assert found.evaluations <= 201


def test_what_is_no_skeleton_is_named():
    with pytest.raises(TypeError, match="skeleton = Scene: allowed: a Skeleton; use skeleton_of"):
        certify(PUNCH)


def test_a_followed_slip_leaves_its_fold_forwards():
    """Newton's steps may turn the null vector; a motion that began backwards took 40,000 evaluations more."""
    scene = Scene(E=96.79, phi_ratio=1.02, delta_bar=0.413)
    skeleton = follow(skeleton_of(scene), scene.changed(phi_ratio=1.362))
    branch = skeleton.branches[0]
    assert branch.slip.phi @ (branch.slip.v - branch.states[-2].v) > 0.0
    made = certify(skeleton)
    assert made.holds and made.evaluations < 0.75 * skeleton_of(skeleton.scene).evaluations
