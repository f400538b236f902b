"""Marks beside the sliders: what a worker finds, against exact results and against runs of their own."""

import pytest

from app.service import marks, worker
from app.service.tasks import Part
from solver import Scene, load_path
from solver.analysis.friction_laws import critical_modulus
from solver.presets import preset


def found(scene, name):
    """{what happens: value} on a slider."""
    kept = None
    while isinstance(result := marks.of_slider(marks.key(scene, name), name, kept), Part):
        kept = result.kept
    return {said: value for value, said in result}


@pytest.fixture
def patient(monkeypatch):
    """However slow the machine, nothing is left out."""
    monkeypatch.setattr(marks, "ENOUGH", 600.0)
    monkeypatch.setattr(worker, "SLOW", 60.0)


def test_on_the_flat_the_marks_are_the_exact_border_of_smooth_sliding():
    flat = preset("fig4a-blue").scene
    border = found(flat, "E")["slides smoothly"]
    assert border == pytest.approx(critical_modulus(flat))
    ratio = found(flat, "phi_ratio")["slips"]
    assert critical_modulus(flat.changed(phi_ratio=ratio)) == pytest.approx(flat.E)


@pytest.mark.slow
def test_a_punch_slips_above_its_mark_on_friction_and_not_below(patient):
    scene = Scene()
    ratio = found(scene, "phi_ratio")["slips"]
    for factor, expected in ((1.5, True), (1 / 1.5, False)):
        frames = load_path(scene.changed(phi_ratio=ratio * factor, u_x_max=15.0, du_x=0.5))
        assert any(frame.slip for frame in frames if frame.stage == "shear") is expected


@pytest.mark.slow
def test_a_soft_punch_has_its_marks_on_indentation(patient):
    scene = Scene(E=10.0)
    at = found(scene, "delta_bar")
    assert at["jumps in"] < 0.0 < at["L = 0"] and "lets go" not in at  # that is beyond the end of the slider
    frames = list(load_path(scene.changed(delta_bar=at["L = 0"], u_x_max=0.0)))
    approach = [frame.L_bar for frame in frames if frame.stage == "approach"]
    assert abs(approach[-1]) < 0.02 * max(map(abs, approach))


def test_where_a_run_does_not_get_through_what_it_reached_is_told(monkeypatch):
    monkeypatch.setattr(marks, "ENOUGH", 0.0)
    assert "lets go" not in found(Scene(), "delta_bar") and found(Scene(), "phi_ratio") == {}


def test_where_nothing_slides_nothing_is_marked():
    assert marks.key(preset("unload").scene, "E") is None
    assert found(Scene(delta_bar=0.4), "E") == {}  # it still slips at the stiff end of the slider
