"""Ends of branches, and which branch comes next."""

import numpy as np
import pytest

from solver import Scene, advance, load_path
from solver.contact import Contact
from solver.fast import Fast
from solver.flow import Flow
from solver.fold import follow
from solver.growth import growth_rate
from solver.loadpath import next_frame
from solver.state import shear

CASES = [{}, {"delta_bar": -0.15}, {"delta_bar": 0.4, "phi_ratio": 0.1}]


def events(scene):
    return [event for f in load_path(scene) if f.stage == "shear" for event in f.slips]


@pytest.mark.parametrize("values", CASES)
def test_slips_come_a_lattice_period_apart_at_the_same_force(values):
    """Translation by a site is an exact symmetry, so every slip repeats the first, which came from virgin loading."""
    scene = Scene(u_x_max=24.0, **values)
    found = events(scene)
    assert len(found) >= 5
    assert np.diff([e.load for e in found]) == pytest.approx(scene.spacing, abs=1e-6)
    # near its maximum in load, the force varies with the square root of an error in load
    assert np.array([e.F_bar for e in found]) == pytest.approx(found[0].F_bar, rel=1e-4)
    assert np.array([e.A_bar for e in found]) == pytest.approx(found[0].A_bar, abs=1e-4)


@pytest.mark.parametrize("du_x", [0.03, 0.31, 1.0])
def test_end_of_the_branch_does_not_depend_on_the_increment(du_x):
    event = events(Scene(u_x_max=12.0, du_x=du_x))[0]
    assert event.load == pytest.approx(10.80363, abs=1e-4)
    assert event.F_bar == pytest.approx(1.11247e-3, rel=1e-4)


def before_the_slip(scene):
    """The checkpoint before the increment with the first slip in shear."""
    checkpoint = None
    while True:
        frames, ahead = advance(scene, checkpoint, budget=0.0)
        if frames[0].stage == "shear" and frames[0].slip:
            return checkpoint
        checkpoint = ahead


@pytest.mark.parametrize("values", CASES)
def test_the_branch_reached_is_that_of_a_tiny_step_flow(values):
    """From the fold itself, kicked by 0.02 nm, a hundred times more accurate, and to rest without secant steps."""
    scene = Scene(**values)
    checkpoint = before_the_slip(scene)
    method = Fast(scene, checkpoint.first, checkpoint.state.active.size)
    load = scene.shear_at(checkpoint.index)
    fold = follow(method, checkpoint.state, shear(scene), load)
    kick = fold.beyond - fold.u
    flow = Flow(method.contact, fold.u + 0.02 * kick / np.abs(kick).max(), shear(scene).at(fold.load), 2e-4)
    while flow.speed > 1e-5 * flow.peak:
        flow.advance()
    slipped = (flow.u - fold.u)[0].max() / scene.spacing
    assert round(slipped) == 1
    frame, _ = next_frame(scene, checkpoint)
    # the frame is a little farther on the same branch: from the fold to the end of its increment
    assert np.abs(frame.u - flow.u).max() < 2 * (load - fold.load) + 1e-3


def test_surfaces_jump_into_contact_on_approach():
    """With these defaults the surfaces snap together some four delta_n apart; a stiff layer approaches smoothly."""
    snaps = [f for f in load_path(Scene(u_x_max=0.0)) if f.slip]
    assert [f.stage for f in snaps] == ["approach"]
    assert snaps[0].U_slip == pytest.approx(-4.15329, abs=1e-4)
    assert not any(f.slip for f in load_path(Scene(u_x_max=0.0, E=1000.0)))


@pytest.mark.parametrize(
    "values", [{}, {"tolerance": 1e-10}, {"tolerance": 1e-5}, {"delta_bar": -0.15}, {"du_x": 0.33}]
)
def test_every_frame_is_a_stable_equilibrium(values):
    """Secant steps know no stability: close to the end of a branch they may converge beyond it."""
    scene = Scene(u_x_max=14.0, **values)
    for frame in load_path(scene):
        contact = Contact(scene, frame.first, frame.u.shape[1])
        assert growth_rate(contact, frame.u, contact.within_window(frame.u)) < 1e-5
