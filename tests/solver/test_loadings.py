"""Other loadings: unloading, loops, a held load, damping below critical, parameters changed on the way."""

import pickle
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from helpers import on_whole_cell, same, stage
from spectrum import growth

from solver import NotConverged, Scene, SceneError, advance, load_path, simulate, skeleton_from, skeleton_of
from solver.mechanics.cohesive_law import traction
from solver.mechanics.layer import Modes
from solver.run.held_load import held_at
from solver.run.load_steps import load_steps_of
from solver.run.loadpath import Checkpoint, Run

SMALL = Scene(nodes=128, width=320.0, radius=1.0, du_z=0.2, du_x=0.2, u_x_max=8.0)
PATHS = [
    {"path": "unload"},
    {"path": "loop"},
    {"hold": "load"},
    {"hold": "load", "path": "loop"},
    {"damping": 0.25, "delta_bar": 0.2},
    {"surface": "flat", "phi_ratio": 0.1, "hold": "load", "delta_bar": 0.05},
    {"surface": "flat", "phi_ratio": 0.1, "path": "loop"},
]


# LoadSteps


@cache
def run_of(scene):
    return list(load_path(scene))


@pytest.mark.slow
@pytest.mark.parametrize("values", PATHS)
def test_every_leg_begins_where_the_previous_one_ended(values):
    scene = SMALL.changed(u_x_max=4.0, **values)
    frames = run_of(scene)
    names = list(dict.fromkeys(f.stage for f in frames))
    assert names == [step.stage for step in load_steps_of(scene)]
    for before, after in pairwise(names):
        end, start = stage(frames, before)[-1], stage(frames, after)[0]
        assert (start.index, start.U_x, start.delta) == (0, end.U_x, end.delta)
        assert same(start, end, 10 * SMALL.tolerance) and not start.slip


@pytest.mark.slow
@pytest.mark.parametrize("values", PATHS)
def test_slices_of_every_path_give_the_frames_of_an_uninterrupted_run(values):
    scene = SMALL.changed(u_x_max=4.0, **values)
    whole, sliced, checkpoint = run_of(scene), [], None
    while checkpoint is None or not checkpoint.done:
        frames, checkpoint = advance(scene, pickle.loads(pickle.dumps(checkpoint)), budget=0.0)
        sliced += frames
    assert [(f.stage, f.index, f.U_x, f.slip) for f in sliced] == [(f.stage, f.index, f.U_x, f.slip) for f in whole]
    assert all(same(a, b, 10 * scene.tolerance) for a, b in zip(sliced, whole, strict=True))


def test_a_surface_that_turns_and_does_not_slip_retraces_its_way():
    """The first state after a turn has no prediction: another equilibrium, 0.5 nm off, was once taken for it."""
    back, forth = (stage(list(load_path(SMALL.changed(u_x_max=4.0, path="loop"))), name) for name in ("back", "forth"))
    there = {round(frame.U_x, 9): frame for frame in back}
    assert not any(frame.slip for frame in back + forth)
    assert all(same(frame, there[round(frame.U_x, 9)], 10 * SMALL.tolerance) for frame in forth)


def test_the_steps_of_a_leg_are_even_and_its_ends_exact():
    scene = Scene(path="loop", u_x_max=1.05, du_x=0.1, delta_bar=0.013)
    shear, back, forth = (step for step in load_steps_of(scene) if step.stage != "approach")
    assert [step.loading.at(step.at(step.increments)) for step in (shear, back, forth)] == [
        (1.0, -scene.delta),
        (-1.0, -scene.delta),
        (1.0, -scene.delta),
    ]
    down = load_steps_of(scene)[0]
    assert down.at(0) == -scene.delta_0 and down.at(down.increments) == scene.delta


def test_a_held_load_and_unloading_exclude_each_other():
    with pytest.raises(SceneError, match="hold = 'load': allowed with path 'unload': delta; choose path"):
        Scene(path="unload", hold="load")


