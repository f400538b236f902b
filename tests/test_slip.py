"""Ends of branches, and which branch comes next."""

import numpy as np
import pytest

from solver import Scene, advance, load_path
from solver.closing import Closing, closed_up
from solver.contact import Contact
from solver.fast import Fast
from solver.flow import Flow
from solver.fold import follow
from solver.growth import growth_rate
from solver.loadpath import next_frame
from solver.state import approach, shear

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


def drawn_in(scene):
    """(contact over the whole cell, the undeformed u, (U_x, U_z)) where the first node comes within the window."""
    contact = Contact(scene, 0, scene.nodes)
    load = approach(scene).at(scene.approach_at(0))
    return contact, contact.undeformed(load), load


@pytest.mark.parametrize(("E", "least"), [(0.1, 40.0), (1.0, 0.03)])
def test_closing_reaches_the_rest_that_the_flow_reaches(E, least):
    """A layer drawn in from ten delta_n away: shut at E = 0.1, hardly moved at E = 1; neither is fully at rest."""
    scene = Scene(E=E, nodes=256, width=624.64)
    contact, u, load = drawn_in(scene)
    flow = Flow(contact, u, load, 0.02)
    while flow.speed > 1e-6:
        flow.advance()
    closing = Closing(contact, u, load)
    while closing.residual > 1e-6:
        closing.advance()
    assert np.abs(flow.u - u).max() > least
    assert np.abs(closing.u - flow.u).max() < 1e-5


def test_coarse_surfaces_lead_to_the_contact_of_the_fine_one():
    """Every node of a soft punch is drawn in, with and without coarse surfaces; gaps to 1e-6 nm."""
    scene = Scene(E=0.01, width=1250.0, nodes=512)
    contact, u, load = drawn_in(scene)
    rests = []
    for start in (u, closed_up(contact, u, load, 1.0)):
        closing = Closing(contact, start, load)
        while closing.residual > 1e-6:
            closing.advance()
        rests.append(closing.u)
    gaps = [scene.profile + rest[1] for rest in rests]
    assert all(gap.max() < 0.1 for gap in gaps)
    assert np.abs(gaps[1] - gaps[0]).max() < 1e-6


def test_a_soft_layer_zips_shut_within_a_budget():
    """At E = 0.01 GPa all 1024 nodes close at first touch: 20 evaluations a node, where the flow needs hundreds."""
    frame = next(load_path(Scene(E=0.01, u_x_max=0.0)))
    gap = Scene().profile[frame.first : frame.first + frame.u.shape[1]] + frame.u[1]
    assert frame.u.shape[1] == 1024 and gap.max() < 0.1
    assert frame.evaluations < 20 * 1024
    contact = Contact(Scene(E=0.01), frame.first, 1024)
    assert growth_rate(contact, frame.u, contact.within_window(frame.u)) < 1e-5
