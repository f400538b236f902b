"""Fits on data whose answer is known, the flat interface's closed forms, and the onset of sliding."""

import pickle
from math import inf

import numpy as np
import pytest
from scipy.stats import linregress

from solver import Scene, SceneError, load_path, summarize
from solver.analysis.area_laws import quadratic_law, threshold_law
from solver.analysis.friction_laws import (
    INDENTATIONS,
    INTERFACES,
    critical_modulus,
    friction,
    friction_force,
    onset,
    reach,
    softening,
    tau_max,
)
from solver.mechanics import cohesive_law
from solver.presets import preset

FLAT = Scene(surface="flat", phi_ratio=0.1, damping=inf)
SMALL = Scene(nodes=64, width=160.0, radius=0.5, du_z=0.5, du_x=0.5)


def test_quadratic_law_is_recovered_from_points_on_it():
    F = np.linspace(0.0, 1.2e-3, 40)
    law = quadratic_law(F, 0.1 - 2e4 * F**2)
    assert (law.A_0, law.zeta, law.points) == (0.1, pytest.approx(2e4, rel=1e-12), 40)
    assert law.r2 == pytest.approx(1.0, abs=1e-12)
    assert max(law.worst, abs(law.last), law.zeta_error / law.zeta) < 1e-12
    assert law.rise == pytest.approx(1.0, abs=0.01)  # read off between points, linearly


def test_quadratic_law_reports_a_rising_rate():
    """A = A_0 - c F^4: the rate in F^2 grows in proportion, 1.9 in the last tenth to 0.5 in the first half."""
    F = np.linspace(0.0, 1.0, 400)
    law = quadratic_law(F, 1.0 - 0.5 * F**4)
    assert law.rise == pytest.approx(3.8, rel=0.01)
    assert law.last < -0.05 and law.worst >= -law.last
    assert law.r2 < 0.97


def test_standard_error_of_zeta_is_its_scatter():
    """Over 500 draws of noise; the scatter of a scatter is 1 / sqrt(2 * 500) = 3 %, five times that is allowed.

    A_0 is the first point, which is kept free of noise, as the law takes it for exact.
    """
    rng, F = np.random.default_rng(4), np.linspace(0.0, 1.0, 60)
    noise = 1e-3 * rng.normal(size=(500, F.size))
    noise[:, 0] = 0.0
    fits = [quadratic_law(F, 1.0 - 0.3 * F**2 + n) for n in noise]
    assert np.mean([fit.zeta_error for fit in fits]) == pytest.approx(np.std([fit.zeta for fit in fits]), rel=0.15)


def test_quadratic_law_ends_where_contact_ends():
    F = np.linspace(0.0, 1.0, 50)
    A = np.maximum(0.0, 0.5 - F**2)
    assert quadratic_law(F, A) == quadratic_law(F[A > 0], A[A > 0])


@pytest.mark.parametrize(("F", "A"), [([0, 1, 2], [1, 1, 1]), ([0] * 9, [1] * 9), (range(9), [0] * 9)])
def test_quadratic_law_with_too_few_points_is_rejected(F, A):
    with pytest.raises(ValueError, match="points in contact"):
        quadratic_law(F, A)


@pytest.mark.parametrize(
    ("F", "A", "message"),
    [
        (range(6), [1.0] * 6, "all areas A = 1"),
        (range(6), [0.0, 0.9, 0.8, 0.7, 0.6, 0.5], r"A\[0\] = 0"),
        ([0, 1, np.nan, 3, 4, 5], [1.0, 0.9, 0.8, 0.7, 0.6, 0.5], r"F\[2\] = nan"),
        (range(6), [1.0, 0.9, 0.8, np.inf, 0.6, 0.5], r"A\[3\] = inf"),
        (range(6), [1.0, 1.0, 1.0, 1.0, 1.0, 0.5], "no early rate; give"),
        (range(6), [1.0] * 7, "two arrays of one length"),
    ],
)
def test_quadratic_law_of_degenerate_data_is_refused_by_name(F, A, message):
    with pytest.raises(ValueError, match=message):
        quadratic_law(F, A)


@pytest.mark.parametrize(
    ("A", "F", "message"),
    [
        ([0.1, 0.2, 0.3], [1.0] * 3, "all forces F_s = 1"),
        ([0.1] * 3, [1.0, 2.0, 3.0], "of different area"),
        ([0.1, np.nan, 0.3], [1.0, 2.0, 3.0], r"A_s\[1\] = nan"),
    ],
)
def test_threshold_law_of_degenerate_data_is_refused_by_name(A, F, message):
    with pytest.raises(ValueError, match=message):
        threshold_law(A, F)


def test_threshold_law_agrees_with_linear_regression():
    rng = np.random.default_rng(5)
    A = rng.uniform(0.03, 0.2, 12)
    F = 4e-3 * A + 8e-4 + 1e-5 * rng.normal(size=12)
    law, expected = threshold_law(A, F), linregress(A, F)
    assert (law.tau_c, law.F_nc) == pytest.approx((expected.slope, expected.intercept), rel=1e-12)
    assert (law.tau_c_error, law.F_nc_error) == pytest.approx((expected.stderr, expected.intercept_stderr), rel=1e-10)
    assert law.r2 == pytest.approx(expected.rvalue**2, rel=1e-12)


