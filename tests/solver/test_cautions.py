"""Cautions about questionable parameters."""

import pytest

from solver import Scene, simulate, whole_surface
from solver.cautions import cautions
from solver.run.frame import largest_overlap


def test_the_default_scene_needs_no_caution():
    assert cautions(Scene(), 0.3) == []


@pytest.mark.parametrize(
    ("scene", "widest", "said"),
    [
        (Scene(nodes=4096), 0.3, "smoothed away"),
        (Scene(delta_t=0.5), 0.3, "too wide"),
        (Scene(E=14.0, phi_ratio=2.0), 0.3, "the time step of the motion"),
        (Scene(radius=10.0), 0.61, "periodic neighbours"),
        (Scene(radius=1.0), 0.3, "slopes are not small"),
        (Scene(u_x_max=400.0), 0.3, "strained by up to 16 %"),
        (Scene(height=0.1), 0.3, "strained by up to 16 %"),
        (Scene(height=0.1), 0.3, "shear less far"),
        (Scene(height=0.1, delta_bar=5.0, path="unload"), 0.3, "press less deep, or use a higher layer"),
    ],
)
def test_each_questionable_parameter_gives_one_caution(scene, widest, said):
    (sentence,) = cautions(scene, widest)
    assert said in sentence


@pytest.mark.parametrize("values", [{}, {"u_x_max": 1e4, "du_x": 1e-3}, {"u_x_max": 1e4, "E": 0.1, "phi_n": 1.0}])
def test_a_layer_that_is_never_sheared_needs_neither_a_caution_nor_increments_for_it(values):
    """Of path 'unload' u_x_max is no part: U_x stays 0."""
    scene = Scene(path="unload", height=0.1, **values)
    assert cautions(scene) == cautions(scene.changed(u_x_max=0.0))
    assert (scene.farthest, scene.shear_increments) == (0.0, 0)
    assert not any("strained" in sentence for sentence in cautions(scene))


def test_too_weak_damping_gives_a_caution_with_a_safe_value():
    (sentence,) = cautions(Scene(damping=0.3), 0.3, safe_damping=0.42)
    assert "may flutter" in sentence and "Use 0.42 or more" in sentence
    assert cautions(Scene(damping=0.42), 0.3, safe_damping=0.42) == []


def test_surfaces_that_overlap_by_more_than_delta_n_give_a_caution_under_the_law_with_a_potential():
    scene = Scene(law="xu-needleman")
    (sentence,) = cautions(scene, overlap=1.7)
    assert "overlap by up to 1.7 δₙ" in sentence and "Use law=np1, or a smaller delta_bar" in sentence
    assert cautions(scene, overlap=1.0) == cautions(Scene(), overlap=1.7) == []


def test_a_pressed_contact_overlaps_and_a_flat_far_away_does_not():
    deep, far = (simulate(Scene(nodes=32, width=80.0, u_x_max=0.0, delta_bar=d)).frames for d in (1.0, -0.9))
    scene = deep[-1].scene
    expected = -(scene.profile + whole_surface(deep[-1])[1]).min() / scene.delta_n
    assert largest_overlap(deep) == pytest.approx(expected, abs=1e-6) and expected > 1.0
    assert largest_overlap(far) == largest_overlap([]) == 0.0


def test_cautions_start_at_their_limits_and_accumulate():
    assert cautions(Scene(nodes=1600, delta_t=1.25), 0.2) == []  # a / delta_t = 1.25
    assert cautions(Scene(radius=10.0), 0.6) == []
    assert cautions(Scene(E=16.0, phi_ratio=2.0), 0.3) == []
    assert cautions(Scene(width=4096.0, damping=0.4), 0.2) == []  # a / delta_t = 4
    assert cautions(Scene(delta_t=0.5, nu=0.4999), 0.2) == []  # such a layer does not move sideways
    assert len(cautions(Scene(nodes=4096, u_x_max=400.0, radius=1.0), 0.9)) == 4


def test_a_flat_gives_no_caution_about_neighbours_or_slopes():
    assert cautions(Scene(surface="flat", radius=1.0), 1.0) == []
