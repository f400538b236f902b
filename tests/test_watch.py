"""The watch on stability, against known answers: two unknowns, dense eigenvalues, closed forms."""

from types import SimpleNamespace

import numpy as np
import pytest

from solver import Scene
from solver.continuation.stability import Modes, Watch, rate
from solver.continuation.state import NotConverged, State
from solver.mechanics.disturbance import uniform_growth
from solver.run.loadpath import Checkpoint, Run, load_path
from solver.verification import spectrum

SOFT = Scene(E=10.0, delta_bar=0.6, phi_ratio=0.3, u_x_max=22.4)
FLUTTER = 22.2718524  # nm, its first slip; the fold of the branch lies at 22.4396


class Spinner:
    """x'' = M x - gamma x' with M = -k + s (0 1; -1 0), k the least stiffness: flutter at s^2 = gamma^2 k."""

    size, unit, critical = 2, 1.0, 2.0  # k = 1

    def __init__(self, turn, k=1.0):
        self.matrix = np.array([[-k, turn], [-turn, -k]])

    def motion(self):
        return self

    def disturbance(self, v, active):
        return SimpleNamespace(size=2, product=lambda x: self.matrix @ x, seen=lambda x: x)


def sure(problem, damping):
    return Watch(damping).sure(problem, np.zeros(2), np.ones(1, bool))


@pytest.mark.parametrize("damping", [0.5, 1.0, 3.0])
def test_two_unknowns_flutter_where_they_should(damping):
    onset = 2.0 * damping
    below, above = sure(Spinner(0.999 * onset), damping), sure(Spinner(1.001 * onset), damping)
    assert below.rests and not above.rests
    assert above.kind == "flutter"
    assert sure(Spinner(onset), damping).growth == pytest.approx(0.0, abs=1e-12)


def test_two_unknowns_never_flutter_overdamped_but_fold():
    assert sure(Spinner(100.0), np.inf).growth == pytest.approx(-1.0)
    fold = sure(Spinner(0.0, -0.1), np.inf)
    assert fold.growth == pytest.approx(0.1) and fold.kind == "bifurcation"


def states(scene, every, start=0):
    """(frame, problem, state) of every so many increments from `start` on."""
    run, checkpoint, k = Run(scene), Checkpoint(), 0
    while not checkpoint.done:
        frame, checkpoint = run.next_frame(checkpoint)
        k += 1
        problem, state = run._stepper.problem, checkpoint.state
        if k >= start and k % every == 0 and state.v.size == problem.size and state.active.any():
            yield frame, problem, state


SMALL = {"nodes": 192, "width": 468.75, "u_x_max": 12.0}


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize(
    "values",
    [
        {"radius": 10.0, "E": 20.0},
        {"radius": 10.0, "delta_bar": 0.3, "E": 10.0, "phi_ratio": 0.3},
        {"radius": 10.0, "hold": "load", "delta_bar": 0.2},
        {"surface": "rough", "delta_bar": 0.3},
        {"delta_bar": 1.0, "damping": 0.5},
    ],
)
def test_growth_near_zero_is_that_of_dense_eigenvalues(values):
    scene = Scene(**SMALL, **values)
    seen = 0
    for frame, problem, state in states(scene, 40):
        held = scene.hold == "load" and frame.stage != "approach"
        true = spectrum.critical(scene, frame, held, exact=True).growth
        found = Watch(scene.damping).sure(problem, state.v, state.active).growth
        gamma = spectrum.friction(scene)
        assert (found > 1e-6) == (true > 1e-6) or abs(true) < 1e-5 * gamma
        if abs(true) < 0.05 * gamma:
            assert found == pytest.approx(true, abs=1e-6 * gamma)
        seen += 1
    assert seen >= 5


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.05, 0.1, 0.3])
def test_waves_that_weak_damping_lets_grow_are_those_of_dense_eigenvalues(damping):
    scene, found = Scene(**SMALL, delta_bar=1.0), []
    gamma = spectrum.friction(scene.changed(damping=damping))
    for frame, problem, state in states(scene, 12):  # of a run at critical damping: they rest there
        true = spectrum.critical(scene.changed(damping=damping), frame, exact=True).growth
        growth = Watch(damping).sure(problem, state.v, state.active).growth
        if true > -0.2 * gamma:
            assert growth == pytest.approx(true, abs=1e-4 * gamma)
        else:  # need not be known better
            assert growth < -0.2 * gamma
        found.append(growth)
    assert len(found) >= 5 and (damping > 0.1 or max(found) > 0.1 * gamma)


MIDDLE = Scene(nodes=512, width=1250.0, u_x_max=12.0, delta_bar=0.2, phi_ratio=0.3, du_x=0.2)  # a patch of 251 nodes


