"""Loops that call FFTW by address: the same results as by pyFFTW, also of several contacts, threads and processes."""

import multiprocessing
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from solver import Scene, load_path
from solver.continuation.motion import Motion
from solver.mechanics import fftw
from solver.mechanics.contact import Contact, patch
from solver.mechanics.equilibrium import Equilibrium
from solver.mechanics.kernels import _exp
from solver.mechanics.layer import Transform
from solver.mechanics.surface import closed_stiffness
from solver.run.film import Camera
from solver.run.load_steps import sideways

SMALL = {"nodes": 128, "width": 312.5, "radius": 20.0, "u_x_max": 16.0}
SCENES = [
    SMALL,
    SMALL | {"nodes": 127},
    SMALL | {"surface": "rough", "seed": 3},
    SMALL | {"law": "xu-needleman"},
    SMALL | {"damping": float("inf")},
    SMALL | {"hold": "load", "delta_bar": 0.0},
]
needs_library = pytest.mark.skipif(fftw._library() is None, reason="no FFTW by address: every loop is Python's")


def loads_of(values):
    """Loads of the slips, nm."""
    return [event.load for frame in load_path(Scene(**values)) for event in frame.slips]


def moved(scene, steps=40):
    """(y after steps of a motion, evaluations), from a surface that is not at rest."""
    problem = Equilibrium(Contact(scene, *patch(scene)), sideways(1.0, -scene.delta))
    v, dynamics = problem.undeformed(3.0), problem.motion()
    motion = Motion(dynamics, dynamics.start(v, 3.0), 3.0, 0.5, closed_stiffness(scene))
    motion.soften(dynamics.interface(v))
    motion.advance(steps)
    return motion.y, problem.evaluations


@needs_library
@pytest.mark.parametrize("values", SCENES, ids=str)
def test_compiled_loops_find_the_slips_that_loops_of_python_do(values, monkeypatch):
    """To 1e-9 nm; to 1e-7 under a held load, where the tolerance of the residual moves a fold by more."""
    found = loads_of(values)
    assert found or "law" in values  # that one slides smoothly
    monkeypatch.setenv("SOLVER_LOOPS", "python")
    assert loads_of(values) == pytest.approx(found, abs=1e-7 if "hold" in values else 1e-9)


@needs_library
@pytest.mark.parametrize("values", SCENES, ids=str)
def test_a_motion_moves_alike_in_both_loops_and_counts_its_steps(values, monkeypatch):
    """Round-off of 40 steps is below 1e-12 of the largest coordinate."""
    scene = Scene(**values | {"damping": 1.0})
    y, evaluations = moved(scene)
    monkeypatch.setenv("SOLVER_LOOPS", "python")
    expected, counted = moved(scene)
    assert np.abs(y - expected).max() < 1e-11 * np.abs(expected).max()
    assert evaluations == counted


@needs_library
def test_compiled_transforms_are_those_of_numpy(monkeypatch):
    for length in (1, 2, 30, 127, 1024):
        for loops in ("", "python"):
            monkeypatch.setenv("SOLVER_LOOPS", loops)
            transform = Transform(length)
            assert (transform.plans is None) == (loops == "python")
            x = np.random.default_rng(0).normal(size=(2, length))
            transform.field[:] = x
            transform.forward()
            assert transform.spectrum == pytest.approx(np.fft.rfft(x, axis=1), abs=1e-12 * length)
            transform.backward()
            assert transform.product == pytest.approx(length * x, abs=1e-12 * length)


def test_contacts_of_several_sizes_used_in_turn_keep_their_data_apart():
    scenes = [Scene(**SMALL), Scene(**SMALL | {"nodes": 90, "E": 30.0}), Scene(**SMALL | {"surface": "rough"})]
    problems = [Equilibrium(Contact(scene, *patch(scene)), sideways(1.0, -scene.delta)) for scene in scenes]
    for _ in range(2):
        for scene, problem in zip(scenes, problems, strict=True):
            alone = Equilibrium(Contact(scene, *patch(scene)), sideways(1.0, -scene.delta))
            v, r, expected = problem.undeformed(1.0), np.empty(problem.size), np.empty(problem.size)
            problem.residual(v, 1.0, r)
            alone.residual(v, 1.0, expected)
            assert np.array_equal(r, expected)


def test_unknowns_that_are_not_next_to_each_other_have_the_same_residual():
    scene = Scene(**SMALL)
    problem = Equilibrium(Contact(scene, *patch(scene)), sideways(1.0, -scene.delta))
    v, r, expected = np.zeros((problem.size, 2)), np.empty(problem.size), np.empty(problem.size)
    v[:, 0] = np.random.default_rng(0).normal(size=problem.size)
    problem.residual(v[:, 0].copy(), 1.0, expected)
    problem.residual(v[:, 0], 1.0, r)
    assert np.array_equal(r, expected)


def test_threads_find_the_slips_of_one():
    """To 1e-9 nm, as round-off depends on where arrays lie. Each thread makes and drops plans while others do."""
    values = [SMALL | {"E": E} for E in (60.0, 70.0, 80.0, 90.0)]
    with ThreadPoolExecutor(4) as threads:
        for one, found in zip(values, threads.map(loads_of, values), strict=True):
            assert found == pytest.approx(loads_of(one), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_processes_find_the_slips_of_this_one(method):
    """To 1e-9 nm, as above."""
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system has no {method}")
    with ProcessPoolExecutor(1, multiprocessing.get_context(method)) as pool:
        assert pool.submit(loads_of, SMALL).result() == pytest.approx(loads_of(SMALL), abs=1e-9)


def test_a_film_has_every_step_of_a_motion():
    scene = Scene(**SMALL)
    contact = Contact(scene, *patch(scene))
    problem, contact.observe = Equilibrium(contact, sideways(1.0, -scene.delta)), Camera(None)
    assert problem.motion().compiled(1.0) is None


def test_an_observer_that_raises_ends_compiled_loops():
    scene = Scene(**SMALL)
    contact = Contact(scene, *patch(scene))
    problem, dynamics = Equilibrium(contact, sideways(1.0, -scene.delta)), None

    def observe(*_):
        raise KeyboardInterrupt

    dynamics = problem.motion()
    motion = Motion(dynamics, dynamics.start(problem.undeformed(1.0), 1.0), 1.0, 1.0, closed_stiffness(scene))
    motion.soften(1.0)
    contact.observe = observe
    with pytest.raises(KeyboardInterrupt):
        motion.advance(8)


def test_the_exponential_of_the_kernels_is_that_of_numpy():
    """To two units in the last place."""
    x = np.concatenate((np.linspace(-708.0, 708.0, 20_001), np.linspace(-1.0, 1.0, 20_001), [0.0]))
    assert np.array([_exp(one) for one in x]) == pytest.approx(np.exp(x), rel=4.5e-16, abs=0.0)
    assert np.isnan(_exp(np.nan))


def test_without_compiled_code_python_makes_the_loops():
    """As a debugger needs it: NUMBA_DISABLE_JIT=1 ended in an error of Numba about an intrinsic."""
    code = (
        "from solver import Scene, simulate; print(simulate(Scene(nodes=16, width=40.0, u_x_max=0.5)).failure or 'ran')"
    )
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", code]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True, env=environment)
    assert shown.stdout.strip() == "ran"
