"""Slips below critical damping, runs that carry on under changed parameters, and patches that are widened."""

import csv
import pickle
from itertools import islice, pairwise

import numpy as np
import pytest
from helpers import same, stage
from spectrum import growth

from solver import (
    Scene,
    SceneError,
    advance,
    carried_path,
    carry_on,
    load_path,
    summarize,
    work_of,
)
from solver.files import write_csv, write_npz
from solver.mechanics.contact import Contact
from solver.mechanics.equilibrium import Equilibrium
from solver.run import loadpath
from solver.run.load_steps import load_steps_of
from solver.run.loadpath import Run

SMALL = Scene(nodes=128, width=320.0, radius=1.0, du_z=0.2, du_x=0.2)


def late(scene):
    """The Frame before the last one of a run."""
    return list(load_path(scene))[-2]


def test_a_jump_of_the_parameters_is_not_reported_as_a_slip():
    """Flat: with a stiffness ten times less the state leaps at rest, though no branch of the new scene ends there."""
    scene = Scene(surface="flat", phi_ratio=0.1, E=700.0, u_x_max=2.0)
    frame, after = next(Run(scene.changed(E=70.0)).frames(carry_on(late(scene), scene.changed(E=70.0))))
    assert not frame.slips and frame.residual <= scene.tolerance and not after.carried


@pytest.mark.parametrize("hold", ["delta", "load"])
def test_continuing_from_the_end_of_approach_equals_continuing_from_the_start_of_shear(hold):
    scene = SMALL.changed(delta_bar=0.3, u_x_max=2.0, hold=hold)
    frames = list(load_path(scene))
    last = stage(frames, "approach")[-1]
    ends = []
    for start in (last, stage(frames, "shear")[0]):
        changed = scene.changed(E=1.1 * scene.E, delta_bar=0.4)
        *_, (end, _) = Run(changed).frames(carry_on(start, changed))
        ends.append((end.U_x, end.F_bar, end.L_bar, end.A_bar))
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)
    with pytest.raises(ValueError, match="in shear only"):
        carry_on(stage(frames, "approach")[-2], changed)


def test_only_the_fast_method_can_continue_a_run():
    scene = Scene(surface="flat", phi_ratio=0.1, u_x_max=2.0)
    changed = scene.changed(E=90.0)
    with pytest.raises(ValueError, match="allowed where a run carries on: fast"):
        next(Run(changed, "gfmd").frames(carry_on(late(scene), changed)))


def test_another_scale_of_the_law_leaves_a_held_load():
    """delta_bar counts in delta_n: the punch is not to be moved because its unit has changed."""
    scene = SMALL.changed(delta_bar=0.2, hold="load", u_x_max=2.0)
    changed = scene.changed(delta_n=1.1)
    checkpoint = carry_on(late(scene), changed)
    assert checkpoint.stage == "shear"


def test_a_wider_patch_under_a_held_load_keeps_the_surface_in_place():
    """The nodes that come in lie where the layer is, whose top is at U_z, not at zero."""
    scene = Scene(E=30.0, delta_bar=-0.7, hold="load", nodes=256, width=625.0, radius=10.0)
    step = load_steps_of(scene)[1]
    contact = Contact(scene, 100, 56)
    problem = Equilibrium(contact, step.loading, -1e-3)
    v = np.append(np.array([[0.0], [7.0]]) * np.ones(56), 7.0)
    wide = problem.wider()
    v, active = wide.adopted(problem, v, np.zeros(56, bool), 0.0)
    assert wide.nodes > 56 and not active.any()
    assert wide.surface(v)[1] == pytest.approx(7.0) and wide.top(v, 0.0)[1] == 7.0


# Damping


def sites(scene, method="fast"):
    """By how many sites the contact moves in each slip of the shear: the largest displacement of a node."""
    shear = stage(list(load_path(scene, method)), "shear")
    moved = [(b.u[0] - a.u[0]).max() for a, b in pairwise(shear) if b.slip]
    return [round(float(m) / scene.spacing) for m in moved]


