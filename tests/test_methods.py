"""One contract for every method: the same frames, from one run or from slices."""

import pickle

import numpy as np
import pytest

from solver import METHODS, Scene, SceneError, advance, load_path, summarize, whole_surface
from solver.layer import Modes

SMALL = Scene(nodes=256, width=625.0, u_x_max=12.0, tolerance=1e-8)


def shear_frames(scene, method="fast"):
    return [f for f in load_path(scene, method) if f.stage == "shear"]


@pytest.mark.parametrize("values", [{}, {"delta_bar": 0.4}, {"delta_bar": -0.15}])
def test_both_methods_agree_before_at_and_after_the_first_slip(values):
    scene = Scene(u_x_max=13.4, **values)
    fast, gfmd = shear_frames(scene), shear_frames(scene, "gfmd")
    first = next(i for i, f in enumerate(gfmd) if f.slip)
    assert next(i for i, f in enumerate(fast) if f.slip) == first
    for name in ("F_bar", "L_bar"):
        a, b = (np.array([getattr(f, name) for f in run]) for run in (fast, gfmd))
        assert np.abs(a - b)[:first].max() <= 1e-6 * np.abs(b).max()
        assert np.abs(a - b)[first:].max() <= 1e-6 * np.abs(b).max()
    assert max(abs(f.A_bar - g.A_bar) for f, g in zip(fast, gfmd, strict=True)) * scene.nodes <= 2
    assert np.abs(fast[first].u - gfmd[first].u).max() < 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_slices_give_the_frames_of_an_uninterrupted_run(method):
    scene = SMALL.changed(u_x_max=11.0 if method == "fast" else 1.0)
    whole = list(load_path(scene, method))
    sliced, checkpoint = [], None
    while checkpoint is None or not checkpoint.done:
        frames, checkpoint = advance(scene, pickle.loads(pickle.dumps(checkpoint)), budget=0.0, method=method)
        assert len(frames) == 1
        sliced += frames
    assert len(sliced) == len(whole)
    # FFTW may choose another plan in between: round-off, amplified by at most the condition of the contact
    assert max(np.abs(a.u - b.u).max() for a, b in zip(whole, sliced, strict=True)) < 10 * scene.tolerance
    assert [f.slip for f in whole] == [f.slip for f in sliced]


def test_going_on_twice_from_a_checkpoint_gives_the_same_frames():
    checkpoint = None
    for _ in range(130):  # into the shear
        _, checkpoint = advance(SMALL, checkpoint, budget=0.0)
    first, _ = advance(SMALL, checkpoint, budget=0.0)
    again, _ = advance(SMALL, checkpoint, budget=0.0)
    assert np.array_equal(first[0].u, again[0].u) and first[0].evaluations == again[0].evaluations


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("nodes", [64, 65])
def test_every_frame_is_in_equilibrium_by_direct_sums(method, nodes):
    """Residual anew: tractions spring by spring, and the stiffness of every mode instead of the compliance."""
    scene = Scene(nodes=nodes, width=2.5 * nodes, u_x_max=1.0, delta_bar=0.1, tolerance=1e-9)
    frames = list(load_path(scene, method))
    assert [f.stage for f in frames].count("shear") == scene.shear_increments + 1
    modes = Modes.of(scene)
    for frame in frames[:: len(frames) // 7]:
        u = whole_surface(scene, frame)
        part = slice(frame.first, frame.first + frame.u.shape[1])
        assert np.abs(u[:, part] - frame.u).max() <= 2 * scene.tolerance
        tractions = np.zeros((2, nodes))
        for i in range(nodes):
            gap = scene.profile[i] + u[1, i]
            if gap <= scene.window_n * scene.delta_n:
                dt = scene.spacing * (np.arange(-9, 10) + np.round(u[0, i] / scene.spacing)) - u[0, i]
                spring = np.exp(-gap) * np.exp(-(dt**2))
                tractions[:, i] = 2 * scene.phi_t * np.sum(dt * spring), -scene.phi_n * gap * np.sum(spring)
        d_x, d_z = np.fft.rfft(u - np.array([[frame.U_x], [-frame.delta]]))
        force_x = modes.k_xx * d_x - 1j * modes.k_c * d_z
        force_z = modes.k_zz * d_z + 1j * modes.k_c * d_x
        elastic = np.fft.irfft(np.array([force_x, force_z]), nodes)
        # a displacement error of the tolerance makes a traction error of up to the stiffest mode times it
        assert np.abs(elastic - tractions).max() < 10 * modes.k_zz.max() * scene.tolerance


def test_frames_carry_residual_evaluations_and_slip():
    frames = list(load_path(SMALL))
    assert all(0 <= f.residual <= SMALL.tolerance and f.evaluations > 0 for f in frames)
    summary = summarize(SMALL, frames)
    assert summary["converged"] and summary["slips"] == sum(len(f.slips) for f in frames if f.stage == "shear") > 0
    assert summary["evaluations"] == sum(f.evaluations for f in frames)
    assert summary["A_s"] < summary["A_0"]


def test_pulling_the_other_way_is_not_a_scene():
    with pytest.raises(SceneError, match="u_x_max"):
        Scene(u_x_max=-1.0)


def test_an_unknown_method_is_named():
    with pytest.raises(ValueError, match="method = 'newton'; allowed: fast, gfmd"):
        next(load_path(SMALL, "newton"))
