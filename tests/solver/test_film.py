"""Slow motion through a slip: the motion that decides where it ends, from the end of the branch to the next rest."""

from itertools import islice

import numpy as np
import pytest

from solver import Checkpoint, Scene
from solver.presets import preset
from solver.run.film import through
from solver.run.loadpath import Run


def slip_of(scene, stage):
    """(Checkpoint before, frame) of the first slip in a stage."""
    before = Checkpoint()
    for frame, after in Run(scene).frames():
        if frame.slip and frame.stage == stage and frame.index:
            return before, frame
        before = after
    raise AssertionError("no slip")


CASES = [
    (Scene(u_x_max=14.0), "shear"),
    (Scene(delta_bar=0.1), "approach"),
    (Scene(delta_bar=0.4, phi_ratio=0.1, hold="load", u_x_max=12.0), "shear"),
    (preset("loop").scene, "back"),
    (preset("unload").scene, "unload"),
    (preset("fig4a-blue").scene, "shear"),
]


@pytest.mark.parametrize(("scene", "stage"), CASES)
def test_film_of_a_slip_leads_from_the_branch_end_to_the_frame(scene, stage):
    before, frame = slip_of(scene, stage)
    film, end = through(scene, before)
    event = frame.slips[0]
    assert 10 < len(film) <= 60
    # the same end of the same branch, and the same rest
    assert (film[0].F_bar, film[0].A_bar) == pytest.approx((event.F_bar, event.A_bar), rel=1e-3, abs=1e-5)
    assert film[0].residual < 1e-4 and film[-1].residual <= scene.tolerance
    assert max(state.residual for state in film) > 0.05 * scene.delta_t  # in between it is not at rest
    assert end.F_bar == pytest.approx(frame.F_bar, rel=1e-4, abs=1e-8)
    assert end.L_bar == pytest.approx(frame.L_bar, rel=1e-4, abs=1e-8)
    top = [(state.U_x, state.delta) if scene.hold == "delta" else state.U_x for state in film]
    assert np.ptp(top, axis=0) == pytest.approx(0.0, abs=1e-9)  # the top stands still, or carries its weight


def test_film_states_are_evenly_spaced_in_the_path_of_the_fastest_node():
    scene = Scene(u_x_max=14.0)
    film, _ = through(scene, slip_of(scene, "shear")[0], most=30)
    assert len({state.u.shape for state in film}) == 1
    steps = np.abs(np.diff([state.u for state in film], axis=0)).max(axis=(1, 2))
    assert 20 < len(film) <= 30 and steps.sum() > scene.spacing and steps.max() < 3.0 * np.median(steps)


def test_a_frame_without_a_slip_has_no_film():
    (_, before), (frame, _) = islice(Run(Scene()).frames(), 9, 11)
    film, end = through(Scene(), before)
    assert film == [] and end.F_bar == frame.F_bar


def test_a_slip_that_a_run_repeats_from_an_earlier_one_has_a_film():
    """Replay shows such a slip without a motion."""
    before, frame = Checkpoint(), None
    for frame, after in Run(Scene()).frames():
        if frame.repeated and frame.slip:
            break
        before = after
    film, end = through(Scene(), before)
    assert frame.repeated and len(film) > 10
    assert end.F_bar == pytest.approx(frame.F_bar, rel=1e-6)