@pytest.mark.thorough
@pytest.mark.slow
def test_inertia_carries_one_slip_over_two_sites():
    scene = Scene(u_x_max=16.5)
    assert sites(scene) == [1, 1, 1]
    assert sites(scene.changed(damping=0.25)) == [2, 2]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_slip_with_inertia_is_one_slip():
    """Started too close to the end of the branch, the motion would fall back, and slip at the next increment."""
    shear = stage(list(load_path(Scene(u_x_max=13.0, hold="load", damping=0.25))), "shear")
    slips = [f.slips for f in shear if f.slip]
    assert [len(s) for s in slips] == [1, 1] and sites(Scene(u_x_max=13.0, hold="load", damping=0.25)) == [1, 1]
    assert slips[1][0].load - slips[0][0].load == pytest.approx(Scene().spacing, abs=1e-6)


@pytest.mark.slow
def test_at_critical_damping_the_reference_method_slips_as_the_fast_one():
    scene = SMALL.changed(u_x_max=5.0)
    fast, gfmd = (list(load_path(scene.changed(damping=1.0), method)) for method in ("fast", "gfmd"))
    assert any(f.slip for f in stage(fast, "shear"))
    assert all(same(a, b, 1e-6) for a, b in zip(fast, gfmd, strict=True))


@pytest.mark.slow
def test_below_critical_damping_branches_are_the_same_and_only_slips_differ():
    scene = SMALL.changed(u_x_max=3.0)
    for a, b in zip(load_path(scene), load_path(scene.changed(damping=0.2)), strict=True):
        assert same(a, b, 1e-6)


@pytest.mark.thorough
@pytest.mark.slow
def test_too_little_damping_is_named_in_the_message_unless_every_frame_is_an_equilibrium():
    """NP1 has no potential: with hardly any damping it may feed an oscillation for ever; then no frame is made up."""
    scene = Scene(u_x_max=3.0, delta_bar=1.0, damping=0.2, nodes=128, width=312.5)
    frames, checkpoint = [], None
    while checkpoint is None or not checkpoint.done:
        more, checkpoint = advance(scene, checkpoint)
        frames += more
    assert checkpoint.failure is None or "try a damping larger than 0.2" in checkpoint.failure
    assert all(growth(scene, f) < 1e-6 for f in frames[::5] + frames[-5:])


# Carrying on


def until(scene, increments, name="shear"):
    """The Frames up to that many increments of a stage."""
    return [
        frame for frame, _ in loadpath.until(scene, lambda frame: (frame.stage, frame.index + 1) == (name, increments))
    ]


def rest_of(scene, checkpoint):
    frames = []
    while not checkpoint.done:
        more, checkpoint = advance(scene, pickle.loads(pickle.dumps(checkpoint)))
        frames += more
    assert checkpoint.failure is None
    return frames


@pytest.mark.parametrize("values", [{}, {"hold": "load"}, {"surface": "flat", "phi_ratio": 0.1}])
def test_continuing_without_a_change_equals_the_uninterrupted_run(values):
    scene = SMALL.changed(**values)
    for a, b in zip(carried_path([(scene, 60), (scene, None)]), load_path(scene), strict=True):
        assert np.array_equal(a.u, b.u) and a.slips == b.slips


@pytest.mark.parametrize("hold", ["delta", "load"])
@pytest.mark.parametrize("values", [{"E": 100.0}, {"E": 40.0}, {"phi_n": 2.5}, {"phi_ratio": 0.5}, {"nu": 0.3}])
def test_changed_parameters_take_effect_at_the_current_load(values, hold):
    scene = SMALL.changed(hold=hold)
    frames = until(scene, 12)
    changed = scene.changed(**values)
    ahead = rest_of(changed, carry_on(frames[-1], changed))
    U_x = [f.U_x for f in ahead]
    assert U_x == pytest.approx(np.arange(frames[-1].U_x, scene.u_x_max + 0.1, 0.2))
    assert max(f.residual for f in ahead) <= changed.tolerance
    if hold == "load":
        L = frames[-1].L_bar * scene.E
        assert np.array([f.L_bar * changed.E for f in ahead]) == pytest.approx(L, abs=2e-8 * scene.phi_n)


