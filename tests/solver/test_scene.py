"""Scene: what is accepted, what is refused, and the remedy of every refusal."""

import ast
import pickle
import re
from dataclasses import fields
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest

from solver import LIMITS, Scene, SceneError, __version__, scene_from_text
from solver.run.load_steps import load_steps_of
from solver.scene import PARAMETERS
from solver.schema import RETIRED
from solver.text import number_from_text

# Values at a limit that need another parameter to follow, or the node spacing would leave its own range.
COMPANIONS = {
    ("delta_t", 0): {"width": 10.0},
    ("delta_t", 1): {"width": 1e4, "nodes": 1024},
    ("width", 0): {"nodes": 4},
    ("width", 1): {"nodes": 16384, "delta_t": 10.0},
    ("nodes", 0): {"width": 10.0},
    ("drive_t", 0): {"tolerance": 1e-5},
    ("drive_n", 0): {"tolerance": 1e-5},
}
EDGES = [(name, side) for name in LIMITS for side in (0, 1)]


def beyond(name, side):
    low, high = LIMITS[name][:2]
    step = 1 if name == "nodes" else 1e-9 * (high - low)
    return low - step if side == 0 else high + step


@pytest.mark.parametrize(("name", "side"), EDGES)
def test_limits_themselves_are_accepted(name, side):
    value = LIMITS[name][side]
    assert getattr(Scene(**COMPANIONS.get((name, side), {}), **{name: value}), name) == value


@pytest.mark.parametrize(("name", "side"), EDGES)
def test_beyond_a_limit_the_message_names_parameter_value_and_range(name, side):
    value = beyond(name, side)
    with pytest.raises(SceneError) as caught:
        Scene(**{name: value})
    low, high = LIMITS[name][:2]
    message = str(caught.value)
    assert message.startswith(f"{name} = {value!r}")
    assert f"{low:g} .. {high:g}" in message
    assert caught.value.name == name
    assert "\n" not in message


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("value", [nan, inf, -inf, "text", "1.0", None, True, [1.0], 10**400, 1j])
def test_only_finite_numbers_are_accepted(name, value):
    if LIMITS[name].unbounded and value == inf:
        assert Scene(**{name: value}) == scene_from_text({name: "inf"})
        return
    with pytest.raises(SceneError, match=f"^{name} = "):
        Scene(**{name: value})


@pytest.mark.parametrize("value", [64.5, 10**9, 0, -64])
def test_nodes_must_be_a_whole_number_in_range(value):
    with pytest.raises(SceneError, match="a whole number"):
        Scene(nodes=value)


def test_a_node_spacing_without_lattice_physics_is_refused_with_a_remedy():
    with pytest.raises(SceneError, match="change nodes, width or delta_t"):
        Scene(nodes=4)


def test_an_endless_run_is_refused_with_a_remedy():
    with pytest.raises(SceneError, match="enlarge du_x or shorten the run"):
        Scene(du_x=1e-3, u_x_max=1e4)


def test_an_unknown_surface_is_refused():
    with pytest.raises(SceneError, match="surface = 'bumpy': allowed: circular, flat"):
        Scene(surface="bumpy")


def test_a_scene_is_parsed_from_text():
    scene = scene_from_text({"surface": "flat", "nodes": "64", "width": "160", "delta_bar": "-1.5e-1"})
    assert scene == Scene(surface="flat", nodes=64, width=160.0, delta_bar=-0.15)
    assert isinstance(scene.nodes, int)


