"""The damping above which no wave flutters: closed forms for uniform tangents, and the values of a run's frames."""

import numpy as np
import pytest

from solver import Scene, load_path
from solver.mechanics.cohesive_law import tangent
from solver.mechanics.flutter import FINER, MARGIN, WIDTH, safe_damping, safe_friction
from solver.mechanics.layer import Modes
from solver.run.frame import largest_safe_damping

CELL = Scene(nodes=128, width=312.5)


def uniform(xx, xz, zx, zz, m):
    return np.repeat(np.array([[xx], [xz], [zx], [zz]]), m, axis=1)


def test_uniform_tangents_flutter_at_the_damping_of_their_most_critical_wave():
    """lambda^2 + gamma lambda = mu has a root on the imaginary axis at gamma^2 = (Im mu)^2/|Re mu|."""
    k_xx, k_zz, k_c = Modes.of(CELL).stiffness
    xx, xz, zx, zz = -1.0, 0.8, -0.6, -0.4  # GPa/nm
    gamma = 0.0
    for q in range(k_xx.size):
        mu = np.linalg.eigvals([[xx - k_xx[q], xz + 1j * k_c[q]], [zx - 1j * k_c[q], zz - k_zz[q]]])
        gamma = max([gamma, *np.abs(mu.imag[mu.real < 0.0]) / np.sqrt(-mu.real[mu.real < 0.0])])
    # not every wavenumber is looked at, but within a factor FINER of each one is
    found = safe_friction(uniform(xx, xz, zx, zz, 128), Modes.of(CELL).stiffness, 128) / MARGIN
    assert gamma / FINER <= found <= gamma * (1.0 + 1e-12)


@pytest.mark.parametrize("m", [128, 40])
def test_symmetric_tangents_never_flutter(m):
    rng = np.random.default_rng(3)
    xx, xz, zz = rng.normal(size=(3, m))
    assert safe_friction(np.array([xx, xz, xz, zz]), Modes.of(CELL).stiffness, 128) == 0.0


def test_flutter_does_not_depend_on_where_a_patch_begins():
    """Averages of the whole cell go round its ends."""
    rng = np.random.default_rng(4)
    tangents = rng.normal(size=(4, 128)) * np.hanning(128) ** 4
    moved = np.roll(tangents, 64, axis=1)
    found = [safe_friction(t, Modes.of(CELL).stiffness, 128) for t in (tangents, moved)]
    assert found[0] == pytest.approx(found[1], rel=1e-12) and found[0] > 0.0


def test_safe_damping_of_a_run_equals_that_of_all_its_frames():
    frames = list(load_path(Scene()))
    everywhere = max(frame.safe_damping for frame in frames)
    assert largest_safe_damping(frames) == pytest.approx(everywhere, abs=0.05)


def test_the_estimate_agrees_with_gaussian_averages_at_every_wavenumber():
    """On the state before the first slip of the default scene, with the averages of all nodes in Fourier space.

    The estimate averages level by level, so that its averages are narrower by up to WIDER^1/2; half the width adds 7 %.
    """
    scene = Scene(u_x_max=10.8)
    *_, last = load_path(scene)
    part = slice(last.first, last.first + last.u.shape[1])
    J = np.zeros((4, scene.nodes))
    J[:, part] = tangent(scene, last.u[0], scene.profile[part] + last.u[1])
    k_xx, k_zz, k_c = Modes.of(scene).stiffness
    q = 2.0 * np.pi * np.arange(k_xx.size) / scene.width
    worst = 0.0
    for p in range(k_xx.size):
        wide = np.exp(-0.5 * (WIDTH * q / q[p]) ** 2) if p else q == 0.0  # a Gaussian of standard deviation WIDTH/q
        xx, xz, zx, zz = np.fft.irfft(np.fft.rfft(J) * wide, scene.nodes)
        block = np.array([[xx - k_xx[p], xz + 1j * k_c[p]], [zx - 1j * k_c[p], zz - k_zz[p]]])
        mu = np.linalg.eigvals(np.moveaxis(block, 2, 0))
        worst = max([worst, *(mu.imag**2 / -mu.real)[mu.real < 0.0]])
    expected = MARGIN * np.sqrt(worst) / Modes.of(scene).critical
    assert last.safe_damping == pytest.approx(expected, rel=0.05)


def test_a_uniform_flat_does_not_hide_unstable_waves():
    frame = [*load_path(Scene(surface="flat", u_x_max=1.0, nodes=64, width=156.25))][-1]
    assert safe_damping(frame.scene, frame.u) == 0.0
