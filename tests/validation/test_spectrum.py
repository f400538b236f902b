"""Growth rates of disturbances of a frame, against known answers."""

from copy import copy
from types import SimpleNamespace

import numpy as np
import pytest
from extended import displacement, springs
from scipy.optimize import brentq
from spectrum import (
    exponents,
    friction,
    growth,
    matrix,
    rate,
    stiffness,
    tangent,
)

from solver import Scene, load_path


def frame_of(scene, ux, uz, nodes=None):
    """A frame with every node at that displacement, whether or not it is an equilibrium."""
    u = np.broadcast_to(np.array([[ux], [uz]]), (2, nodes or scene.nodes))
    m = u.shape[1]
    T, _ = springs(scene, u[0], scene.profile[:m] + u[1])
    return SimpleNamespace(first=0, u=u, T=T.astype(float))


def with_damping(scene, damping):
    """The Scene with less damping than a run may have."""
    weak = copy(scene)
    object.__setattr__(weak, "damping", damping)
    return weak


def critical(scene, frame):
    """(growth Re(lambda), mu in GPa/nm) of the fastest growing, or slowest decaying, disturbance of a frame."""
    mu = exponents(scene, frame)
    rates = rate(mu, friction(scene))
    return rates.max(), mu[rates.argmax()]


def oscillates(mu):
    """Whether mu belongs to a complex pair, but for the round-off of dense eigenvalues."""
    return abs(mu.imag) > 1e-9 * abs(mu)


@pytest.fixture(scope="module")
def pressed():
    """(scene, frame): a punch deep in contact, sheared; it rests at critical damping, and flutters below a half."""
    scene = Scene(delta_bar=1.0, nodes=192, width=468.75, u_x_max=6.7, du_x=0.67, du_z=0.5)
    return with_damping(scene, 0.1), list(load_path(scene))[-1]


def test_a_free_layer_decays_at_half_its_damping():
    scene = Scene(nodes=64, width=156.25)
    far = frame_of(scene, 0.0, 100.0)
    far.T[:] = 0.0
    assert growth(scene, far) == pytest.approx(-0.5 * friction(scene), rel=1e-6)
    assert friction(scene) == pytest.approx(2.0 * (scene.shear_modulus / scene.width) ** 0.5, rel=1e-12)
    assert growth(scene, far, held=True) == pytest.approx(0.0, abs=1e-12)  # nothing holds the top


def test_stiffness_is_the_inverse_of_compliance():
    scene = Scene(nodes=32, width=78.0, nu=0.3, height=0.4)
    T = np.random.default_rng(0).normal(size=(2, 32))
    k = stiffness(scene)
    u, _ = displacement(scene, T)
    back = matrix(scene, 0, np.zeros((2, 2, 32)), k) @ u.astype(float).ravel()
    assert back == pytest.approx(-T.ravel(), abs=1e-11)


def test_the_tangent_is_that_of_the_springs(pressed):
    scene, frame = pressed
    profile = scene.profile[frame.first :][: frame.u.shape[1]]
    J = tangent(scene, frame)
    for d in range(2):
        ahead, behind = frame.u.astype(np.longdouble), frame.u.astype(np.longdouble)
        ahead[d], behind[d] = ahead[d] + 1e-6, behind[d] - 1e-6
        slope = (springs(scene, ahead[0], profile + ahead[1])[0]
                 - springs(scene, behind[0], profile + behind[1])[0]) / 2e-6  # fmt: skip
        assert J[:, d].astype(float) == pytest.approx(slope.astype(float), abs=1e-9)