@pytest.mark.parametrize(
    "text", ["", "nan", "inf", "1e999", "ten", "0x10", "1,234", "1,5,5", "1_0", "70 kPa", "1;import os"]
)
def test_text_that_is_no_number_in_range_is_refused(text):
    with pytest.raises(SceneError, match=r"^E = .*0\.01 \.\. 1e\+06"):
        scene_from_text({"E": text})


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("delta_bar", "−0.5", -0.5),  # the minus sign that the app shows
        ("delta_bar", " 4e−1 ", 0.4),
        ("E", "70 GPa", 70.0),
        ("E", "70\u2009GPa", 70.0),  # thin space
        ("E", "70\u202f000 MPa", None),  # spaces within a number are not read
        ("E", "500MPa", 0.5),
        ("E", "0.07 TPa", 70.0),  # to the digit
        ("E", "70e9 Pa", 70.0),
        ("width", "2.5 µm", 2500.0),
        ("phi_n", "50 mJ/m²", 0.05),
        ("du_z", "0.5 δₙ", 0.5),
        ("du_z", "1 nm", None),  # which depends on delta_n
        ("damping", "∞", inf),
        ("nodes", "1e3", 1000.0),
        ("nodes", 512, 512.0),
    ],
)
def test_numbers_are_read_as_people_write_them(name, text, value):
    if value is None:
        with pytest.raises(SceneError, match=f"^{name} = .*allowed: .*with its unit"):
            number_from_text(name, text)
    else:
        assert number_from_text(name, text) == value


@pytest.mark.parametrize(
    ("text", "value"), [("0,3", 0.3), ("0,125", 0.125), ("−1,5e−3", -1.5e-3), ("12,3456", 12.3456)]
)
def test_a_decimal_comma_is_read_and_reported(text, value):
    notes = []
    assert number_from_text("delta_bar", text, notes) == value
    assert len(notes) == 1 and "delta_bar" in notes[0] and "comma" in notes[0] and f"{value:g}" in notes[0]


def test_a_comma_that_may_part_thousands_is_refused_with_both_readings():
    with pytest.raises(SceneError, match=r"width = '2,500': 2\.500 or 2500\? allowed.*write a decimal point"):
        number_from_text("width", "2,500")


def reads(path):
    """Names of the attributes that a module reads."""
    return {
        node.attr for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Attribute)
    }


def test_the_solver_uses_every_parameter():
    """As scene.NAME, somewhere in its sources."""
    used = set().union(*(reads(path) for path in (Path(__file__).parents[2] / "solver").rglob("*.py")))
    assert {"E", "hurst"} <= used and "a_name_that_nothing_reads" not in used
    assert not PARAMETERS.keys() - used


def test_every_parameter_declares_its_meaning():
    """All but the profile of a measured surface, which is no number and no word."""
    assert [f.name for f in fields(Scene) if f.name not in PARAMETERS] == ["measured"]
    for known in PARAMETERS.values():
        assert known.meaning and known.group


def test_an_unknown_name_is_refused_with_the_allowed_ones():
    with pytest.raises(SceneError, match=r"'Ebar'.*delta_bar.*tolerance"):
        scene_from_text({"Ebar": "1"})


def test_a_retired_name_is_refused_with_what_to_do():
    with pytest.raises(SceneError, match=r"'window_n'.*no effect since version 0\.2.*leave it out"):
        scene_from_text({"window_n": "10"})
    for sentence in RETIRED.values():  # no version that is still to come
        assert re.search(r"since version (\d+\.\d+),", sentence)[1] <= __version__


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("phi_t", "phi_ratio"),
        ("Emod", "E"),
        ("young", "E"),
        ("poisson", "nu"),
        ("delta", "delta_bar"),
        ("nods", "nodes"),
    ],
)
def test_an_unknown_name_is_refused_with_the_parameter_it_means(name, meant):
    for make in (
        lambda: scene_from_text({name: "1"}),
        lambda: Scene(**{name: 1.0}),
        lambda: Scene().changed(**{name: 1}),
    ):
        with pytest.raises(SceneError, match=rf"name = '{name}': allowed: delta_bar, .*; did you mean {meant}\?$"):
            make()