def test_changed_stiffness_leads_to_the_branch_of_a_run_with_it_from_the_start():
    """While stuck, equilibria do not depend on the way there."""
    scene = SMALL.changed(u_x_max=2.0)
    frames = until(scene, 6)
    changed = scene.changed(E=100.0)
    ahead = rest_of(changed, carry_on(frames[-1], changed))
    assert same(ahead[-1], list(load_path(changed))[-1], 1e-6)


@pytest.mark.parametrize("delta_bar", [0.13, -0.07])
def test_a_changed_indentation_is_approached_at_constant_displacement(delta_bar):
    scene = SMALL.changed(u_x_max=2.0)
    frames = until(scene, 6)
    changed = scene.changed(delta_bar=delta_bar)
    ahead = rest_of(changed, carry_on(frames[-1], changed))
    press, shear = stage(ahead, "press"), stage(ahead, "shear")
    assert {f.U_x for f in press} == {frames[-1].U_x} and shear[0].U_x == frames[-1].U_x
    assert np.abs(np.diff([f.delta for f in press])).max() <= scene.du_z * scene.delta_n + 1e-12
    assert {f.delta for f in shear} == {changed.delta} and press[0].delta == scene.delta
    assert same(shear[-1], list(load_path(changed))[-1], 1e-6)


def test_a_run_can_switch_between_held_indentation_and_held_load():
    scene = SMALL.changed(u_x_max=3.0)
    frames = until(scene, 6)
    soft = scene.changed(hold="load")
    ahead, checkpoint = advance(soft, carry_on(frames[-1], soft), budget=0.0)
    assert ahead[0].L_bar == pytest.approx(frames[-1].L_bar, rel=1e-7) and ahead[0].delta == pytest.approx(
        0.0, abs=1e-7
    )
    (last,), _ = advance(soft, checkpoint, budget=0.0)
    back = rest_of(scene, carry_on(last, scene))
    assert stage(back, "shear")[0].delta == scene.delta
    assert same(back[-1], list(load_path(scene))[-1], 1e-6)


@pytest.mark.parametrize(
    ("values", "name"), [({"nodes": 64}, "nodes"), ({"radius": 2.0}, "radius"), ({"surface": "flat"}, "surface")]
)
def test_another_surface_needs_a_run_of_its_own(values, name):
    frames = until(SMALL, 2)
    with pytest.raises(SceneError, match=f"{name} = .*start the run anew"):
        carry_on(frames[-1], SMALL.changed(**values))


def test_a_run_can_be_continued_in_shear_only_and_not_beyond_its_end():
    frames = until(SMALL, 2, "approach")
    with pytest.raises(ValueError, match="stage = 'approach'"):
        carry_on(frames[-1], SMALL.changed(E=80.0))
    frames = until(SMALL, 12)
    with pytest.raises(SceneError, match=r"u_x_max = 1\.0: allowed: 2\.2 nm or more"):
        carry_on(frames[-1], SMALL.changed(u_x_max=1.0))


def test_a_continued_run_is_determined_by_its_last_frame():
    """Nothing but the frame is needed, and it stays as it is: the run can go on from it again."""
    frame, changed = pickle.loads(pickle.dumps(until(SMALL, 6)[-1])), SMALL.changed(E=90.0)
    first, second = (rest_of(changed, carry_on(frame, changed)) for _ in range(2))
    assert all(np.array_equal(a.u, b.u) for a, b in zip(first, second, strict=True))


# What is said of a run that was carried on


