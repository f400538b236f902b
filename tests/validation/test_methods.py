"""One contract for every method: the same frames, from one run, from slices, or from threads."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from math import inf
from threading import Barrier

import numpy as np
import pytest

from solver import METHODS, Scene, SceneError, advance, load_path, summarize, whole_surface
from solver.mechanics.layer import Modes
from solver.run.loadpath import Run, until
from solver.run.slices import in_time

SMALL = Scene(nodes=256, width=625.0, u_x_max=12.0, tolerance=1e-8)
NARROW = {"nodes": 128, "width": 312.5}
STROKES = {"fast": SMALL.changed(u_x_max=11.0), "gfmd": SMALL.changed(nodes=64, width=156.25, u_x_max=1.0)}


def shear_frames(scene, method="fast"):
    return [f for f in load_path(scene, method) if f.stage == "shear"]


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("values", [NARROW, {}, {"delta_bar": 0.4}, {"delta_bar": -0.15}])
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


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_slices_give_the_frames_of_an_uninterrupted_run(method):
    scene = STROKES[method]
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


def test_resuming_twice_from_a_checkpoint_gives_the_same_frames():
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
        u = whole_surface(frame)
        part = slice(frame.first, frame.first + frame.u.shape[1])
        assert np.abs(u[:, part] - frame.u).max() <= 2 * scene.tolerance
        tractions = np.zeros((2, nodes))
        for i in range(nodes):
            gap = scene.profile[i] + u[1, i]
            dt = scene.spacing * (np.arange(-9, 10) + np.round(u[0, i] / scene.spacing)) - u[0, i]
            spring = np.exp(-gap) * np.exp(-(dt**2))
            tractions[:, i] = 2 * scene.phi_t * np.sum(dt * spring), -scene.phi_n * gap * np.sum(spring)
        d_x, d_z = np.fft.rfft(u - np.array([[frame.U_x], [-frame.delta]]))
        k_xx, k_zz, k_c = modes.stiffness
        force_x = k_xx * d_x - 1j * k_c * d_z
        force_z = k_zz * d_z + 1j * k_c * d_x
        elastic = np.fft.irfft(np.array([force_x, force_z]), nodes)
        # a displacement error of the tolerance makes a traction error of up to the stiffest mode times it
        assert np.abs(elastic - tractions).max() < 10 * k_zz.max() * scene.tolerance


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_an_increment_out_of_time_reports_where_and_can_be_resumed(method):
    scene = STROKES[method]
    whole = list(load_path(scene, method))
    half = len(whole) // 2
    found, checkpoint = [], None
    while len(found) < half:
        frames, checkpoint = advance(scene, checkpoint, 0.0, method)
        found += frames
    for _ in range(16):  # the clock is looked at now and then: cheap increments may pass unseen
        frames, checkpoint = advance(scene, checkpoint, 0.0, method, limit=0.0)
        found += frames
        if checkpoint.done:
            break
    assert checkpoint.outcome == "out of time" and checkpoint.failure.startswith("Not converged at ")
    assert "no equilibrium within 0 s of processor time" in checkpoint.failure
    rest, end = advance(scene, in_time(checkpoint), inf, method)
    assert end.done and end.failure is None and [f.index for f in found + rest] == [f.index for f in whole]
    force = np.array([[f.F_bar for f in run] for run in (found + rest, whole)])
    assert np.abs(force[0] - force[1]).max() <= 1e-6 * np.abs(force[1]).max()


@pytest.mark.parametrize("index", [10, -10])  # one that is solved, and one that is repeated by lattice periods
def test_an_increment_does_not_change_its_checkpoint(index):
    """Solves push secant pairs: those of the given checkpoint must not change, or the second run would differ."""
    checkpoint = [checkpoint for _, checkpoint in until(SMALL)][index]
    kept = checkpoint.state.secants  # a repeated state has none
    pairs = kept and kept.copy()
    runs = [Run(SMALL).next_frame(checkpoint)[0] for _ in range(2)]
    assert np.array_equal(runs[0].u, runs[1].u) and runs[0].evaluations == runs[1].evaluations
    assert (pairs is None) == (index < 0)
    assert kept is None or (np.array_equal(pairs.sums, kept.sums) and np.array_equal(pairs.place, kept.place))


def test_frames_carry_residual_evaluations_and_slip():
    frames = list(load_path(SMALL))
    assert all(0 <= f.residual <= SMALL.tolerance and f.evaluations > 0 for f in frames)
    summary = summarize(frames)
    assert summary["converged"] and summary["slips"] == sum(len(f.slips) for f in frames if f.stage == "shear") > 0
    assert summary["evaluations"] == sum(f.evaluations for f in frames)
    assert summary["A_s"] < summary["A_0"]


def test_a_negative_displacement_is_not_a_scene():
    with pytest.raises(SceneError, match="u_x_max"):
        Scene(u_x_max=-1.0)


def test_an_unknown_method_is_named():
    with pytest.raises(ValueError, match="method = 'newton'; allowed: fast, gfmd"):
        next(load_path(SMALL, "newton"))


@pytest.mark.once(2)
@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.3, inf, 4.0])
def test_both_methods_agree_at_every_damping(damping):
    """A stroke with a slip; inf: both creep."""
    scene = Scene(nodes=64, width=160.0, radius=1.0, du_z=0.5, du_x=0.1, u_x_max=5.0, damping=damping, tolerance=1e-7)
    fast, gfmd = shear_frames(scene), shear_frames(scene, "gfmd")
    assert any(f.slip for f in fast) and [f.slip for f in fast] == [f.slip for f in gfmd]
    assert max(np.abs(f.u - g.u).max() for f, g in zip(fast, gfmd, strict=True)) < 1e-5


# Two threads on one Scene


def by_load_path(scene, barrier):
    frames = []
    for frame in load_path(scene):
        frames.append(frame)
        barrier()
    return frames


def by_advance(scene, barrier):
    frames, checkpoint = [], None
    while checkpoint is None or not checkpoint.done:
        more, checkpoint = advance(scene, checkpoint, budget=0.0)
        frames += more
        barrier()
    return frames


@pytest.mark.once(2)
@pytest.mark.parametrize("run", [by_load_path, by_advance])
@pytest.mark.parametrize("values", [{"u_x_max": 14.0}, {"surface": "flat", "phi_ratio": 0.1, "damping": inf}])
def test_two_threads_on_one_scene_get_the_frames_of_one(run, values):
    """In step, increment by increment, so that they meet; equal to the last digit. They shared buffers once."""
    scene, meeting = SMALL.changed(**values), Barrier(2, timeout=120.0)
    alone = run(scene, lambda: None)
    assert any(f.slip for f in alone)
    with ThreadPoolExecutor(2) as pool:
        together = [future.result(120.0) for future in [pool.submit(run, scene, meeting.wait) for _ in range(2)]]
    for frames in together:
        assert len(frames) == len(alone)
        for a, b in zip(frames, alone, strict=True):
            assert np.array_equal(a.u, b.u) and np.array_equal(a.T, b.T)
            assert (a.F_bar, a.L_bar, a.A_bar, a.evaluations, a.slips) == (
                b.F_bar,
                b.L_bar,
                b.A_bar,
                b.evaluations,
                b.slips,
            )


def test_interleaved_runs_of_one_scene_do_not_disturb_each_other():
    """One generator runs ten increments ahead of the other."""
    first, second = load_path(SMALL), load_path(SMALL)
    ahead = [next(first) for _ in range(10)]
    pairs = [(next(first), next(second)) for _ in range(100)]
    lagging = [b for _, b in pairs]
    assert all(np.array_equal(a.u, b.u) for a, b in zip(ahead, lagging, strict=False))
    assert all(np.array_equal(a.u, b.u) for (a, _), b in zip(pairs, lagging[10:], strict=False))


def test_every_increment_has_a_frame_where_lattice_and_steps_do_not_match():
    """A known state moved on comes back at the load asked for: an ulp above it was taken for a later rest."""
    scene = Scene(nodes=300, width=730.0)
    shear = shear_frames(scene)
    assert [f.index for f in shear] == list(range(scene.shear_increments + 1))
    assert [f.U_x for f in shear] == [scene.shear_at(k) for k in range(len(shear))]
    assert sum(f.repeated for f in shear) > 200


# Never an exception of another kind

ODD = [
    # once ended in LinAlgError
    {"surface": "rough", "phi_n": 28.41, "phi_ratio": 0.2113, "E": 41.24, "nu": 0.35, "delta_n": 0.4753,
     "delta_t": 0.6181, "nodes": 200, "width": 228.7, "height": 6.797, "rms_slope": 0.01441, "cut_off": 0.06,
     "seed": 644, "du_z": 1.0, "tolerance": 1e-10, "damping": 0.5},
    pytest.param(  # a runaway
        {"surface": "flat", "hold": "load", "delta_bar": 0.82, "phi_ratio": 0.0021, "E": 9637, "nu": 0.4999,
         "nodes": 129}, marks=pytest.mark.thorough),
    pytest.param({"delta_bar": 1.0, "phi_ratio": 0.3, "damping": 0.2, "nodes": 128, "width": 312.5, "u_x_max": 5.0},
                 marks=pytest.mark.thorough),
    {"surface": "flat", "nodes": 16, "width": 40.0, "delta_bar": 1.0, "du_x": 0.5},
    pytest.param({"E": 0.01, "nodes": 256, "width": 625.0, "u_x_max": 0.0}, marks=pytest.mark.thorough),
    # points along the arc that are one, and all zero
    {"E": 4.919, "delta_bar": 3.0, "nu": 0.187, "height": 16.43, "radius": 0.1, "nodes": 8, "surface": "flat",
     "delta_n": 0.1, "width": 19.52, "du_z": 1.0, "du_x": 1.0},
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("values", ODD, ids=range(len(ODD)))
def test_a_run_ends_with_frames_or_with_a_remedy(values):
    scene, checkpoint, frames = Scene(**values), None, []
    while checkpoint is None or not checkpoint.done:
        more, checkpoint = advance(scene, checkpoint)
        frames += more
    assert all(np.isfinite(f.u).all() and f.residual <= scene.tolerance for f in frames)
    assert checkpoint.failure is None or ("; try" in checkpoint.failure or "; hold" in checkpoint.failure)
