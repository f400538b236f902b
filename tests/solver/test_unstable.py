"""The unstable branch between two stable ones: both ends, its states, and what it says."""

import numpy as np
import pytest

from solver import NotFollowed, Scene, skeleton_of, unstable_branch
from solver.continuation.arc import walk_arc
from solver.continuation.corrector import Corrector
from solver.continuation.rest import Judge
from solver.continuation.state import Point

WEAK = Scene(phi_ratio=0.03)  # a short branch: it slips by a part of a site
ROUGH = Scene(surface="rough", seed=8371, nodes=86, width=209.53, height=1.0, cut_off=0.1, rms_slope=0.0033,
              delta_bar=0.43, phi_ratio=0.5, E=36.0)  # fmt: skip


@pytest.fixture(scope="module")
def weak():
    return skeleton_of(WEAK)


TURNS = Scene(E=92.7, delta_bar=1.12, phi_ratio=0.16)  # the branch turns twice on the way
GLIDES = Scene(E=204.9, delta_bar=0.58, phi_ratio=2.26)  # a front of slip glides through the contact, a soft mode


@pytest.fixture(scope="module", params=[WEAK, Scene(delta_bar=-0.15), Scene(hold="load", phi_ratio=0.05)], ids=repr)
def followed(request):
    skeleton = skeleton_of(request.param)
    return skeleton, unstable_branch(skeleton)


def test_it_begins_where_the_run_slips_and_every_state_is_an_equilibrium(followed):
    skeleton, branch = followed
    slip = skeleton.slips[0] if skeleton.slips[0].kind == "fold" else skeleton.slips[1]
    assert branch.U_x[0] == pytest.approx(slip.load, abs=1e-6)
    assert branch.F_bar[0] == pytest.approx(slip.F_bar, rel=1e-5)
    problem, r = skeleton.problem(), np.empty(branch.v.shape[1])
    assert max(problem.residual(v, U, r) for U, v in zip(branch.U_x, branch.v, strict=True)) <= 1e-8


def test_its_load_falls_and_its_states_are_unstable(followed):
    skeleton, branch = followed
    assert branch.ends and (np.diff(branch.U_x) < 0.0).all()
    middle = branch.v[len(branch.v) // 2]
    assert not Judge(skeleton.scene.damping).rightmost(skeleton.problem(), middle).rests


@pytest.mark.parametrize("scene", [TURNS, GLIDES], ids=repr)
def test_a_branch_that_turns_on_the_way_or_glides_is_followed_to_its_end(scene):
    branch = unstable_branch(skeleton_of(scene))
    ends_as_mirrored(scene, branch)
    turns = (np.diff(np.sign(np.diff(branch.U_x))) != 0.0).sum()
    assert turns == (2 if scene is TURNS else 0) and (f"turns {turns} times" in branch.why) == (scene is TURNS)


def test_a_symmetric_contact_has_the_mirror_image_of_the_slip_at_the_other_end(followed):
    ends_as_mirrored(followed[0].scene, followed[1])


def ends_as_mirrored(scene, branch):
    """Mirrored, a state at U_x is one at -U_x; moved on by a site, it is the fold at the branch's other end."""
    assert branch.ends
    assert branch.U_x[-1] == pytest.approx(scene.spacing - branch.U_x[0], abs=1e-6)
    assert branch.F_bar[-1] == pytest.approx(-branch.F_bar[0], rel=1e-6)
    assert branch.L_bar[-1] == pytest.approx(branch.L_bar[0], rel=1e-6)


def test_beyond_its_end_lies_the_state_in_which_the_slip_lands(weak):
    branch = unstable_branch(weak)
    problem = weak.problem()
    last, before = (Point(branch.U_x[k], branch.v[k]) for k in (-1, -2))
    points = [last]
    for point in walk_arc(Corrector(problem), [last, before]):
        points.append(point)
        if point.load > branch.U_x[0]:
            break
    (low, v), (high, w) = points[-2:]
    solution = Corrector(problem).solve(v + (branch.U_x[0] - low) / (high - low) * (w - v), branch.U_x[0])
    landed = weak.unknowns(branch.U_x[0] + 1e-6)[0]  # beyond the slip of the Skeleton, whose load is as accurate
    assert np.abs(solution.v - landed).max() < 1e-4  # states of a Skeleton are interpolated


def test_the_branch_of_a_later_slip_is_that_of_the_first_moved_on_by_a_site(weak):
    first, second = unstable_branch(weak, 0), unstable_branch(weak, 1)
    np.testing.assert_allclose(second.U_x, first.U_x + weak.scene.spacing, atol=1e-9)
    np.testing.assert_allclose(second.F_bar, first.F_bar, rtol=1e-12)
    np.testing.assert_allclose(second.v[:, 0], first.v[:, 0] + weak.scene.spacing, atol=1e-9)


def test_a_slip_over_several_sites_says_so():
    branch = unstable_branch(skeleton_of(ROUGH))
    assert branch.sites > 1 and f"over {branch.sites} sites" in branch.why


def test_a_run_that_flutters_and_a_slip_that_is_not_there_are_refused(weak):
    with pytest.raises(NotFollowed, match="flutter"):
        unstable_branch(skeleton_of(Scene(E=12.0)))
    with pytest.raises(IndexError, match=r"slip = 99: allowed for this run: 0 \.\. "):
        unstable_branch(weak, 99)


def test_a_walk_that_ends_for_its_number_of_points_says_so():
    branch = unstable_branch(skeleton_of(TURNS), most=10)
    assert not branch.ends and "It was followed over 11 states to U_x = " in branch.why
