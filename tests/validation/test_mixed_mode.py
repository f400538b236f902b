"""Adhesion with shear against linear fracture mechanics; `python tests/validation/mixed_mode.py` adds the finest."""

from math import pi, sqrt

import mixed_mode
import numpy as np
import pytest
from bonded_strip import Strip

from solver import Profile, Scene, simulate
from solver.analysis.toughness import release_rates, toughness

WIDE = Strip(E_star=10.0, nu=0.5, width=1e6, radius=2e4)  # a period in which a strip of 500 nm is alone


@pytest.mark.parametrize("case", mixed_mode.MAIN)
def test_contact_under_load_and_shear_has_the_width_of_fracture_mechanics(case):
    assert [(form.name, form.error, form.tolerance) for form in case() if not form.held] == []


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("case", mixed_mode.CASES[len(mixed_mode.MAIN) :])
def test_every_case_of_mixed_mode_holds_within_its_tolerance(case):
    assert [(form.name, form.error, form.tolerance) for form in case() if not form.held] == []


@pytest.mark.thorough
@pytest.mark.slow
def test_comparison_notices_every_mutation_it_claims_to():
    assert [row for row in mixed_mode.mutations() if row["noticed"] != row["expected"]] == []


def test_theory_without_adhesion_is_hertz():
    a = 500.0
    P = pi * WIDE.E_star * a**2 / (4.0 * WIDE.radius)
    assert WIDE.rates(a, 0.0, P, 0.0) == pytest.approx([0.0, 0.0], abs=1e-9)
    x = np.linspace(-0.99, 0.99, 7) * a
    hertz = WIDE.E_star / (2.0 * WIDE.radius) * np.sqrt(a**2 - x**2)
    assert WIDE.traction(x, a, 0.0, P, 0.0).real == pytest.approx(hertz, rel=1e-4)


@pytest.mark.parametrize("F", [0.0, 120.0])
def test_theory_is_that_of_savkoor_and_briggs_in_plane_strain(F):
    """(H - P)^2 + F^2 = 2 pi E* a G, JKR for F = 0."""
    a, P = 700.0, 50.0
    H = pi * WIDE.E_star * a**2 / (4.0 * WIDE.radius)
    assert WIDE.rates(a, 0.0, P, F) == pytest.approx(((H - P) ** 2 + F**2) / (2.0 * pi * WIDE.E_star * a), rel=1e-5)


@pytest.mark.parametrize("nu", [0.4, 0.0])
def test_theory_of_a_compressible_strip_is_that_of_a_half_plane(nu):
    """Closed form of Muskhelishvili's solution for a parabola; a wave of so long a period is one to 1e-3."""
    strip, a, s, P, F = Strip(10.0, nu, 1e6, 2e4), 700.0, 30.0, 50.0, 80.0
    H, S, eta = pi * 10.0 * a**2 / 8e4, pi * 10.0 * a * s / 4e4, strip.eta
    for side, rate in zip((-1.0, 1.0), strip.rates(a, s, P, F), strict=True):
        brackets = H * (1.0 - 4.0 * eta**2) + side * S - P, F - side * 4.0 * eta * H - 2.0 * eta * S
        assert rate == pytest.approx(sum(b * b for b in brackets) / (2.0 * pi * 10.0 * a), rel=3e-3)


@pytest.mark.parametrize("nu", [0.5, 0.3, 0.0])
def test_energy_release_rate_is_the_derivative_of_the_potential_energy(nu):
    """A dense strip of nodes on a half-plane, whose edge moves by a node either way."""
    strip, nodes, P, F = Strip(10.0, nu, 4000.0, 2e4), 800, 30.0, 60.0
    h, half, at = strip.width / nodes, 120, 4
    exact = strip.rates((half + 0.5) * h, at * h, P, F)
    inner = potential(strip, nodes, at - half, at + half, P, F)
    left = (potential(strip, nodes, at - half - 1, at + half, P, F) - inner) / h
    right = (potential(strip, nodes, at - half, at + half + 1, P, F) - inner) / h
    moved = [strip.rates((half + 1.0) * h, (at + side) * h, P, F)[k] for k, side in enumerate((-0.5, 0.5))]
    between = 0.5 * (exact[0] + moved[0]), 0.5 * (exact[1] + moved[1])  # rates over the node by which the edge moves
    assert (left, right) == pytest.approx(between, rel=0.01)


def potential(strip, nodes, first, last, P, F):
    """Potential energy per depth, nN, of a strip bonded at the nodes first .. last (0: the crest) under P and F."""
    h = strip.width / nodes
    q = 2.0 * pi * np.fft.fftfreq(nodes, h)
    with np.errstate(divide="ignore"):
        normal = np.where(q == 0.0, 0.0, 2.0 / (strip.E_star * np.abs(q)))
    coupled = strip.b * normal * np.sign(q) * (np.abs(q) < pi / h * 0.999)
    direct, cross = np.fft.ifft(normal).real, np.fft.ifft(1j * coupled).real
    at = np.arange(first, last + 1)
    m, apart = at.size, at[:, None] - at
    C = np.block([[direct[apart], cross[apart]], [-cross[apart], direct[apart]]])  # rows and columns: x, z
    rigid = np.kron(np.eye(2), np.ones((m, 1)))
    amplitude = strip.width**2 / (4.0 * pi**2 * strip.radius)
    gap = amplitude * (1.0 - np.cos(2.0 * pi * at * h / strip.width))
    A = np.block([[C, rigid], [rigid.T, np.zeros((2, 2))]])
    solution = np.linalg.solve(A, np.concatenate((np.zeros(m), -gap, [-F / h, P / h])))
    T, (d_x, d_z) = solution[:-2], solution[-2:]
    return 0.5 * h * float(T @ (C @ T)) + P * d_z - F * d_x