def test_threshold_law_leaves_out_points_without_contact():
    A, F = np.array([0.0, 0.0, 0.05, 0.1, 0.2]), np.array([1e-4, 9e-4, 1e-3, 1.2e-3, 1.6e-3])
    law = threshold_law(A, F)
    assert (law.tau_c, law.F_nc, law.points) == (pytest.approx(4e-3), pytest.approx(8e-4), 3)
    with pytest.raises(ValueError, match="2 points in contact"):
        threshold_law(A[:4], F[:4])


def test_strength_is_the_peak_of_one_spring():
    """Eq. 5 against the law itself, on a lattice so wide that a node feels one spring only."""
    scene = Scene(nodes=100, width=2000.0, phi_ratio=0.3, delta_t=1.2)
    peak = -cohesive_law.traction(scene, np.linspace(0.0, 3.0, 30001), 0.0)[0].min()
    assert peak == pytest.approx(tau_max(scene), rel=1e-8)  # a grid of 1e-4 nm at a level maximum


@pytest.mark.parametrize(("nodes", "delta_t"), [(1024, 1.0), (2500, 1.0), (625, 1.0), (1024, 0.5), (1024, 1.9)])
def test_softening_is_the_largest_tangent_of_the_window_sum(nodes, delta_t):
    scene = Scene(surface="flat", nodes=nodes, delta_t=delta_t, window_t=8.0)
    slope = cohesive_law.tangent(scene, np.linspace(0.0, scene.spacing, 4001), 0.0)[0].max()
    # both grids miss the maximum by up to half a point; at a = delta_t the window sum cancels to 1e-3 of its terms
    assert softening(scene) == pytest.approx(slope, rel=1e-6, abs=1e-11 * scene.phi_t / delta_t**2)


@pytest.mark.parametrize(("ratio", "peak"), [(1.0, 1.15e-3), (1.5, 0.123), (2.0, 0.472), (2.5, 0.735), (3.0, 0.835)])
def test_flat_peak_traction_depends_on_the_node_spacing(ratio, peak):
    scene = Scene(surface="flat", nodes=100, width=100 * ratio, phi_n=1.0)
    assert friction(scene).F_s * scene.E == pytest.approx(peak, rel=5e-3)  # three digits are given


def test_coarse_lattices_soften_less_than_they_stiffen():
    """Beyond a = 2 delta_t, dT/dx is steeper in registry, where T holds, than where it lets go: the latter decides."""
    single = Scene(surface="flat", nodes=100, width=1000.0)
    assert softening(single) / single.phi_t == pytest.approx(4.0 * np.exp(-1.5), rel=1e-6)  # of one spring
    assert -cohesive_law.tangent(single, 0.0, 0.0)[0] / single.phi_t == pytest.approx(2.0)


def test_critical_modulus_is_proportional_to_the_work_and_to_the_height():
    assert critical_modulus(FLAT) == pytest.approx(2588.4, rel=1e-4)
    assert critical_modulus(FLAT.changed(phi_ratio=0.05)) == pytest.approx(0.5 * critical_modulus(FLAT))
    assert critical_modulus(FLAT.changed(height=0.2)) == pytest.approx(0.2 * critical_modulus(FLAT))


@pytest.mark.once(2)
@pytest.mark.slow
@pytest.mark.parametrize("E", [70.0, 3000.0, 140.0, 1000.0, 2200.0])
def test_exact_friction_is_that_of_a_run(E):
    scene = FLAT.changed(E=E, du_x=0.01, u_x_max=20.0)
    exact, run = friction(scene), friction_force(scene, list(load_path(scene)))
    # the run meets extremes, and the ends of slips, within an increment of 0.01 nm
    assert (run.F_s, run.F_k) == pytest.approx((exact.F_s, exact.F_k), abs=2e-3 * exact.F_s)
    assert run.mean == pytest.approx(exact.mean, abs=2e-3 * exact.F_s)


def test_exact_friction_where_the_lattice_is_coarse():
    """At a = 6 delta_t a node comes to rest between the sites as well: two slips per period."""
    scene = Scene(surface="flat", nodes=100, width=600.0, phi_ratio=0.1, E=20.0, du_x=0.01, u_x_max=30.0, damping=inf)
    frames = list(load_path(scene))
    exact, run = friction(scene), friction_force(scene, frames)
    assert (run.F_s, run.F_k) == pytest.approx((exact.F_s, exact.F_k), abs=2e-3 * exact.F_s)


def test_friction_over_the_modulus_asked_for():
    own, paper = friction(FLAT.changed(E=140.0)), friction(FLAT.changed(E=140.0), reference=70.0)
    assert (paper.F_s, paper.F_k) == pytest.approx((2 * own.F_s, 2 * own.F_k))