def test_a_scene_prints_what_differs_from_the_default():
    assert repr(Scene()) == "Scene()"
    assert repr(Scene(delta_bar=0.2, surface="flat")) == "Scene(delta_bar=0.2, surface='flat')"
    assert eval(repr(Scene(E=7.0, drive_t=inf, seed=3))) == Scene(E=7.0, seed=3)


def test_a_scene_is_frozen_hashable_and_picklable():
    scene = Scene(delta_bar=0.2)
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert len({scene, Scene(delta_bar=0.2), Scene()}) == 2
    with pytest.raises(AttributeError):
        scene.delta_bar = 0.3


def test_changed_values_are_validated_too():
    assert Scene().changed(delta_bar=0.2).delta_bar == 0.2
    with pytest.raises(SceneError, match=r"nu = 0\.5"):
        Scene().changed(nu=0.5)


@pytest.mark.parametrize(("delta_bar", "du_z"), [(0.0, 0.1), (0.4, 0.1), (-0.15, 0.3), (-1.0, 0.1), (0.123, 0.7)])
def test_approach_starts_ten_lengths_away_and_ends_exactly_at_its_target(delta_bar, du_z):
    scene = Scene(delta_bar=delta_bar, du_z=du_z, delta_n=2.0)
    approach = load_steps_of(scene)[0]
    path = [approach.at(k) for k in range(approach.increments + 1)]
    assert path[0] == -20.0
    assert path[-1] == scene.delta
    assert np.all(np.diff(path) > 0.0)
    assert np.all(np.diff(path) < du_z * 2.0 * (1 + 1e-9))


@pytest.mark.parametrize(
    ("u_x_max", "du_x", "increments"), [(40.0, 0.1, 400), (0.0, 0.1, 0), (1.0, 0.3, 3), (0.3, 0.1, 3)]
)
def test_shear_goes_as_far_as_whole_increments_reach(u_x_max, du_x, increments):
    scene = Scene(u_x_max=u_x_max, du_x=du_x)
    assert scene.shear_increments == increments
    assert scene.shear_at(0) == 0.0
    assert scene.shear_at(increments) <= u_x_max * (1 + 1e-9)


@pytest.mark.parametrize("nodes", [64, 65])
def test_profile_touches_at_the_middle_and_is_periodic(nodes):
    scene = Scene(nodes=nodes, width=160.0)
    assert scene.x.shape == scene.profile.shape == (nodes,)
    # Periodic mirror symmetry: node i and node n - i are equally high.
    assert np.allclose(scene.profile[1:], scene.profile[:0:-1], rtol=1e-12)
    assert scene.profile.min() <= scene.spacing**2 / (8.0 * scene.radius * scene.width) * (1 + 1e-9)
    assert not Scene(surface="flat", nodes=nodes, width=160.0).profile.any()


def test_scene_errors_survive_pickling():
    with pytest.raises(SceneError) as refused:
        Scene(E=-1.0)
    again = pickle.loads(pickle.dumps(refused.value))
    assert (again.name, str(again)) == (refused.value.name, str(refused.value))


def test_a_punch_pressed_through_the_layer_is_refused_with_a_remedy():
    assert Scene(delta_bar=0.9, width=100.0, nodes=64, height=0.1).delta == pytest.approx(9.0)
    with pytest.raises(SceneError, match=r"delta_bar = 1.0: allowed: below 1, .* enlarge height or width"):
        Scene(delta_bar=1.0, width=100.0, nodes=64, height=0.1)


def test_a_tolerance_below_round_off_is_refused_with_a_remedy():
    assert Scene(tolerance=1e-12).tolerance == 1e-12
    with pytest.raises(SceneError, match="by round-off; enlarge it, or E"):
        Scene(E=0.01, tolerance=1e-10)
    with pytest.raises(SceneError, match=r"round-off alone .* lower height"):
        Scene(E=0.01, height=100.0, nodes=4096, phi_n=1e3, delta_n=0.1, phi_ratio=100.0, surface="flat", tolerance=1e-3)