def test_near_a_shift_the_disturbances_under_a_force_are_those_of_the_product():
    *_, (_, problem, state) = states(MIDDLE.changed(u_x_max=4.0), 10)
    maps = problem.motion().disturbance(state.v, state.active)
    assert maps.patch_size < maps.size == 1024
    rng = np.random.default_rng(1)
    f = rng.normal(size=maps.size) + 1j * rng.normal(size=maps.size)
    mu = complex(-0.3, 0.02) * maps.interface
    x = maps.shifted(mu)(f)
    assert maps.product(x.real) + 1j * maps.product(x.imag) - mu * x == pytest.approx(f, abs=1e-9 * np.abs(f).max())


@pytest.mark.once
@pytest.mark.slow
def test_waves_of_a_patch_within_a_larger_cell_are_those_of_dense_eigenvalues():
    scene, found = MIDDLE.changed(damping=0.05), []
    gamma = spectrum.friction(scene)
    for frame, problem, state in states(MIDDLE, 20):  # of a run at critical damping: they rest there
        if frame.stage == "shear":
            true = spectrum.critical(scene, frame, exact=True).growth
            found.append(Watch(0.05).sure(problem, state.v, state.active).growth)
            assert found[-1] == pytest.approx(true, abs=1e-3 * gamma)
    assert len(found) >= 3 and min(found) > 0.1 * gamma


@pytest.mark.slow
def test_no_frame_of_a_flat_that_little_damping_lets_flutter_is_taken_for_a_rest():
    scene = Scene(surface="flat", nodes=256, width=625.0, damping=0.05, du_x=0.5, du_z=0.5, u_x_max=8.0)
    with pytest.raises(NotConverged, match="flutters"):
        for frame in load_path(scene):
            assert spectrum.growth(scene, frame) < 1e-6


@pytest.mark.slow
def test_the_mode_is_one_of_the_whole_surface():
    _, problem, state = list(states(SOFT.changed(u_x_max=22.2), 20, 300))[-1]
    stability = Watch(1.0).sure(problem, state.v, state.active)
    assert stability.kind == "flutter" and stability.rests
    assert stability.mode.shape == state.v.shape


@pytest.mark.slow
@pytest.mark.parametrize("du_x", [0.1, 0.2])
def test_a_soft_layer_slips_where_it_flutters_whatever_the_increment(du_x):
    events = [e for f in load_path(SOFT.changed(du_x=du_x, u_x_max=22.4)) for e in f.slips if f.stage == "shear"]
    assert events[0].kind == "flutter" and events[0].located
    assert events[0].load == pytest.approx(FLUTTER, abs=1e-6)


def test_the_screen_excludes_waves_that_flutter_on_the_default():
    for _, problem, state in states(Scene(u_x_max=10.0), 40):
        assert problem.motion().disturbance(state.v, state.active).flutter(problem.motion().critical) < 0.5


def test_a_look_goes_on_from_the_one_before():
    scene = Scene(u_x_max=9.0)
    *_, (_, problem, state) = states(scene, 10)
    watch = Watch(1.0)
    first = watch.sure(problem, state.v, state.active)
    before = problem.evaluations
    known = State.at_rest(state.load, state.v, state.active)
    known.modes, known.secants = first.modes, state.secants
    again = watch.look(problem, state.v, state.active, state.load, known)
    assert again.rests
    assert problem.evaluations - before < 20


@pytest.mark.parametrize(
    ("growth", "rise", "way", "looked"),
    [
        (-0.5, 0.0, 0.15, False),
        (-0.5, 0.0, 0.25, True),
        (-0.35, 0.0, 0.15, False),
        (-0.35, 0.3, 0.15, False),
        (-0.35, 0.6, 0.15, True),
        (-0.2, 0.0, 0.06, True),
        (-0.2, 0.0, 0.04, False),
        (-0.05, 0.0, 0.1, True),
        (1e-9, 0.0, 1e-3, True),
    ],
)
def test_looks_get_the_denser_the_nearer_to_zero_growths_are_and_the_faster_they_rise(growth, rise, way, looked):
    """Growths in units of gamma, the way in nm from the state looked at last; a rise is one per nm."""
    *_, (_, problem, state) = states(Scene(u_x_max=9.0), 10)
    watch, scale, before = Watch(1.0), problem.motion().critical, problem.evaluations
    state.modes = Modes(growth * scale, state.v + 0.1 - way, speed=2.0, rise=rise * scale)
    watch.look(problem, state.v + 0.1, state.active, state.load + 0.1, state)
    assert (problem.evaluations > before) == looked


def test_a_flat_surface_is_judged_by_the_blocks_of_all_waves():
    scene = Scene(surface="flat", u_x_max=6.0)
    for frame, problem, state in states(scene, 30):
        uniform, waves = uniform_growth(problem, state.v, state.active, scene.damping)
        assert max(uniform, waves) == pytest.approx(spectrum.growth(scene, frame), abs=1e-12)
        assert Watch(1.0).sure(problem, state.v, state.active).growth == pytest.approx(uniform, abs=1e-12)


def test_rates_of_the_quadratic():
    assert rate(-1.0, 2.0) == pytest.approx(-1.0)
    assert rate(0.0, 2.0) == 0.0
    assert rate(3.0 + 1j, np.inf) == 3.0
