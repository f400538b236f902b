"""Path `points`: straight lines of the stage in U_x and delta."""

import json
import pickle
from itertools import pairwise

import numpy as np
import pytest
from energy import balance_of
from plain_gfmd import Plain

from solver import Axis, Map, Scene, SceneError, load_path, simulate, summarize, sweep
from solver.cli.options import scene_of
from solver.run.load_steps import load_steps_of, position

SMALL = Scene(nodes=128, width=320.0, radius=1.0, delta_bar=0.2, du_z=0.2, du_x=0.2, u_x_max=8.0)
SPELT = {
    "shear": "0,-1; 0,0.2; 8,0.2",
    "unload": "0,-1; 0,0.2; 0,-1; 0,0.2",
    "loop": "0,-1; 0,0.2; 8,0.2; -8,0.2; 8,0.2",
}


def through(points, **values):
    return SMALL.changed(path="points", points=points, **values)


@pytest.mark.parametrize(("path", "points"), SPELT.items())
def test_points_that_spell_another_path_give_its_frames(path, points):
    named, spelt = list(load_path(SMALL.changed(path=path))), list(load_path(through(points)))
    assert len(named) == len(spelt)
    for a, b in zip(named, spelt, strict=True):
        assert (a.U_x, a.delta) == pytest.approx((b.U_x, b.delta), abs=1e-10)
        np.testing.assert_allclose(b.u, a.u, atol=1e-10)
        assert [event.load for event in b.slips] == pytest.approx([event.load for event in a.slips], abs=1e-10)


def test_points_may_have_true_minus_signs_as_numbers_may():
    assert through("0,−1; 0,0.2; −4,0.2") == through("0,-1; 0,0.2; -4,0.2")


def test_stages_have_the_number_of_their_line_and_the_name_of_what_moves():
    stages = [step.stage for step in load_steps_of(through("0,-1; 0,0; 4,0; 4,0.2; 2,0.2; 3,-1; 3,-0.5"))]
    assert stages == ["approach", "2 shear", "3 reload", "4 back", "5 move", "6 reload"]
    assert [stage.kind for stage in stages] == ["approach", "shear", "reload", "back", "move", "reload"]
    assert [stage.moves for stage in stages] == ["delta", "U_x", "delta", "U_x", "U_x", "delta"]
    assert pickle.loads(pickle.dumps(stages)) == stages


def test_an_oblique_line_ends_at_its_point_and_keeps_the_energy_balance():
    scene = through("0,-1; 0,0.2; 3,0.4; 8,-1", du_x=0.05, du_z=0.05)
    frames = list(load_path(scene))
    assert (frames[-1].U_x, frames[-1].delta) == pytest.approx((8.0, -10.0), abs=1e-12)
    assert max(frame.residual for frame in frames) <= scene.tolerance
    events = [event for frame in frames for event in frame.slips]
    assert events and all(event.located and event.stage == "3 move" for event in events)
    work = balance_of(frames)
    entered = work.stored + work.released - work.surface
    assert work.top[-1] == pytest.approx(entered[-1], rel=2e-3)


def test_an_oblique_retraction_parts_the_surfaces_as_one_straight_up_does():
    """By a twelfth along x: half a nanometre of shear hardly changes the parting load."""
    points = (f"0,-1; 0,0.2; {U_x},-1" for U_x in (0, 1))
    up, oblique = (simulate(Scene(path="points", points=each, du_x=0.5, du_z=0.5)) for each in points)
    assert oblique.slips["kind"].iloc[-1] == "pull-off"
    vertical, found = (summarize(result.frames) for result in (up, oblique))
    assert found["L_off"] == oblique.pull_off.L
    for name in ("L_off", "L_min"):
        assert found[name] == pytest.approx(vertical[name], rel=0.01)


def test_an_end_on_an_oblique_line_does_not_depend_on_the_increment():
    ends = [
        [
            event.load
            for frame in load_path(through("0,-1; 0,0.2; 3,0.4; 8,-1", du_x=du, du_z=du))
            for event in frame.slips
        ]
        for du in (0.2, 0.05)
    ]
    assert ends[0][0] == pytest.approx(ends[1][0], abs=1e-5)


def test_positions_grow_along_the_path_from_the_end_of_the_approach():
    scene = through("0,-1; 0,0.2; 3,0.4; 8,0.4; 8,-1")
    frames = list(load_path(scene))
    along = [position(frame) for frame in frames]
    assert along[0] == -12.0 and along[-1] == pytest.approx(np.hypot(3.0, 2.0) + 5.0 + 14.0)
    assert np.all(np.diff(along) >= -1e-9)
    for before, frame in pairwise(frames):
        for event in frame.slips:
            assert position(before) <= position(frame, event) <= position(frame)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ("", "two points or more"),
        ("0,0; 0,1", "the first at delta_bar -1"),
        ("0,-1; 1,0", "the second at the same U_x"),
        ("0,-1; 0,0.2; 0,0.2", "none the same as the one before"),
        ("0,-1; 0,x", "points = '0,x': allowed: pairs of numbers; write them as 0,-1; 0,0.2; 8,0.2"),
        ("0,-1; 0", "allowed: pairs of numbers"),
        ("0,-1; 0,200", "points = 200.0: allowed: -1 .. 100"),
        ("0,-1; 0,0; " * 11, "allowed: up to 20 pairs"),
        ("0,-1; 0,0; 9999,0", "du_x = 0.001: the run would take"),
    ],
)
def test_points_that_are_no_path_are_refused(points, message):
    with pytest.raises(SceneError) as refused:
        Scene(path="points", points=points, du_x=1e-3)
    assert message in str(refused.value)


