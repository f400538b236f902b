"""A drive with a stiffness: springs between the stage, which is moved, and the top of the layer."""

from math import inf

import numpy as np
import plain_gfmd
import pytest
from energy import balance_of
from recheck import recheck
from scipy.optimize import brentq
from spectrum import growth

from solver import Scene, SceneError, load_path, simulate
from solver.analysis.friction_laws import critical_modulus, friction, friction_force
from solver.analysis.partial import continuous
from solver.analysis.sensitivities import sensitivities
from solver.continuation.state import NotConverged, Restless
from solver.following.follow import follow
from solver.following.from_run import skeleton_of
from solver.measured.fit import fit
from solver.measured.measurement import Measurement
from solver.run.frame import slips_in
from solver.run.load_steps import load_steps_of
from solver.run.loadpath import with_remedy
from solver.run.summary import curves_of
from solver.text import number_from_text

FLAT = Scene(surface="flat", nodes=64, width=156.25, height=16.0, phi_ratio=0.1, damping=inf, tolerance=1e-11)
PUNCH = Scene(nodes=128, width=312.5, radius=1.0, height=2.0, u_x_max=40.0, du_z=0.5, tolerance=1e-11)


def sheared(scene):
    return [frame for frame in load_path(scene) if frame.stage == "shear"]


def up_to_slip(scene):
    """The frames in shear up to the first that slips."""
    frames = []
    for frame in load_path(scene):
        frames += [frame] * (frame.stage == "shear")
        if frame.stage == "shear" and frame.slips:
            return frames
    raise AssertionError("no slip")


class Driven:
    """Prandtl-Tomlinson: a node on springs of layer and drive in series, 1/k = h/G + 1/k_t."""

    def __init__(self, scene):
        self.scene, self.a = scene, scene.spacing
        self.layer = scene.height * scene.width / scene.shear_modulus
        self.both = self.layer + 1e3 / scene.drive_t
        self.u_fold = brentq(lambda u: self.stage(u + 1e-5) - self.stage(u - 1e-5), 0.0, self.a / 2, xtol=1e-14)
        self.fold = self.stage(self.u_fold)

    def pull(self, u):
        dt = (np.arange(-60, 61) * self.a - u) / self.scene.delta_t
        return -2.0 * self.scene.phi_t / self.scene.delta_t * np.sum(dt * np.exp(-(dt**2)))

    def stage(self, u):
        return u + self.pull(u) * self.both

    def rest(self, U_x, near):
        """u where the node rests on the branch that holds a guess `near`."""
        sites = np.floor((near + self.a / 2) / self.a)
        low, high = sites * self.a - self.a / 2, sites * self.a + self.u_fold
        return brentq(lambda u: self.stage(u) - U_x, low, high, xtol=1e-14)


@pytest.mark.parametrize("drive_t", [5.0, 40.0])
def test_driven_flat_is_prandtl_tomlinson_with_both_springs_in_series(drive_t):
    scene = FLAT.changed(drive_t=drive_t, u_x_max=60.0)
    node, frames = Driven(scene), sheared(scene)
    folds = [event.load for frame in frames for event in frame.slips]
    assert len(folds) >= 2
    # a slip may pass several sites: every end is the same fold, some sites on
    sites = np.round((np.array(folds) - node.fold) / scene.spacing)
    assert folds == pytest.approx(sites * scene.spacing + node.fold, abs=1e-5)
    for frame in frames:
        u = node.rest(frame.U_x, frame.u[0].mean())
        assert frame.F_bar * scene.E == pytest.approx(node.pull(u), rel=1e-8, abs=1e-12)
        assert frame.U_x_top == pytest.approx(u + node.pull(u) * node.layer, abs=1e-7)
    assert friction(scene).F_s == pytest.approx(max(event.F_bar for f in frames for event in f.slips), rel=1e-3)


def test_soft_drive_makes_a_smoothly_sliding_flat_stick_and_slip():
    smooth = FLAT.changed(phi_ratio=0.002)
    assert critical_modulus(smooth) < smooth.E
    assert not any(frame.slips for frame in sheared(smooth))
    driven = smooth.changed(drive_t=2.0)
    assert critical_modulus(driven) > driven.E
    frames = sheared(driven)
    assert any(frame.slips for frame in frames)
    assert friction(driven).F_k == pytest.approx(friction_force(driven, frames).F_k, abs=0.05 * friction(driven).F_s)


