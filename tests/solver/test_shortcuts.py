"""Leaving out what a scene does not need changes its cost, not its frames."""

import numpy as np
import pytest
from helpers import on_whole_cell

from solver import Scene, load_path
from solver.run.summary import left_out

SCENES = {
    "patch": Scene(u_x_max=12.0),
    "translation": Scene(u_x_max=22.0),
}


def evaluations(frames):
    return sum(f.evaluations for f in frames)


@pytest.mark.slow
@pytest.mark.parametrize("rule", SCENES)
def test_frames_are_equal_with_and_without_shortcuts(rule):
    scene = SCENES[rule]
    spared = list(load_path(scene))
    full = on_whole_cell(scene) if rule == "patch" else list(load_path(scene, replay=False))
    assert len(spared) == len(full)
    assert max(f.residual for f in spared + full) <= scene.tolerance
    F, L = (max(abs(getattr(f, name)) for f in full) or 1.0 for name in ("F_bar", "L_bar"))
    for a, b in zip(spared, full, strict=True):
        wide, narrow = (a, b) if a.u.shape[1] > b.u.shape[1] else (b, a)
        part = slice(narrow.first - wide.first, narrow.first - wide.first + narrow.u.shape[1])
        # a residual of the tolerance leaves a few times it in u, and more where the branch is about to end
        assert np.abs(wide.u[:, part] - narrow.u).max() < (2e-6 if rule == "translation" else 2e-7)
        assert a.slip == b.slip
        assert abs(a.F_bar - b.F_bar) < 1e-6 * F and abs(a.L_bar - b.L_bar) < 1e-6 * L
        assert abs(a.A_bar - b.A_bar) * scene.nodes < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "counted"), [("patch", "nodes"), ("translation", "increments")])
def test_a_run_counts_what_it_left_out_and_nothing_if_it_may_not(rule, counted):
    scene = SCENES[rule]
    frames, full = list(load_path(scene)), on_whole_cell(scene, replay=False)
    expected = sum(f.repeated for f in frames) if rule == "translation" else scene.nodes - frames[-1].u.shape[1]
    assert left_out(frames)[counted] == expected > 0
    assert left_out(full) == {"nodes": 0, "increments": 0}


@pytest.mark.slow
def test_repeated_increments_cost_about_one_evaluation_and_are_marked():
    frames = [f for f in load_path(Scene()) if f.stage == "shear"]
    repeated = [f for f in frames if f.repeated]
    assert len(repeated) > 280
    assert np.median([f.evaluations for f in repeated]) == 1
    assert evaluations(repeated) < 2 * len(repeated)
    # the first of 12 slips is solved for, and its motion made thrice; the count varies with FFTW's transforms
    assert evaluations(frames) < 0.2 * evaluations(load_path(Scene(), replay=False))


@pytest.mark.thorough
@pytest.mark.slow
def test_slips_that_begin_as_flutter_are_repeated_where_the_branch_bends_towards_its_end():
    scene = Scene(E=10.0, delta_bar=-0.15, u_x_max=31.0)
    shear = {f.index: f for f in load_path(scene) if f.stage == "shear"}
    slips = [f for f in shear.values() if f.slip]
    assert len(slips) == 3 and all(f.slips[0].kind == "flutter" for f in slips)
    assert all(f.repeated for f in slips[1:]) and evaluations(slips[1:]) < 100
    solved = {f.index: f for f in load_path(scene, replay=False) if f.stage == "shear"}
    events = [event for f in solved.values() for event in f.slips]
    assert [f.slips[0].load for f in slips] == pytest.approx([event.load for event in events], abs=1e-6)
    after = slips[-1].index + 2  # where it rests after a flutter depends on the increments
    assert shear[after].F_bar == pytest.approx(solved[after].F_bar, rel=1e-6)


def test_a_slip_known_from_the_record_lies_a_whole_number_of_periods_on():
    scene = Scene()
    events = [e for f in load_path(scene) for e in f.slips if f.stage == "shear"]
    # the same state, its sums rounded anew
    assert np.array([e.F_bar for e in events]) == pytest.approx(events[1].F_bar, rel=1e-11)
    assert np.diff([e.load for e in events]) == pytest.approx(scene.spacing, abs=1e-9)


def test_median_evaluations_per_increment_on_a_branch():
    scene = Scene(u_x_max=10.7)
    shear = [f for f in load_path(scene) if f.stage == "shear"]
    assert np.median([f.evaluations for f in shear]) <= 6  # every second one is looked at for modes that may grow