def test_toughness_of_a_potential_is_its_work_of_separation_at_every_angle():
    scene = Scene(law="xu-needleman", phi_ratio=1.0, phi_n=3.0)
    assert toughness(scene, [0.0, 0.5, -1.2]).tolist() == [3.0, 3.0, 3.0]


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 75.0])
def test_integrated_crack_tip_agrees_with_the_closed_form_of_a_ray(angle):
    """Just beside c = 1 the crack tip is integrated, to 1e-3."""
    delta_t = sqrt(2.0)
    ray = toughness(Scene(delta_t=delta_t, phi_n=1.0), np.radians(angle))
    tip = toughness(Scene(delta_t=delta_t * (1.0 + 1e-6), phi_n=1.0), np.radians(angle))
    assert tip == pytest.approx(float(ray), abs=2e-3)


# Gamma/phi_n from another program: panels that are graded otherwise, K from the balance at the tip
TIPS = {
    (1.0, 2.33): (1.0, 0.926, 0.806, 0.733, 0.727, 0.802),
    (2.0, 2.33): (1.0, 0.979, 0.957, 0.985, 1.107, 1.387),
    (5.0, 2.33): (1.0, 1.022, 1.109, 1.311, 1.734, 2.655),
    (1.0, 1.0): (1.0, 0.879, 0.736, 0.668, 0.674, 0.766),
}


@pytest.mark.parametrize(("ratio", "delta_t"), TIPS)
def test_toughness_over_the_mode_angle_agrees_with_another_program(ratio, delta_t):
    found = toughness(Scene(phi_n=1.0, phi_ratio=ratio, delta_t=delta_t), np.radians([0, 15, 30, 45, 60, 75]))
    assert found == pytest.approx(TIPS[ratio, delta_t], abs=4e-3)


# Gamma/phi_n at an angle of 0.1, of 400 cells; shear lengthens the zone of these, and opening does not
LONG = {(0.001, 1.0): 0.0885, (0.01, 1.0): 0.4498, (0.01, 3.0): 0.4839, (0.05, 5.0): 0.8228, (1.0, 20.0): 0.9984}


@pytest.mark.parametrize(("ratio", "delta_t"), LONG)
def test_opening_alone_costs_the_work_of_separation_however_weak_the_shear(ratio, delta_t):
    """The error is that of 120 cells."""
    found = toughness(Scene(phi_n=1.0, phi_ratio=ratio, delta_t=delta_t), [0.0, 0.1])
    assert found == pytest.approx([1.0, LONG[ratio, delta_t]], abs=2e-3)


def test_toughness_names_what_it_cannot_answer():
    with pytest.raises(ValueError, match=r"psi = 1\.4 rad; allowed: up to 1\.396 either way"):
        toughness(Scene(), 1.4)
    assert toughness(Scene(), 1.396) > 0.0
    with pytest.raises(ValueError, match="phi_ratio = 0"):
        toughness(Scene(phi_ratio=0.0), 0.1)


def test_release_rates_need_one_contact():
    frame = simulate(Scene(nodes=64, width=160.0, surface="flat", u_x_max=0.0)).frames[-1]
    with pytest.raises(ValueError, match="one part in contact"):
        release_rates(frame)


@pytest.mark.parametrize("shift", [0, 20, 128])
def test_release_rates_of_a_contact_do_not_depend_on_where_it_lies_in_the_cell(shift):
    """Across the ends of the cell, or within; 256 puts it in the middle."""
    height = 20.0 * np.cos(2.0 * pi * np.arange(512) / 512)

    def rates(shift):
        measured = Profile(500.0, np.roll(height, shift))
        scene = Scene(surface="measured", measured=measured, width=500.0, nodes=256, delta_bar=0.1, u_x_max=1.0)
        return np.array(release_rates(simulate(scene.changed(du_x=0.25, du_z=0.5)).frames[-1]))

    central, moved = rates(256), rates(shift)
    assert central[:, 1] == pytest.approx(2.0, rel=0.05)  # phi_n, as shear has hardly begun
    assert central[:, 0].mean() == pytest.approx(0.0, abs=0.5)  # x of both edges, from the middle of the cell
    assert moved[:, 1:] == pytest.approx(central[:, 1:], rel=1e-4)
    assert (moved[:, 0] - central[:, 0]) % 500.0 == pytest.approx((shift - 256) / 512 * 500.0 % 500.0, abs=1e-3)


def test_edges_of_a_punch_rise_in_mode_angle_while_it_is_sheared():
    """The rates follow the toughness; the cohesive zone of this punch is not small, so that they lie 15 % off."""
    result = simulate(Scene(delta_bar=0.4, u_x_max=8.0, du_x=0.5))
    edges = result.edges
    assert len(edges) == sum(frame.stage == "shear" for frame in result.frames)
    for side in ("trailing", "leading"):
        angle = edges[f"psi_{side} (rad)"]
        assert angle[2:].is_monotonic_increasing  # before, the pressing itself shears both edges, in opposite ways
        gamma = toughness(result.scene, angle)
        assert edges[f"J_{side} (N/m)"].to_numpy() == pytest.approx(gamma, rel=0.15)
    assert (edges["x_trailing (nm)"] < 0.0).all() and (edges["x_leading (nm)"] > 0.0).all()