@pytest.mark.parametrize("name", ["path", "hold"])
def test_an_unknown_word_is_rejected_with_the_known_ones(name):
    with pytest.raises(SceneError, match=f"{name} = 'up'; allowed".replace("; ", ": ")):
        Scene(**{name: "up"})


# Unloading


def punch(lam, nodes=512, half_widths=20.0):
    """(a frictionless cylinder of that lambda with one spring per node, the force P that is P' = 1)."""
    phi_n, nu, R = 2.0, 0.4999, 200.0
    stiff = np.sqrt((4.0 * phi_n / np.e / lam) ** 3 * R / (np.pi**2 * phi_n))
    width = max(2.0 * half_widths * (phi_n * R**2 / (np.pi * stiff)) ** (1 / 3), 4.0 * np.sqrt(2.0 * R * 13.0))
    scene = Scene(
        path="unload", E=stiff * (1.0 - nu**2), nu=nu, phi_ratio=0.0, width=width, nodes=nodes, radius=R / width,
        delta_t=width / nodes / 5.0, delta_bar=0.4,
    )  # fmt: skip
    return scene, (np.pi * stiff * phi_n**2 * R) ** (1 / 3)


def pull_off(lam):
    scene, unit = punch(lam)
    return min(f.L_bar for f in load_path(scene) if f.stage == "unload") * scene.E * scene.width / unit


@pytest.mark.thorough
@pytest.mark.slow
def test_pull_off_runs_into_the_rigid_limit_as_lambda_falls():
    """A rigid cylinder's pull-off is the law integrated over the gap: in two dimensions it depends on the law (DMT).

    The deflection left is of the order of lambda, and the pull-off changes by a part of that.
    """
    off = []
    for lam in (0.4, 0.1):
        scene, unit = punch(lam)
        depths = np.arange(-2.0, 0.5, 0.02)
        gaps = scene.profile - depths[:, None]
        rigid = traction(scene, np.zeros_like(gaps), gaps)[1].sum(axis=1).min() * scene.spacing / unit
        off.append(abs(pull_off(lam) / rigid - 1.0))
    assert off[1] < 0.01 and off[1] < 0.3 * off[0]


def hysteresis(scene):
    """(area between the curves of retraction and approach over the largest pull times delta_n, slips by stage)."""
    frames = list(load_path(scene))
    up, down = stage(frames, "unload"), stage(frames, "reload")
    area = np.trapezoid([f.L_bar for f in up], [f.delta for f in up])
    area += np.trapezoid([f.L_bar for f in down], [f.delta for f in down])
    slips = {name: [e.load for f in stage(frames, name) for e in f.slips] for name in ("approach", "unload", "reload")}
    return area / (scene.delta_n * abs(min(f.L_bar for f in up))), slips


def softening(scene):
    """The steepest fall of NP1's pull, phi_n/(delta_n e)^2, times the layer's largest compliance: below 1, stable."""
    compliance = Modes.of(scene).compliance[1].max()
    return compliance * scene.phi_n / (np.e * scene.delta_n) ** 2


def test_no_hysteresis_where_no_instability_exists():
    scene = Scene(path="unload", E=1000.0)
    area, slips = hysteresis(scene)
    assert softening(scene) < 1.0 and not any(slips.values())
    assert abs(area) < 1e-6


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("E", [20.0, 70.0])
def test_hysteresis_where_jump_in_and_pull_off_differ(E):
    scene = Scene(path="unload", E=E)
    area, slips = hysteresis(scene)
    assert softening(scene) > 1.0
    # in contact to a larger height on the way up than on the way down; the second approach repeats the first
    assert slips["unload"][0] < slips["approach"][0] - 0.1
    assert slips["reload"] == pytest.approx(slips["approach"], abs=1e-6)
    assert area > 0.05