@pytest.fixture(scope="module")
def stiffened():
    """(scene, changed, count, frames): a run that goes on with three times the stiffness; both parts slip."""
    scene = SMALL.changed(u_x_max=8.0)
    frames = list(load_path(scene))
    count = next(k for k, f in enumerate(frames) if f.slips and f.stage == "shear") + 3
    changed = scene.changed(E=3.0 * scene.E)
    return scene, changed, count, list(carried_path([(scene, count), (changed, None)]))


def pulled(frame):
    """(F, L) of a frame by the sums over its tractions, N/m: whatever the stiffness."""
    return -frame.T[0].sum() * SMALL.spacing, frame.T[1].sum() * SMALL.spacing


def test_a_continued_path_equals_the_path_made_step_by_step(stiffened):
    scene, changed, count, frames = stiffened
    own = list(islice(load_path(scene), count))
    own += rest_of(changed, carry_on(own[-1], changed))
    assert len(own) == len(frames) and all(np.array_equal(a.u, b.u) for a, b in zip(own, frames, strict=True))
    with pytest.raises(ValueError, match=r"legs: 999 increments; allowed: 1 \.\. "):
        list(carried_path([(SMALL.changed(u_x_max=0.4), 999), (SMALL.changed(u_x_max=0.4, E=80.0), None)]))


def test_every_frame_has_its_scene_and_the_force_of_its_tractions(stiffened):
    scene, changed, count, frames = stiffened
    assert [f.scene for f in frames] == [scene] * count + [changed] * (len(frames) - count)
    assert [(f.F, f.L) for f in frames] == [pytest.approx(pulled(f), rel=1e-9, abs=1e-12) for f in frames]


def test_summary_of_a_continued_run_names_the_modulus_of_its_forces(stiffened):
    scene, changed, count, frames = stiffened
    known = summarize(changed, frames)
    assert known["converged"]
    k, first = next((k, f) for k, f in enumerate(frames) if f.slips and f.stage == "shear")
    assert known["E_s"] == scene.E and k < count
    assert known["F_s"] * known["E_s"] * scene.width == pytest.approx(pulled(frames[k - 1])[0], rel=0.05)
    assert {event["E"] for event in known["events"] if event["stage"] == "shear"} == {scene.E, changed.E}
    assert known["changes"] == [
        {"increment": 0, "stage": "approach", "U_x": 0.0, "E": scene.E},
        {"increment": count, "stage": "shear", "U_x": frames[count].U_x, "E": changed.E},
    ]
    assert first.slips[0].F_bar * first.unit == pytest.approx(known["F_s"] * known["E_s"] * scene.width)
    cut = summarize(changed, frames[:-1])
    assert not cut["converged"] and not {"E_s", "changes"} & summarize(scene, frames[:count]).keys()


def test_files_hold_parameters_that_change_along_the_run(stiffened, tmp_path):
    scene, _, _, frames = stiffened
    write_csv(tmp_path / "csv", frames)
    write_npz(tmp_path / "npz", scene, frames)
    with open(tmp_path / "csv", newline="") as text:
        rows = list(csv.DictReader(text))
    assert list(rows[0])[-2:] == ["stage", "E"]
    F = [pulled(f)[0] for f in frames]
    assert [float(r["F_bar"]) * float(r["E"]) * scene.width for r in rows] == pytest.approx(F, rel=1e-9, abs=1e-12)
    with np.load(tmp_path / "npz") as data:
        after = [force for force, frame in zip(F, frames, strict=True) if frame.stage != "approach"]
        assert data["F_bar"] * data["E"] * scene.width == pytest.approx(after, rel=1e-9, abs=1e-12)


def test_work_of_the_top_is_continuous_across_a_change_of_stiffness(stiffened):
    changed, frames = stiffened[1], stiffened[3]
    F, U = np.array([(pulled(f)[0], f.U_x) for f in frames]).T
    expected = 0.5 * ((F[1:] + F[:-1]) * np.diff(U)).sum()
    start = work_of(changed, [f for f in frames if f.stage == "approach"]).top[-1]
    # increments with a slip are taken in parts
    assert work_of(changed, frames).top[-1] - start == pytest.approx(expected, rel=0.02)
