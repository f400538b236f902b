"""The layer's Green's function and the products with it."""

import mpmath
import numpy as np
import pytest

from solver import Scene
from solver.mechanics.layer import Convolution, Modes, compliance, stiffness

Q = np.concatenate(([0.0], np.geomspace(1e-6, 10.0, 60)))


def reference(q, height, E, nu):
    """K_xx, K_zz, K_c in 60 digits."""
    with mpmath.workdps(60):
        q, h, E, nu = (mpmath.mpf(float(v)) for v in (q, height, E, nu))
        G, kappa, y = E / (2 * (1 + nu)), 3 - 4 * nu, q * h
        s, c = mpmath.sinh(y), mpmath.cosh(y)
        d = kappa**2 * s**2 - y**2
        k_xx = 4 * G * (1 - nu) * q * (kappa * s * c - y) / d
        k_zz = 4 * G * (1 - nu) * q * (kappa * s * c + y) / d
        return k_xx, k_zz, 2 * G * q * (kappa * (1 - 2 * nu) * s**2 - y**2) / d


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.4999])
@pytest.mark.parametrize("height", [1.0, 25.0, 2500.0, 1e5])
def test_stiffness_agrees_with_sixty_digits(nu, height):
    computed = stiffness(Q, height, 70.0, nu)
    for i, q in enumerate(Q[1:], start=1):
        exact = reference(q, height, 70.0, nu)
        for k, value in zip(computed, exact, strict=True):
            # K_c passes through zero: its error is measured against the other two
            assert abs(k[i] - float(value)) <= 1e-14 * max(abs(float(value)), float(exact[0]))


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.4999])
@pytest.mark.parametrize("height", [1.0, 25.0, 2500.0, 1e5])
def test_stiffness_times_compliance_is_the_identity(nu, height):
    k, c = stiffness(Q, height, 70.0, nu), compliance(Q, height, 70.0, nu)
    xx, xz = k[0] * c[0] - k[2] * c[2], k[0] * c[2] - k[2] * c[1]
    zx, zz = k[2] * c[0] - k[1] * c[2], k[1] * c[1] - k[2] * c[2]
    # at nu = 0.4999 the two stiffnesses of long waves in a thin layer differ by 10^4
    assert np.abs(np.array([xx - 1, zz - 1])).max() < 1e-13
    assert np.abs(np.array([xz * k[1] / k[0], zx * k[0] / k[1]])).max() < 1e-10


def test_short_waves_see_a_half_plane():
    E, nu, q = 70.0, 0.3, np.array([1.0])
    G = E / (2 * (1 + nu))
    k_xx, k_zz, k_c = stiffness(q, 1e6, E, nu)
    assert k_xx == pytest.approx(4 * G * (1 - nu) / (3 - 4 * nu), rel=1e-14)
    assert k_zz == pytest.approx(k_xx, rel=1e-14)
    assert k_c == pytest.approx(2 * G * (1 - 2 * nu) / (3 - 4 * nu), rel=1e-14)


def test_uniform_mode_is_shear_and_confined_compression_of_the_layer():
    k_xx, k_zz, k_c = stiffness(np.array([0.0, 1e-9]), 50.0, 70.0, 0.3)
    G = 70.0 / 2.6
    assert k_xx == pytest.approx(G / 50.0, rel=1e-12)
    assert k_zz == pytest.approx(2 * G * 0.7 / (0.4 * 50.0), rel=1e-12)
    assert k_c == pytest.approx(0.0, abs=1e-6)


def test_pressing_a_half_plane_draws_its_surface_towards_the_load():
    """The sign of the coupling: for nu < 1/2 the surface beside a pressed spot moves towards it (Boussinesq)."""
    scene = Scene(nodes=512, width=512.0, nu=0.2, height=10.0)
    layer = Convolution(Modes.of(scene), 512)
    layer.field[1, 250:263] = 1.0
    layer.apply()
    u = layer.product
    assert u[1, 256] > u[1, 300]  # pushed up
    assert u[0, 230] > 1e-4 and u[0, 282] < -1e-4
    assert u[0] == pytest.approx(-np.roll(u[0, ::-1], 1), abs=1e-12)


def test_mirroring_the_tractions_mirrors_the_displacements():
    scene = Scene(nodes=130, width=300.0)
    tractions = np.random.default_rng(1).normal(size=(2, 130))
    layer = Convolution(Modes.of(scene), 130)
    layer.field[:] = tractions
    layer.apply()
    u = layer.product.copy()
    layer.field[0], layer.field[1] = -tractions[0, ::-1], tractions[1, ::-1]
    layer.apply()
    assert layer.product == pytest.approx(np.array([-u[0, ::-1], u[1, ::-1]]), abs=1e-12)


@pytest.mark.parametrize("nodes", [128, 127, 131])
@pytest.mark.parametrize("size", [1, 17, 50, 90])
def test_product_on_a_patch_is_the_sum_over_all_modes(nodes, size):
    """Fourier sums written out in full, odd, even and prime numbers of nodes; patches with and without zero padding."""
    scene = Scene(nodes=nodes, width=2.4 * nodes, nu=0.3)
    q = 2 * np.pi * np.arange(nodes // 2 + 1) / scene.width
    c_xx, c_zz, c_c = compliance(q, scene.width, scene.E, scene.nu)
    weight = np.full(q.size, 2.0)
    weight[0] = 1.0
    if nodes % 2 == 0:
        weight[-1] = 1.0
        k_xx, k_zz, _ = stiffness(q, scene.width, scene.E, scene.nu)
        c_xx[-1], c_zz[-1], c_c[-1] = 1 / k_xx[-1], 1 / k_zz[-1], 0.0
    distance = scene.spacing * np.subtract.outer(np.arange(size), np.arange(size))
    phase = np.multiply.outer(distance, q)
    even, odd = np.cos(phase) * weight / nodes, -np.sin(phase) * weight / nodes
    tractions = np.random.default_rng(0).normal(size=(2, size))
    expected = np.array(
        [
            (even @ c_xx) @ tractions[0] + (odd @ c_c) @ tractions[1],
            -(odd @ c_c) @ tractions[0] + (even @ c_zz) @ tractions[1],
        ]
    )
    layer = Convolution(Modes.of(scene), size)
    layer.field[:] = tractions
    layer.apply()
    assert layer.product == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