@pytest.mark.slow
def test_an_adhering_punch_is_retracted_until_it_detaches():
    """At E = 10 it still adheres where the approach began; detached, an undeformed layer attracts by 1.3 % less."""
    scene = Scene(path="unload", E=10.0, du_z=0.5, nodes=512, width=1250.0)
    frames = list(load_path(scene))
    up, down = stage(frames, "unload"), stage(frames, "reload")
    gap = (scene.profile - up[-1].delta) / scene.delta_n
    pull = scene.phi_n / scene.delta_n * (gap * np.exp(-gap)).mean() / scene.E
    assert up[-1].delta < -scene.delta_0 and up[-1].L_bar == pytest.approx(-pull, rel=0.02)
    assert down[0].delta == up[-1].delta and down[-1].delta == scene.delta
    assert same(down[-1], stage(frames, "approach")[-1], 1e-5)


# Loop


@pytest.mark.parametrize("values", [{}, {"delta_bar": 0.2, "hold": "load"}, {"surface": "flat", "phi_ratio": 0.1}])
def test_after_one_full_cycle_the_state_repeats(values):
    """Both ends of a stroke slide steadily; near a fold u varies as the square root of an error of the tolerance."""
    scene = SMALL.changed(path="loop", tolerance=1e-9, **values)
    frames = list(load_path(scene))
    there, back, again = (stage(frames, name)[-1] for name in ("shear", "back", "forth"))
    assert any(f.slip for f in stage(frames, "shear"))
    assert same(there, again, 1e-6)
    stiffness = scene.phi_n / scene.delta_n**2 * (2.0 + 2.0 * scene.phi_ratio)
    assert np.abs(there.T - again.T).max() < stiffness * 1e-6
    assert again.F_bar == pytest.approx(there.F_bar, rel=1e-6)
    assert back.F_bar == pytest.approx(-there.F_bar, rel=1e-6)


def test_sliding_back_mirrors_sliding_forth():
    """Slips lie at opposite loads; known from the record in both directions."""
    frames = list(load_path(SMALL.changed(path="loop")))
    back, forth = (stage(frames, name) for name in ("back", "forth"))
    loads = [np.array([e.load for f in run for e in f.slips]) for run in (back, forth)]
    assert len(loads[0]) >= 4 and loads[0] == pytest.approx(-loads[1], abs=1e-6)
    assert [f.F_bar for f in back] == pytest.approx([-f.F_bar for f in forth], abs=1e-6 * max(f.F_bar for f in forth))
    assert sum(f.repeated for f in back) > 0.3 * len(back) and sum(f.repeated for f in forth) > 0.3 * len(forth)


# Held load


@pytest.mark.parametrize("values", [{}, {"delta_bar": 0.2}, {"path": "loop"}, {"nu": 0.4999}, {"E": 20.0}])
def test_the_load_is_held_in_every_frame(values):
    """To 1e-8 of phi_n/delta_n, the largest pull times e: `top_compliance` makes the tolerance mean that."""
    scene = SMALL.changed(hold="load", **values)
    frames = list(load_path(scene))
    held = stage(frames, "approach")[-1].L_bar
    after = [f for f in frames if f.stage != "approach"]
    assert max(abs(f.L_bar - held) for f in after) * scene.E <= 1e-8 * scene.phi_n / scene.delta_n
    assert max(f.residual for f in frames) <= scene.tolerance
    assert np.ptp([f.delta for f in after]) > 1e-3 * scene.delta_n


