"""The cohesive law and its sum over the lattice."""

import numpy as np
import pytest

from solver import Scene
from solver.mechanics.cohesive_law import tangent, traction
from solver.mechanics.kernels import DEEPEST

SCENES = [
    Scene(),
    Scene(nodes=2500),
    Scene(nodes=2000, width=500.0),
    Scene(width=10240.0),
    Scene(delta_n=0.5, delta_t=2.0),
]


def direct_sum(ux, gap, scene):
    """Paper Eq. 2-4, spring by spring."""
    sites = scene.spacing * (np.arange(-400, 401) + np.round(ux / scene.spacing))
    dt = (sites - ux) / scene.delta_t
    dt, dn = dt[np.abs(dt) <= scene.window_t], gap / scene.delta_n
    spring = np.exp(-dn) * np.exp(-(dt**2))
    tx = np.sum(2.0 * scene.phi_t / scene.delta_t * dt * spring)
    tz = -np.sum(scene.phi_n / scene.delta_n * dn * spring)
    return tx, tz


@pytest.mark.parametrize("scene", SCENES)
def test_traction_is_the_sum_over_springs(scene):
    for ux in np.linspace(-20.0, 20.0, 41):
        for gap in (-3.0, 0.0, 0.7, 5.0):
            expected = direct_sum(ux, gap, scene)
            # the recurrence of Gaussians loses a few bits of the largest term, not more
            assert traction(scene, ux, gap) == pytest.approx(
                expected, rel=1e-12, abs=1e-13 * np.exp(-gap / scene.delta_n)
            )


@pytest.mark.parametrize("scene", SCENES)
def test_tangent_is_the_derivative_of_the_traction(scene):
    h = 1e-5
    for ux, gap in [(0.3, 0.2), (-0.9, 1.5), (0.7, -2.0), (0.06, 1.0)]:
        by_x = (np.array(traction(scene, ux + h, gap)) - traction(scene, ux - h, gap)) / (2 * h)
        by_z = (np.array(traction(scene, ux, gap + h)) - traction(scene, ux, gap - h)) / (2 * h)
        xx, xz, zx, zz = tangent(scene, ux, gap)
        scale = np.abs([xx, xz, zx, zz]).max()
        # central differences: h^2 of the third derivative, of the order of the tangent, and round-off of T over h;
        # the points are chosen so that no spring crosses the edge of the window between ux - h and ux + h
        assert np.array([[xx, xz], [zx, zz]]) == pytest.approx(np.column_stack([by_x, by_z]), abs=1e-8 * scale + 1e-9)


def test_the_law_has_no_potential():
    _, xz, zx, _ = tangent(Scene(), 0.4, 0.5)
    assert abs(xz - zx) > 0.1


def test_traction_repeats_with_the_lattice():
    scene = Scene()
    for k in (1, -3, 40):
        there = traction(scene, 0.37 + k * scene.spacing, 0.5)
        assert there == pytest.approx(traction(scene, 0.37, 0.5), rel=1e-11)


def test_repulsion_attraction_and_friction_have_the_right_signs():
    scene = Scene()
    assert traction(scene, 0.0, -0.1)[1] > 0 > traction(scene, 0.0, 0.1)[1]
    assert traction(scene, 0.2, 0.0)[0] < 0 < traction(scene, -0.2, 0.0)[0]  # pulled back to its site


@pytest.mark.parametrize(("spacing", "peak"), [(1.0, 1.15e-3), (1.5, 0.123), (2.0, 0.472), (2.5, 0.735), (3.0, 0.835)])
def test_springs_in_registry_add_up_to_the_periodic_series(spacing, peak):
    """4 pi^1.5 (phi_t delta_t/a^2) exp(-pi^2 delta_t^2/a^2) sin(2 pi x/a), and its harmonics."""
    scene = Scene(nodes=100, width=100 * spacing, phi_n=1.0)
    x = np.linspace(0.0, spacing, 2001)
    tx = np.array([traction(scene, xi, 0.0)[0] for xi in x])
    series = sum(
        4.0 * np.pi**1.5 * m / spacing**2 * np.exp(-((np.pi * m / spacing) ** 2)) * np.sin(2 * np.pi * m * x / spacing)
        for m in range(1, 8)
    )
    # the window cuts springs of exp(-25)
    assert tx == pytest.approx(-series, abs=2e-10)
    assert np.abs(tx).max() == pytest.approx(peak, rel=6e-3)


def test_absurd_overclosure_stays_finite():
    assert np.isfinite(traction(Scene(), 0.1, -1e6)).all()
    assert traction(Scene(), 0.0, DEEPEST)[1] > 1e20
