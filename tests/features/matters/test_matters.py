"""The page "What matters" without a browser: sensitivities of the first slip."""

import pytest
from visitor import order

from app.features.matters import tasks
from solver import Scene, skeleton_of

SMALL = Scene(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)


def test_node_sensitivities_sum_to_that_of_the_interface_energy():
    found = tasks.what_matters(SMALL)
    U_s, F_s, _ = found["bars"]["phi_n"]  # of all nodes, friction with adhesion as phi_ratio stays
    assert sum(found["nodes"]) == pytest.approx(F_s, rel=1e-2)
    assert F_s > 0 and U_s > 0
    assert found["bars"]["E"][0] < 0  # a stiffer layer stores less stretch before the springs give way


def test_cell_width_is_not_listed_as_a_sensitivity():
    bars = tasks.what_matters(SMALL)["bars"]
    assert "width" not in bars and {"radius", "height", "E", "phi_n", "delta_bar"} <= set(bars)


def test_a_scene_without_a_slip_gives_a_sentence_instead_of_sensitivities():
    found = tasks.what_matters(SMALL.changed(u_x_max=0.4))
    assert isinstance(found, str) and found


def test_sensitivity_of_the_force_refers_to_newtons_per_metre():
    scenes = [SMALL.changed(E=SMALL.E * factor) for factor in (0.999, 1.001)]
    low, high = (skeleton_of(scene).slips[0].F_bar * scene.E for scene in scenes)
    change = (high - low) / (0.002 * 0.5 * (high + low))
    assert tasks.what_matters(SMALL)["bars"]["E"][1] == pytest.approx(change, abs=2e-3)


def test_a_visitor_receives_the_sensitivities_of_the_scene_on_screen(session):
    order(session, "page", page="matters")
    (job,) = [job for job in session.jobs.pool.jobs if job.call[0] is tasks.what_matters]
    assert job.call[1] == session.scene
    assert session.features["pages"].page.published["texts"]["matters-text"].startswith("Computing")
    order(session, "page", page="")
    assert job.cancelled()