def test_uniform_waves_solve_the_quadratic_of_each_block():
    scene = Scene(surface="flat", nodes=24, width=58.56, nu=0.3)
    frame = frame_of(scene, 0.4, 0.3)
    J, mu = tangent(scene, frame)[:, :, 0].astype(float), exponents(scene, frame)
    G, h = scene.shear_modulus, scene.width
    a, d = J[0, 0] - G / h, J[1, 1] - 2.0 * G * 0.7 / (0.4 * h)
    root = np.sqrt(complex((a - d) ** 2 / 4.0 + J[0, 1] * J[1, 0]))
    for hand in ((a + d) / 2.0 + root, (a + d) / 2.0 - root):
        assert np.abs(mu - hand).min() < 1e-12 * abs(hand)
    k = stiffness(scene)
    dense = np.linalg.eigvals(matrix(scene, 0, tangent(scene, frame).astype(float), k)).astype(complex)
    assert max(np.abs(dense - value).min() for value in mu) < 1e-9
    assert growth(scene, frame) == pytest.approx(float(rate(dense, friction(scene)).max()), abs=1e-9)


def test_at_a_fold_growth_vanishes_and_changes_sign():
    scene = Scene(surface="flat", phi_ratio=0.1, nodes=32, width=32 * 2.44, height=32.0)

    def slope(u):
        return float(tangent(scene, frame_of(scene, u, 0.0))[0, 0, 0]) - scene.shear_modulus / (32.0 * scene.width)

    fold = brentq(slope, 0.1, scene.spacing / 2.0, xtol=1e-14)
    fastest, mu = critical(scene, frame_of(scene, fold, 0.0))
    assert abs(fastest) < 1e-9 and not oscillates(mu)
    assert growth(scene, frame_of(scene, fold - 1e-3, 0.0)) < 0.0 < growth(scene, frame_of(scene, fold + 1e-3, 0.0))


def test_a_complex_pair_crosses_on_the_parabola():
    gamma = 0.3
    for real in (0.01, 1.0, 50.0):
        imag = gamma * np.sqrt(real)
        assert rate(-real + 1j * imag, gamma) == pytest.approx(0.0, abs=1e-13)
        assert rate(-real + 1.01j * imag, gamma) > 0.0 > rate(-real - 0.99j * imag, gamma)
    assert rate(-2.0 + 5.0j, np.inf) == -2.0
    # the larger root indeed: of lambda^2 + gamma lambda = mu
    mu = np.array([-3.0 + 1.0j, 0.2, -0.01, 2.0j])
    roots = [np.roots([1.0, gamma, -value]).real.max() for value in mu]
    assert rate(mu, gamma) == pytest.approx(roots, abs=1e-12)


def test_an_attracted_flat_is_unstable_to_waves_alone():
    scene = Scene(surface="flat", nu=0.499, E=17.5, nodes=256, width=625.0)
    fastest, mu = critical(scene, frame_of(scene, 0.0, 2.0))
    pull = scene.phi_n * np.exp(-2.0) * np.exp(-((np.arange(-2, 3) * scene.spacing) ** 2)).sum()
    k = stiffness(scene)
    assert pull < k[1, 0] and fastest > 0.0 and not oscillates(mu)
    assert mu.real == pytest.approx(pull - k[1].min(), rel=0.1)  # but for the coupling to x


def test_a_pressed_punch_flutters_at_little_damping(pressed):
    scene, frame = pressed
    fastest, mu = critical(scene, frame)
    assert fastest == pytest.approx(0.0132, abs=2e-4) and oscillates(mu)
    assert growth(with_damping(scene, 1.0), frame) < 0.0
    assert growth(scene, frame, held=True) == pytest.approx(fastest, rel=0.1)  # short waves: the top keeps still


def test_nodes_that_are_alike_to_round_off_have_the_eigenvalues_of_each_mode(monkeypatch):
    """Transforms of a prime length leave such round-off; eigenvalues of 4,099 dense nodes took minutes."""
    scene = Scene(surface="flat", nodes=127, width=309.88)
    frame = frame_of(scene, 0.3, 0.5)
    alike = np.sort_complex(exponents(scene, frame))
    J = tangent(scene, frame)
    noise = 1.0 + 1e-13 * np.random.default_rng(1).normal(size=J.shape)
    monkeypatch.setattr("spectrum.tangent", lambda *_: J * noise)
    monkeypatch.setattr("spectrum.matrix", None)
    assert np.sort_complex(exponents(scene, frame)) == pytest.approx(alike, rel=1e-9, abs=1e-9)
