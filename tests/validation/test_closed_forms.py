"""Closed forms, and where floating point itself limits; `stability.py` prints both as tables."""

import extended
import mpmath
import numpy as np
import pytest
from adhesion import PULL_OFF_JKR, adhesion, load_maugis, pull_off_maugis, repulsive_jkr
from closed_forms import PROBLEMS
from conditioning import conditioning
from extended import displacement, springs

from solver import Scene
from solver.mechanics.layer import compliance, stiffness


@pytest.mark.slow
@pytest.mark.parametrize("problem", [problem for problem in PROBLEMS if problem is not adhesion])
def test_every_closed_form_holds_within_its_tolerance(problem):
    assert [(row.name, row.error, row.tolerance) for row in problem() if not row.held] == []


@pytest.mark.thorough
@pytest.mark.slow
def test_adhesive_contacts_agree_with_jkr_and_the_more_with_maugis_dugdale_the_larger_lambda():
    """Towards JKR the shape of the law is forgotten: the deviation from Maugis-Dugdale falls with lambda."""
    forms = adhesion()
    assert [(row.name, row.error, row.tolerance) for row in forms if not row.held] == []
    errors = [row.error for row in forms if row.name.startswith("Maugis-Dugdale")]
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]


def test_maugis_dugdale_approaches_jkr():
    assert pull_off_maugis(50.0) == pytest.approx(PULL_OFF_JKR, rel=1e-4)
    a, load = load_maugis(50.0, 1.0 + np.geomspace(1e-4, 1e-2, 50))
    # JKR's own load over half-width; lambda = 50 is 1% from infinite away from pull-off
    assert load == pytest.approx(a**2 - 2.0 * np.sqrt(a), abs=0.02)
    assert repulsive_jkr(-1.0) == pytest.approx(0.0, abs=1e-6)  # where the tension at the edges takes all of it


def test_every_limit_of_floating_point_is_met():
    assert [(limit.name, limit.attained) for limit in conditioning() if not limit.attained <= limit.allowed] == []


def test_the_textbook_formula_loses_digits_or_overflows():
    """Therefore the solver scales and expands it."""
    worst = [limit.textbook for limit in conditioning() if limit.name.startswith("stiffness")]
    assert sum(not error < 1e-13 for error in worst) >= 3


def exact(q, height, E, nu):
    """(K_xx, K_zz, K_c) and (C_xx, C_zz, C_c) by the textbook formulas, 60 digits."""
    with mpmath.workdps(60):
        q, h, E, nu = (mpmath.mpf(float(v)) for v in (q, height, E, nu))
        G, kappa, y = E / (2 * (1 + nu)), 3 - 4 * nu, q * h
        s, c = mpmath.sinh(y), mpmath.cosh(y)
        d = kappa**2 * s**2 - y**2
        k_xx, k_zz = (4 * G * (1 - nu) * q * (kappa * s * c + sign * y) / d for sign in (-1, 1))
        k_c = 2 * G * q * (kappa * (1 - 2 * nu) * s**2 - y**2) / d
        det = k_xx * k_zz - k_c**2
        return (k_xx, k_zz, k_c), (k_zz / det, k_xx / det, k_c / det)


@pytest.mark.parametrize("E", [1e-2, 1e6])
@pytest.mark.parametrize("nu", [0.0, 0.49, 0.4999])
@pytest.mark.parametrize("y", [1e-6, 1e-4, 1e-2, 0.0628, 0.99, 1.01, 20.0, 350.0, 1e3, 1e6])
def test_stiffness_and_compliance_agree_with_sixty_digits(y, nu, E):
    q, height = np.array([y / 25.0]), 25.0
    for computed, digits in zip((stiffness, compliance), exact(q[0], height, E, nu), strict=True):
        for value, expected in zip(computed(q, height, E, nu), digits, strict=True):
            # the coupling passes through zero: its error is measured against the larger diagonal entry
            scale = max(abs(expected), digits[0], digits[1]) if expected is digits[2] else abs(expected)
            assert abs(float(value[0]) - expected) <= 2e-15 * scale


@pytest.mark.parametrize("y", [1e-3, 0.0628, 1.0, 30.0])
def test_long_double_reference_is_finer_than_float64(y):
    """The reference of `conditioning` and of the atlas: held against 60 digits itself."""
    for nu in (0.0, 0.4999):
        reference = extended.stiffness(np.array([y / 25.0], np.longdouble), 25.0, 70.0, nu)[:2, 0]
        # at nu = 0.4999 and q h = 1e-3, D cancels to 1e-4 of its terms; the rest is rounding of the inputs' products
        lost = 1.0 if y > 0.05 else 1e3
        digits = exact(np.longdouble(y) / 25.0, 25.0, 70.0, nu)[0][:2]
        for value, expected in zip(reference, digits, strict=True):
            assert abs(float(value / float(expected)) - 1.0) <= 2.3e-16 + 64 * lost * np.finfo(np.longdouble).eps


@pytest.mark.parametrize("depth", [-30.0, -50.0, 10.0])
def test_springs_of_the_recheck_agree_with_mpmath(depth):
    scene, x = Scene(), 0.4
    with mpmath.workdps(40):
        a, springs_x, springs_z = mpmath.mpf(scene.spacing), mpmath.mpf(0), mpmath.mpf(0)
        for j in range(-2, 3):
            dt = j * a - mpmath.mpf(x)
            if abs(dt) <= scene.window_t:
                spring = mpmath.exp(-mpmath.mpf(depth)) * mpmath.exp(-(dt**2))
                springs_x += 2 * scene.phi_t * dt * spring
                springs_z -= scene.phi_n * mpmath.mpf(depth) * spring
    T, _ = springs(scene, np.array([x]), np.array([depth]))
    assert float(T[0, 0]) == pytest.approx(float(springs_x), rel=1e-15)
    assert float(T[1, 0]) == pytest.approx(float(springs_z), rel=1e-15)


def test_displacement_of_the_recheck_is_the_real_space_sum():
    """Its transform against cosines and sines written out, and its K_c against the layer's sign."""
    scene = Scene(nodes=16, width=40.0, height=0.2, nu=0.2)
    T = np.random.default_rng(2).normal(size=(2, 16))
    q = 2 * np.pi * np.arange(9) / scene.width
    c_xx, c_zz, c_c = compliance(q, scene.height * scene.width, scene.E, scene.nu)
    k_xx, k_zz, _ = stiffness(q, scene.height * scene.width, scene.E, scene.nu)
    c_xx[-1], c_zz[-1], c_c[-1] = 1 / k_xx[-1], 1 / k_zz[-1], 0.0
    weight = np.array([1.0, *[2.0] * 7, 1.0]) / 16
    phase = np.multiply.outer(np.subtract.outer(scene.x, scene.x), q)
    even, odd = np.cos(phase) * weight, -np.sin(phase) * weight
    expected = [even @ c_xx @ T[0] + odd @ c_c @ T[1], -(odd @ c_c) @ T[0] + even @ c_zz @ T[1]]
    u, bound = displacement(scene, T.astype(np.longdouble))
    assert u.astype(float) == pytest.approx(np.array(expected), abs=1e-13)
    assert np.abs(expected).max() <= bound
