"""Marks beside the sliders, against exact results and against separate runs."""

from copy import copy
from types import SimpleNamespace

import pytest
from visitor import order

from app.features.marks.feature import Feature as Marks
from app.features.marks.feature import mark_calls
from app.session.controls import NAMES
from solver import Scene, follow, load_path, skeleton_of
from solver.analysis import marks
from solver.analysis.friction_laws import critical_modulus
from solver.presets import preset

OFF = 1.003  # a factor: so far from a mark, runs slip on one side only


@pytest.fixture(scope="module")
def default():
    return skeleton_of(Scene())


def moved(skeleton, **changes):
    return follow(skeleton, skeleton.scene.changed(**changes))


def found(skeleton, name):
    """{what happens: value} on a slider."""
    return {said: value for value, said in marks.of_skeleton(skeleton, name)}


def slips(scene):
    return any(frame.slips for frame in load_path(scene.changed(u_x_max=15.0, du_x=0.5)) if frame.stage == "shear")


def test_marks_of_a_flat_equal_the_exact_limit_of_smooth_sliding():
    flat = preset("fig4a-blue").scene
    told = mark_calls(flat, None)
    function, *arguments = told["E"]
    assert function(*arguments) == ((pytest.approx(critical_modulus(flat)), "slides smoothly"),)
    function, *arguments = told["phi_ratio"]
    ((ratio, said),) = function(*arguments)
    assert said == "slips above" and critical_modulus(flat.changed(phi_ratio=ratio)) == pytest.approx(flat.E)


@pytest.mark.parametrize("name", ["phi_ratio", "E"])
def test_a_flat_without_friction_has_no_marks(name):
    function, *arguments = mark_calls(preset("fig4a-blue").scene.changed(phi_ratio=0.0), None)[name]
    assert function(*arguments) == ()


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "said", "above"), [("phi_ratio", "slips above", True), ("E", "slides smoothly", False)]
)
def test_a_punch_slips_on_one_side_of_its_mark_only(default, name, said, above):
    value = found(default, name)[said]
    assert slips(Scene(**{name: value * OFF})) is above
    assert slips(Scene(**{name: value / OFF})) is not above


@pytest.mark.parametrize("E", [20.0, 2500.0, 3000.0])
def test_marks_do_not_depend_on_the_slider_position_of_the_search(default, E):
    """At 3000 GPa the punch slides smoothly; at 20 GPa the search begins at a stiffer layer."""
    near = found(skeleton_of(Scene(E=E)), "E")
    assert near["slides smoothly"] == pytest.approx(found(default, "E")["slides smoothly"], rel=1e-6)


@pytest.mark.once
@pytest.mark.parametrize("start", [-0.1, 0.6])
def test_indentation_marks_match_zero_load_and_the_jump_into_contact(start):
    """From any slider position."""
    scene = Scene(E=30.0, du_x=0.5, u_x_max=40.0)
    at = found(skeleton_of(scene.changed(delta_bar=start)), "delta_bar")
    frames = list(load_path(scene.changed(delta_bar=at["no load"], u_x_max=0.0)))
    approach = [frame for frame in frames if frame.stage == "approach"]
    largest = max(abs(frame.L_bar) for frame in approach)
    assert abs(approach[-1].L_bar) < 0.01 * largest
    (jump,) = (slip for frame in approach for slip in frame.slips)
    assert at["jumps in"] * scene.delta_0 == pytest.approx(jump.load, abs=1e-3)


def test_slips_may_end_as_the_contact_is_lost_and_no_mark_is_where_they_end_beyond():
    """Under this tension a stiffer surface no longer jumps into contact; the other punch slips at 3000 GPa, too."""
    assert found(skeleton_of(Scene(delta_bar=-0.41)), "E") == {"slides smoothly": pytest.approx(72.4589, abs=1e-3)}
    assert found(skeleton_of(Scene(E=40.0, phi_ratio=1.2, delta_bar=0.7)), "E") == {}
    assert mark_calls(preset("unload").scene, None) == {}  # a path that is not followed


def test_moving_a_slider_recomputes_the_marks_of_the_other_sliders_only(default):
    """The marks of the moved slider itself stay. Each is published by a new dictionary, or it would not be sent."""

    class Page:
        pool = None

        def publish(self):
            published.append(page.values)

    page = Marks(Page())
    asked, published = [], []
    page.add = lambda calls: [asked.append(call[2]) or page._made(call, call[0](*call[1:])) for call in calls]
    page.ended(SimpleNamespace(scene=Scene()), default)
    assert sorted(asked) == sorted(NAMES)
    assert [len(values) for values in published] == [1, 2, 3]
    asked.clear()
    page.ended(SimpleNamespace(scene=Scene(delta_bar=0.1)), moved(default, delta_bar=0.1))
    assert sorted(asked) == ["E", "phi_ratio"]


def test_marks_of_the_sliders_are_those_of_the_scene_also_after_a_run_that_was_skipped(session):
    order(session, "restore", preset="fig4a-blue")
    order(session, "scene", E="80")
    order(session, "skip")
    calls = [*session.features["marks"].waiting]
    assert session.status["state"] == "skipped" and calls
    assert all(scene.E == 80.0 for _, scene, _ in calls)


def test_an_exact_run_that_ends_after_another_of_its_scene_awaits_its_own_marks_only(session, default):
    made, again = session.features["marks"], copy(default)
    for skeleton in (default, again):
        made.ended(SimpleNamespace(scene=default.scene), skeleton)
    assert {skeleton for _, skeleton, _ in made.waiting} == {again}