def test_driven_punch_follows_the_states_of_the_rigid_drive_to_where_the_stage_turns():
    """A softer drive ends the branch where dX = dU_x + dF/(w k_t) = 0, before the fold of the rigid one."""
    scene = PUNCH.changed(drive_t=8.0)
    (*soft, slipped), k = up_to_slip(scene), scene.width * 1e-3 * scene.drive_t
    fold = up_to_slip(PUNCH)[-1].slips[0].load

    def force(U_x):
        return sheared(PUNCH.changed(u_x_max=U_x, du_x=U_x / 10.0))[-1].F

    for frame in soft[5 :: len(soft) // 6]:
        assert abs(frame.F - force(frame.U_x_top)) < 1e-7 * soft[-1].F
    # towards its fold F is smooth in the root of the distance, s
    s = 0.02 + 0.48 * np.cos(np.linspace(0.0, np.pi / 2, 12)) ** 2
    stage = np.polynomial.Polynomial.fit(s, [fold - each**2 + force(fold - each**2) / k for each in s], 9)
    turns = [root.real for root in stage.deriv().roots() if abs(root.imag) < 1e-9 and s.min() < root.real < s.max()]
    assert len(turns) == 1 and slipped.slips[0].load == pytest.approx(float(stage(turns[0])), abs=1e-5)


def at_no_load(scene):
    def load(delta_bar):
        changed = scene.changed(delta_bar=delta_bar, u_x_max=0.0)
        return list(load_path(changed))[-1].L_bar

    return scene.changed(delta_bar=brentq(load, 0.0, 1.0, xtol=1e-12))


def test_normal_drive_leads_from_a_held_indentation_to_a_held_load():
    """At zero load the drive is relaxed, so that all of these begin in the same state."""
    scene = at_no_load(PUNCH.changed(u_x_max=4.0, du_x=0.5, tolerance=1e-8))
    stiff, held = sheared(scene)[-1], sheared(scene.changed(hold="load"))[-1]
    # without inertia, as a soft drive falls into contact from the height at which the run begins
    # a residual is a height of the top, whose round-off grows with the compliance; forces keep their digits
    drives = (1e6, 1e3, 100.0, 10.0, 1e-3, 1e-6)
    scenes = [scene.changed(drive_n=drive_n, damping=inf, tolerance=max(1e-8, 1e-11 / drive_n)) for drive_n in drives]
    driven = [sheared(each)[-1] for each in scenes]
    loads, heights = np.array([(frame.L_bar, frame.delta_top) for frame in (stiff, *driven)]).T
    # the softest drive's load, 7e-13, is less than the tolerance leaves of the load that is held, some 1e-11
    assert np.all(np.diff(loads) < 0.0) and loads[-2] > held.L_bar
    assert np.all(np.diff(heights[:-1]) < 0.0) and heights[-2] > held.delta
    sink = stiff.delta - held.delta
    assert heights[1] == pytest.approx(stiff.delta, abs=1e-3 * sink) and loads[1] == pytest.approx(loads[0], rel=1e-3)
    assert heights[-2] == pytest.approx(held.delta, abs=1e-5 * sink)
    assert heights[-1] == pytest.approx(held.delta, abs=3.0 * scenes[-1].tolerance)
    assert loads[-1] == pytest.approx(held.L_bar, abs=1e-5 * abs(stiff.L_bar))
    # what the tolerance leaves of the force of each of two states, 2e-11; BLAS kernels differ within that
    left = 2.0 * scene.tolerance / scene.delta_t * abs(held.F_bar)
    for soft in driven[-2:]:
        assert soft.F_bar == pytest.approx(held.F_bar, abs=1e-5 * abs(stiff.F_bar - held.F_bar) + left)


def test_strongly_damped_fall_under_a_soft_drive_rests_at_the_load_of_its_fold():
    """The slowest mode decays 8 times as slowly at damping 4: the motion takes long, but it comes to rest."""
    scene = PUNCH.changed(E=20.0, drive_n=20.0, u_x_max=0.0, tolerance=1e-7)
    plain, begin = list(plain_gfmd.run(scene)), list(load_path(scene.changed(damping=4.0)))
    frames = [frame for frame in begin if frame.slips]
    assert [event.kind for frame in frames for event in frame.slips] == ["fold"]
    assert not any(frame.sensitive for frame in frames)
    for frame, record in zip(begin, plain, strict=True):
        assert frame.index == record.index  # no load is passed over until the surface rests
        assert frame.L_bar == pytest.approx(record.L_bar, abs=1e-5 * abs(plain[-1].L_bar))


def test_driven_run_agrees_with_an_explicit_gfmd_with_springs():
    scene = PUNCH.changed(drive_t=20.0, drive_n=200.0, u_x_max=30.0, du_x=0.5, damping=4.0, tolerance=1e-7)
    frames, records = list(load_path(scene)), list(plain_gfmd.run(scene))
    assert len(frames) == len(records)
    F = [[f.F_bar, f.L_bar] for f in frames]
    plain = np.array([[r.F_bar, r.L_bar] for r in records])
    assert any(slips_in(f) for f in frames if f.stage == "shear")
    assert np.abs(F - plain).max() < 1e-5 * np.abs(plain).max()
    for frame in frames[::7]:
        assert recheck(scene, frame).residual < 2e-7
    assert np.abs(balance_of(frames).defect).max() < 1e-3 * np.abs(balance_of(frames).top).max()


def test_following_and_sensitivities_know_the_stiffness_of_the_drive():
    punch = PUNCH.changed(u_x_max=20.0, tolerance=1e-8)
    scene = punch.changed(drive_t=20.0)
    skeleton = skeleton_of(scene)
    other = scene.changed(drive_t=22.0)
    expected = skeleton_of(other)
    followed = follow(skeleton, other)
    assert [b.end for b in followed.branches] == pytest.approx([b.end for b in expected.branches], abs=1e-4)
    slope = sensitivities(skeleton).slips[0].by["drive_t"]
    ends = [skeleton_of(scene.changed(drive_t=20.0 + h)).branches[0].end for h in (-0.01, 0.01)]
    assert slope[0] == pytest.approx((ends[1] - ends[0]) / 0.02, rel=1e-4)
    assert "drive_t" not in continuous(PUNCH)
    rigid = follow(skeleton_of(scene.changed(drive_t=100.0)), scene.changed(drive_t=inf))
    assert rigid.branches[0].end == pytest.approx(skeleton_of(punch).branches[0].end, abs=1e-4)


def test_fit_finds_the_stiffness_of_the_drive_and_asks_for_a_number_first():
    scene = FLAT.changed(drive_t=20.0, tolerance=1e-8, u_x_max=30.0, damping=1.0)
    frames = sheared(scene)[:30]
    F = np.array([f.F_bar for f in frames])
    measured = Measurement(np.array([f.U_x for f in frames]), {"F_bar": F}, {"F_bar": 1e-3 * F.max()}, ())
    result = fit(scene.changed(drive_t=30.0), measured, ["drive_t"])
    assert result.values["drive_t"] == pytest.approx(20.0, rel=1e-3)
    with pytest.raises(ValueError, match="give drive_t a number first"):
        fit(scene.changed(drive_t=inf), measured, ["drive_t"])


def test_held_load_refuses_a_spring_that_would_not_act():
    with pytest.raises(SceneError, match="use drive_n=inf or hold=delta"):
        Scene(hold="load", drive_n=5.0)
    assert Scene(hold="load", drive_t=5.0).drive_t == 5.0
    assert Scene(drive_t="inf", damping="inf") == Scene(damping=inf)  # as JSON files have them
    with pytest.raises(SceneError, match=r"drive_t = 0.0: allowed: 1e-06 .. 1e\+06 or inf MPa/nm"):
        Scene(drive_t=0.0)
    assert number_from_text("drive_t", "2 GPa/nm") == 2000.0 and number_from_text("drive_n", "inf") == inf


def test_curves_have_columns_of_the_top_beside_those_of_the_stage():
    frames = list(load_path(PUNCH.changed(drive_t=8.0, u_x_max=2.0)))
    curves = curves_of(frames)
    assert curves["U_x_top (nm)"][-1] == frames[-1].U_x_top < frames[-1].U_x == curves["U_x (nm)"][-1]


def test_plot_draws_forces_over_the_top_on_request():
    result = simulate(PUNCH.changed(drive_t=8.0, u_x_max=2.0))
    table = result.table[result.table["stage"] == "shear"]
    for over_top, column in ((False, "U_x (nm)"), (True, "U_x_top (nm)")):
        forces = next(iter(result.plot(over_top)))
        assert next(iter(forces)).dimension_values(0) == pytest.approx(table[column])
    with pytest.raises(ValueError, match="plot over the stage"):
        simulate(PUNCH.changed(path="points", points="0,-1; 0,-0.9")).plot(over_top=True)


@pytest.mark.parametrize("soft", [{"drive_n": 5.0}, {"hold": "load"}])
def test_message_of_a_transient_without_rest_suggests_no_inertia_for_a_soft_drive_or_a_held_load(soft):
    driven = Scene(damping=4.0, **soft)
    message = _message(driven)
    assert "try damping=inf, another indentation" in message
    for scene in (Scene(damping=4.0), driven.changed(damping=inf)):
        assert "damping=inf" not in _message(scene)


def _message(scene):
    """That of a transient without rest in the last stage."""
    return str(with_remedy(Restless("it flutters"), scene, load_steps_of(scene)[-1], 0.0))


def test_a_wave_that_grows_under_a_soft_drive_is_found_before_a_frame_is_unstable():
    """The drive's mode is slower than any other, and says nothing of a wave that soon starts to grow."""
    scene = Scene(
        surface="wave", waves=2, amplitude=0.1677, law="xu-needleman", E=14680.0, nu=0.3, height=0.08668, nodes=40,
        width=107.84, phi_n=0.2403, phi_ratio=0.09033, delta_n=0.3224, delta_bar=0.25, drive_t=19.99, damping=0.7,
        u_x_max=0.0,
    )  # fmt: skip
    frames = list(load_path(scene))
    assert any(frame.slips for frame in frames)
    assert max(growth(scene, frame, False) for frame in frames if frame.T.any()) <= 1e-6


@pytest.mark.parametrize("damping", [0.5, 1.0])
def test_the_remedy_for_an_increment_that_does_not_converge_changes_no_physics(damping):
    """Nodes are the lattice, and damping matters to a motion that does not come to rest only."""
    scene = Scene(damping=damping)
    said = str(with_remedy(NotConverged("the residual is 1 nm"), scene, load_steps_of(scene)[0], 0.0))
    assert said.endswith("; try a larger tolerance, or a smaller du_x or du_z")
