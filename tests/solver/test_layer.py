"""The layer's Green's function and the products with it."""

import numpy as np
import pytest

from solver import Scene
from solver.mechanics.layer import Convolution, Modes, compliance, stiffness


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
    """Fourier sums written out in full, odd, even and prime numbers of nodes."""
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