@pytest.mark.parametrize("values", [{}, {"delta_bar": 0.3, "phi_ratio": 0.3}])
def test_sticking_at_a_held_load_equals_sticking_at_the_resulting_indentation(values):
    """One equilibrium, found twice: F, A, L equal those of a run at constant delta through the same (delta, U_x).

    A residual of 1e-9 nm, as contact magnifies it some hundred times towards the end of a branch.
    """
    scene = SMALL.changed(hold="load", tolerance=1e-9, **values)
    held = stage(list(load_path(scene)), "shear")
    stuck = next(i for i, f in enumerate(held) if f.slip)
    assert stuck > 8
    for frame in held[2:stuck:4]:
        other = scene.changed(hold="delta", delta_bar=frame.delta / scene.delta_0, u_x_max=frame.U_x + 1e-9)
        last = list(load_path(other))[-1]
        assert (last.U_x, last.delta) == pytest.approx((frame.U_x, frame.delta), abs=1e-9)
        assert last.F_bar == pytest.approx(frame.F_bar, rel=1e-6)
        assert last.L_bar == pytest.approx(frame.L_bar, abs=1e-6 * abs(held[0].L_bar))
        assert last.A_bar == pytest.approx(frame.A_bar, rel=1e-6)


def test_a_soft_machine_slips_earlier_under_tension():
    """What delta holds back, a held pull lifts: the branch ends before that at constant delta."""
    first = [next(e.load for f in load_path(SMALL.changed(hold=hold)) if f.stage == "shear" for e in f.slips)
             for hold in ("delta", "load")]  # fmt: skip
    assert first[1] < first[0] - 0.05


def test_gfmd_finds_the_same_states_at_held_load():
    scene = SMALL.changed(hold="load", u_x_max=5.0)
    fast, gfmd = list(load_path(scene)), list(load_path(scene, "gfmd"))
    assert any(f.slip for f in stage(fast, "shear"))
    assert all(same(a, b, 1e-6) and a.slip == b.slip for a, b in zip(fast, gfmd, strict=True))
    assert max(abs(a.delta - b.delta) for a, b in zip(fast, gfmd, strict=True)) < 1e-6


SADDLES = [
    {"delta_bar": -0.4, "u_x_max": 1.0},
    {"delta_bar": -0.28, "phi_ratio": 0.322, "E": 90.52, "nodes": 151, "width": 368.44, "window_t": 8, "u_x_max": 5},
    {"surface": "flat", "delta_bar": -0.24, "phi_ratio": 0.4356, "E": 241.6, "nodes": 64, "width": 128.0, "height": 5.0,
     "u_x_max": 5.0},
]  # fmt: skip


@pytest.mark.parametrize("values", SADDLES, ids=["default", "punch", "flat"])
def test_a_saddle_under_a_held_load_leads_to_the_same_equilibrium_with_and_without_shortcuts(values):
    """Round-off and shortcuts once decided which; the last two pulled off or not."""
    scene, ends = Scene(hold="load", **values), []
    for frames in (list(load_path(scene)), on_whole_cell(scene, replay=False)):
        assert len(stage(frames, "shear")) == scene.shear_increments + 1
        ends.append([(f.delta, f.F_bar * 1e3, f.L_bar * 1e3, f.A_bar) for f in stage(frames, "shear")])
    # a residual of 1e-8 nm, magnified where the contact is soft under a held load
    assert np.array(ends[0]) == pytest.approx(np.array(ends[1]), abs=1e-6)


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("values", SADDLES[:2], ids=["default", "punch"])
def test_frames_under_a_held_tension_are_in_equilibrium_with_it(values):
    """Under a massless top: the uniform normal mode has no stiffness."""
    scene = Scene(hold="load", **{"nodes": 128, "width": 312.5, **values})
    for frame in stage(load_path(scene), "shear")[::4]:
        assert growth(scene, frame, held=True) < 1e-6