def test_a_held_load_is_rejected_for_a_run_through_points():
    with pytest.raises(SceneError, match="hold = 'load': allowed with path 'points': delta; choose path"):
        through(SPELT["shear"], hold="load")


def test_points_survive_text_and_json():
    scene = through("0,-1;0,.2 ; 8.0,2e-1")
    assert scene.points == SPELT["shear"]
    assert SMALL.changed(**json.loads(json.dumps(scene.differences(SMALL)))) == scene


@pytest.mark.thorough
@pytest.mark.slow
def test_the_pull_off_force_after_shear_is_that_of_an_explicit_gfmd():
    """12 shears up to just before the first slip; forces of the increments of the retraction."""
    frames = list(load_path(SMALL))
    first = next(event.load for frame in frames for event in frame.slips if event.stage == "shear")
    shears, plain = np.linspace(0.0, 0.95 * first, 12), Plain(SMALL)
    u = np.array([[0.0], [SMALL.delta_0]]) * np.ones(SMALL.nodes)
    for delta in np.arange(-10.0, 2.05, 0.2):
        u = plain.rest(u, 0.0, -delta).u
    largest, pulls = max(frame.L for frame in frames), []
    for shear in shears:
        u, lifted, forces = plain.rest(u, shear, -SMALL.delta).u, None, []
        for delta in np.arange(2.0, -10.05, -0.2):
            reached = plain.rest(u if lifted is None else lifted, shear, -delta)
            lifted = reached.u
            forces.append(float(reached.T[1].sum()) * SMALL.spacing)
        points = f"0,-1; 0,0.2; {shear},0.2; {shear},-1" if shear else "0,-1; 0,0.2; 0,-1"
        least = min(frame.L for frame in load_path(through(points)) if frame.stage.endswith("unload"))
        assert least == pytest.approx(min(forces), abs=1e-5 * largest)
        pulls.append(least)
    assert pulls[0] == min(pulls)  # without shear before it, the pull-off takes the largest force


def test_the_points_set_the_depth_of_the_approach_and_the_extent_of_the_path():
    scene = through("0,-1; 0,0.3; 3,0.5; -6,0.1")
    assert scene.delta_bar == 0.3 and scene.delta == scene.delta_0 * 0.3
    assert (scene.deepest, scene.farthest) == (5.0, 6.0)
    assert scene.changed(path="shear").delta_bar == 0.3


def test_the_first_slip_of_a_sweep_is_that_of_the_shear_among_the_points():
    shear, points = (sweep(scene, phi_ratio=[1.0]).loc[0] for scene in (SMALL, through("0,-1; 0,0.2; 8,0.2; 8,-1")))
    assert points["outcome"] == shear["outcome"] == "slips"
    assert points["U_s (nm)"] == pytest.approx(shear["U_s (nm)"], abs=1e-6)
    assert "First slip at" in simulate(through(SPELT["shear"]))._repr_html_()


@pytest.mark.parametrize("points", ["0,-1; 0,0.2; -8,0.2", "0,-1; 0,0.2; 8,0.3"], ids=["back", "oblique"])
def test_the_first_slip_of_a_path_is_of_any_line_along_U_x(points):
    """`simulate`, `summarize` and `sweep` name the same one."""
    run = simulate(through(points))
    event = next(event for frame in run.frames if frame.stage != "approach" for event in frame.slips)
    assert summarize(run.frames)["U_s"] == event.load
    assert sweep(run.scene, phi_ratio=[1.0])["U_s (nm)"][0] == event.load
    assert f"First slip at U_x = {event.load:.2f} nm" in run._repr_html_()


@pytest.mark.parametrize("values", [{"delta_bar": [0.0, 0.2]}, {"u_x_max": [1.0, 2.0]}])
def test_a_sweep_refuses_a_parameter_that_the_points_set(values):
    (name,) = values
    with pytest.raises(SceneError, match=rf"{name} = \[.*\]: not used with path 'points', .*; sweep points instead"):
        sweep(through(SPELT["shear"]), **values)


def test_another_depth_than_that_of_the_points_is_refused_and_changed_points_set_theirs():
    with pytest.raises(SceneError, match=r"delta_bar = 0\.5: allowed with these points: 0\.2.*; leave it out"):
        through("0,-1; 0,0.2; 8,0.2").changed(delta_bar=0.5)
    scene = Scene(path="points", points="0,-1; 0,0.2; 8,0.2", delta_bar=0.2)
    assert scene.changed(points="0,-1; 0,0.3; 8,0.3").delta_bar == 0.3
    assert Scene(delta_bar=0.5).changed(path="points", points=scene.points).delta_bar == 0.2
    with pytest.raises(SceneError, match=r"delta_bar = 0\.5: allowed with these points: 0\.2.*; leave it out"):
        Scene(delta_bar=0.5).changed(path="points")
    assert scene.changed(path="shear").delta_bar == 0.2


def test_the_command_line_reports_a_parameter_that_the_points_set(capsys):
    pairs = ["path=points", f"points={SPELT['shear']}"]
    scene_of(pairs)
    assert capsys.readouterr().out == ""
    assert scene_of([*pairs, "delta_bar=0.5"]).delta_bar == 0.2
    assert capsys.readouterr().out == "delta_bar is not used with path=points: the points set it.\n"


def test_a_map_of_a_path_through_points_is_refused():
    with pytest.raises(SceneError, match="path = 'points': allowed in a map: shear, unload or loop"):
        Map(through(SPELT["shear"]), Axis("E", 40.0, 80.0, 3), Axis("nu", 0.1, 0.4, 3))