def test_friction_of_a_contact_that_has_not_slid_is_refused():
    for scene in (FLAT.changed(u_x_max=5.0), FLAT.changed(E=3000.0, u_x_max=1.0)):
        with pytest.raises(ValueError, match=r"has not slid by U_x = [15] nm: enlarge u_x_max"):
            friction_force(scene, list(load_path(scene)))


@pytest.mark.once
@pytest.mark.parametrize("values", [{"phi_ratio": 0.001, "u_x_max": 2.7}, {"phi_ratio": 0.1, "u_x_max": 16.5}])
def test_friction_needs_a_whole_lattice_period_of_sliding(values):
    scene = Scene(surface="flat", damping=inf, **values)
    with pytest.raises(ValueError, match=r"less than a lattice period .* enlarge u_x_max to (\S+) nm") as refused:
        friction_force(scene, list(load_path(scene)))
    longer = scene.changed(u_x_max=float(refused.value.args[0].split()[-2]))
    exact, run = friction(longer), friction_force(longer, list(load_path(longer)))
    # increments of 0.1 nm miss a smooth extreme, and the end of a slip, by a few per cent
    assert (run.F_s, run.F_k) == pytest.approx((exact.F_s, exact.F_k), abs=0.05 * exact.F_s)


@pytest.mark.parametrize(("values", "name"), [({"surface": "circular"}, "surface"), ({"delta_bar": 0.1}, "delta_bar")])
def test_closed_forms_of_the_flat_are_refused_elsewhere(values, name):
    for form in (critical_modulus, friction):
        with pytest.raises(SceneError, match=f"{name} = .*: allowed: .*; run the scene"):
            form(FLAT.changed(**values))


def test_onset_is_the_run_up_to_its_first_slip():
    scene = SMALL.changed(u_x_max=12.0)
    frames = [f for f in load_path(scene) if f.stage == "shear"]
    k, whole, found = next(i for i, f in enumerate(frames) if f.slip), summarize(frames), onset(scene)
    units = {"U_s": 1.0, "F_s": scene.width * scene.E, "A_s": scene.width, "A_0": scene.width}
    assert all(getattr(found, name) * unit == whole[name] for name, unit in units.items())
    assert found.F.tolist() == [f.F_bar for f in frames[:k]] + [found.F_s]
    assert (found.U[0], found.U[-1], found.A[0], found.A[-1]) == (0.0, found.U_s, found.A_0, found.A_s)
    assert found.L.size == found.U.size


def test_onset_does_not_depend_on_where_the_scene_ends():
    assert onset(SMALL.changed(u_x_max=0.0)).U_s == onset(SMALL.changed(u_x_max=100.0)).U_s


@pytest.mark.parametrize("values", [{"delta_bar": 0.5}, {"delta_bar": 1.0}])
def test_onset_under_pressure_is_found_where_springs_are_stronger_than_at_no_gap(values):
    scene = Scene(surface="flat", nodes=16, width=40.0, u_x_max=5.0, du_x=0.5, **values)
    found = onset(scene)
    assert found.U_s == onset(scene.changed(u_x_max=1000.0)).U_s
    assert found.U_s > reach(scene)


def test_onset_under_a_held_load_in_tension_is_the_slip_after_the_jump_where_the_load_takes_over():
    scene = SMALL.changed(hold="load", delta_bar=-0.4, u_x_max=6.0)
    frames = list(load_path(scene))
    assert [event.kind for frame in frames for event in frame.slips] == ["control", "fold", "fold"]
    assert onset(scene).U_s == summarize(frames)["U_s"] > 0.0


def test_onset_without_a_slip_is_none():
    found = onset(SMALL.changed(phi_ratio=0.0, u_x_max=0.0))
    assert found.U_s is found.F_s is found.A_s is None
    assert found.U[-1] <= reach(SMALL.changed(phi_ratio=0.0)) < found.U[-1] + 0.5


def test_onset_of_a_layer_too_soft_for_its_reach_is_searched_as_far_as_the_tolerance_allows():
    """Round-off of a longer run would exceed the tolerance."""
    scene = SMALL.changed(E=0.5, phi_ratio=100.0, u_x_max=1.0, nodes=8, width=20.0, delta_bar=-1.0, tolerance=1e-9)
    with pytest.raises(SceneError):
        scene.changed(u_x_max=reach(scene))
    found = onset(scene)
    assert found.U_s is None and scene.u_x_max < found.U[-1] < reach(scene)


def test_onset_is_small_enough_to_send_between_processes():
    found = onset(SMALL)
    assert len(pickle.dumps(found)) < 10_000
    assert pickle.loads(pickle.dumps(found)).U.tolist() == found.U.tolist()


def test_figure_8_is_nine_loads_on_three_interfaces():
    assert len({*INTERFACES}) == 3 and len({*INDENTATIONS}) == 9
    assert min(INDENTATIONS) == -0.3 and max(INDENTATIONS) == 0.6
    strengths = {name: (preset(name).scene.phi_n, preset(name).scene.phi_ratio) for name in INTERFACES}
    assert strengths == {"fig8-black": (2.0, 1.0), "fig8-red": (1.0, 1.0), "fig8-blue": (2.0, 0.1)}