@pytest.mark.parametrize(
    "values",
    [{"delta_bar": -0.5}, {"delta_bar": -0.4}, {"delta_bar": -0.6, "phi_ratio": 0.3}, {"delta_bar": -0.5, "E": 200.0}],
)
def test_a_jump_where_a_held_load_takes_over_is_an_event(values):
    """A saddle under the held load: delta jumps at U_x = 0, and CSV, JSON and the energy balance need the event."""
    before, after = list(load_path(Scene(hold="load", u_x_max=0.0, **values)))[-2:]
    assert (after.stage, after.U_x) == ("shear", 0.0) and abs(after.delta - before.delta) > 0.5
    (event,) = after.slips
    assert (event.stage, event.load, event.kind, event.located) == ("shear", 0.0, "control", True)
    # just before the jump: the last frame of the approach
    assert (event.F_bar, event.L_bar, event.A_bar) == pytest.approx((before.F_bar, before.L_bar, before.A_bar))


@pytest.mark.parametrize(
    "values", [{"E": 150.0, "delta_bar": -0.3}, {"delta_bar": -0.9}], ids=["hardly unstable", "far away"]
)
def test_a_surface_in_tension_falls_into_contact_at_every_damping(values):
    """A search for growing modes ended before it knew one, or the fall, of 1/growth, outlasted the motion's patience.

    Both motions come to rest in one equilibrium, to 1e-6 nm.
    """
    scene = Scene(hold="load", u_x_max=0.0, **values)
    (before, critical), (_, overdamped) = (list(load_path(scene.changed(damping=d)))[-2:] for d in (1.0, np.inf))
    assert before.A_bar == 0.0 and critical.A_bar > 0.04
    assert overdamped.delta == pytest.approx(critical.delta, abs=1e-6)


def test_flat_on_flat_at_held_load_keeps_the_gap_that_carries_it():
    """All nodes alike: T_z(u_x, gap) = p_0 gives the gap for every u_x, and U_z follows without deflection's change."""
    scene = SMALL.changed(surface="flat", phi_ratio=0.1, hold="load", delta_bar=0.05, u_x_max=30.0)
    shear = stage(list(load_path(scene)), "shear")
    p_0, compliance = shear[0].L_bar * scene.E, Modes.of(scene).compliance[1, 0]
    assert any(f.slip for f in shear)
    for frame in shear[::10]:
        ux, uz = frame.u[:, 0]
        assert traction(scene, ux, uz)[1] == pytest.approx(p_0, abs=1e-8 * scene.phi_n / scene.delta_n)
        assert -frame.delta + compliance * p_0 == pytest.approx(uz, abs=1e-7)


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("method", ["fast", "gfmd"])
def test_too_large_a_tension_detaches_the_contact_and_is_reported(method):
    scene = SMALL.changed(hold="load", delta_bar=-0.1)
    frames = []
    with pytest.raises(NotConverged) as caught:
        frames.extend(load_path(scene, method))
    assert "has pulled off at U_x = " in str(caught.value) and "led away from the surface" in str(caught.value)
    assert "under the held load L = -" in str(caught.value) and caught.value.outcome == "pulled off"
    checkpoint, frames = None, []
    while checkpoint is None or not checkpoint.done:
        more, checkpoint = advance(scene, checkpoint, method=method)
        frames += more
    assert checkpoint.failure == str(caught.value)
    assert any(f.stage == "shear" for f in frames) and all(f.residual <= scene.tolerance for f in frames)


def test_a_load_in_newton_per_metre_is_held():
    """It is the one that hold='load' holds at the indentation found."""
    small = Scene(nodes=64, width=160.0, radius=0.6, E=30.0, u_x_max=2.0, du_z=0.5)
    for load in (20.0, -5.0):
        result = simulate(small, load=load)
        shear = [frame.L for frame in result.frames if frame.stage == "shear"]
        assert shear == pytest.approx([load] * len(shear), rel=1e-6) and result.scene.hold == "load"
        assert result.scene == small.changed(hold="load", delta_bar=result.scene.delta_bar)


@pytest.mark.parametrize("load", [-1e4, 1e9, float("nan"), "heavy"])
def test_a_load_that_the_approach_does_not_reach_is_refused(load):
    small = Scene(nodes=16, width=40.0, radius=0.6, E=30.0, u_x_max=2.0, du_z=1.0, height=0.3)
    with pytest.raises(SceneError, match=r"load = .*: allowed: .* N/m, .*; give "):
        simulate(small, load=load)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"path": "points"}, "load = 10.0: allowed with path 'shear' or 'loop', not 'points'; choose one of these, or"),
        ({"path": "unload"}, "load = 10.0: allowed with path 'shear' or 'loop', not 'unload'; choose one of these, or"),
        ({"drive_n": 50.0}, "drive_n = 50.0: allowed with hold 'load'"),
    ],
)
def test_a_load_that_a_path_cannot_hold_is_refused_before_the_approach_is_computed(values, said, monkeypatch):
    monkeypatch.setattr("solver.run.held_load.Run", None)
    with pytest.raises(SceneError, match=said):
        simulate(SMALL.changed(**values), load=10.0)


def test_a_run_has_one_stepper_for_each_step_of_its_path():
    """Its transforms are planned once: to plan them for every increment takes as long as to compute it."""
    run, steppers = Run(SMALL), {}
    for frame, _ in run.frames():
        steppers.setdefault(frame.stage, set()).add(run.stepper)
    assert len(steppers) == 2 and all(len(used) == 1 for used in steppers.values())


def test_a_run_that_is_cancelled_goes_on_from_its_checkpoint_as_if_it_had_not_been():
    """Each increment is cancelled at its 150th force evaluation; one that long comes into contact."""
    scene = Scene(E=13.51, delta_bar=-0.331, phi_ratio=1.72, u_x_max=0.0)
    run, checkpoint, cancelled, frames = Run(scene), Checkpoint(), 0, []
    while not checkpoint.done:
        left = iter(range(150))

        def observe(*_, left=left):
            if next(left, None) is None:
                raise KeyboardInterrupt

        try:
            frame, after = run.next_frame(checkpoint, observe)
        except KeyboardInterrupt:
            cancelled += 1
            frame, after = run.next_frame(checkpoint)
        frames.append(frame)
        checkpoint = after
    exact = list(load_path(scene))
    assert cancelled and all(same(a, b, 1e-9) for a, b in zip(frames, exact, strict=True))


@pytest.mark.parametrize("load", [10.0, -20.0])
def test_a_held_load_is_found_by_one_solve_whatever_the_increment(load):
    """The approach to the indentation found reaches the load, also with so short an increment that it ends early."""
    for du_z in (0.5, 0.02):
        scene, *_ = held_at(SMALL.changed(du_z=du_z), load)
        approach = load_path(scene.changed(hold="delta", u_x_max=0.0))
        *_, last = (frame for frame in approach if frame.stage == "approach")
        assert pytest.approx(load, abs=1e-5) == last.L


@pytest.mark.parametrize("load", [10.0, -20.0])
def test_a_run_under_a_given_load_is_that_from_the_indentation_found(load):
    """Its approach is computed once, on the nodes that a deep approach would reach."""
    found = simulate(SMALL.changed(u_x_max=8.0), load=load)
    again = simulate(found.scene)
    assert len(found.frames) == len(again.frames) and found.frames[0].scene == found.scene
    assert all(same(a, b, 1e-6) for a, b in zip(found.frames, again.frames, strict=True))
    slips = ([slip.load for frame in run.frames for slip in frame.slips] for run in (found, again))
    assert next(slips) == pytest.approx(next(slips), abs=1e-5)
    ways = skeleton_from(found.scene, found.checkpoint), skeleton_of(again.scene)
    assert [s.load for s in ways[0].slips] == pytest.approx([s.load for s in ways[1].slips], abs=1e-5)


@pytest.mark.thorough
def test_a_held_load_of_the_shortest_increments_is_found():
    """The deepest approach would take a million of them."""
    scene = SMALL.changed(du_z=1e-3, E=300.0, nodes=32, width=80.0)
    assert held_at(scene, -1.0)[0].delta_bar < 1.0
