"""The judge of rest, against known answers: two unknowns, dense eigenvalues, closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import spectrum

from solver import Scene, SceneError, simulate
from solver.accuracy.report import notes
from solver.cautions import flutter
from solver.continuation.rest import Judge, rate
from solver.run.loadpath import Checkpoint, Run, load_path

SOFT = Scene(E=10.0, delta_bar=0.6, phi_ratio=0.3, u_x_max=22.4)
FLUTTER = 22.2727767  # nm, its first slip: where the largest growth of dense eigenvalues, as in `spectrum`, vanishes


class Spinner:
    """x'' = M x - gamma x' with M = -k + s (0 1; -1 0), k the least stiffness: flutter at s^2 = gamma^2 k."""

    size, unit, critical = 2, 1.0, 2.0  # k = 1

    def __init__(self, turn, k=1.0):
        self.matrix = np.array([[-k, turn], [-turn, -k]])

    def motion(self):
        return self

    def linearised(self, v):
        return SimpleNamespace(size=2, product=lambda x: self.matrix @ x, seen=np.copy, waves=lambda: None)


def judged(problem, damping):
    return Judge(damping).rightmost(problem, np.zeros(2))


@pytest.mark.parametrize("damping", [0.5, 1.0, 3.0])
def test_a_system_of_two_unknowns_flutters_where_predicted(damping):
    onset = 2.0 * damping
    below, above = judged(Spinner(0.999 * onset), damping), judged(Spinner(1.001 * onset), damping)
    assert below.rests and not above.rests
    assert above.kind == "flutter"
    assert judged(Spinner(onset), damping).growth == pytest.approx(0.0, abs=1e-12)


def test_two_unknowns_never_flutter_overdamped_but_fold():
    assert judged(Spinner(100.0), np.inf).growth == pytest.approx(-1.0)
    fold = judged(Spinner(0.0, -0.1), np.inf)
    assert fold.growth == pytest.approx(0.1) and fold.kind == "bifurcation"


def states(scene, every, start=0):
    """(frame, problem, state) of every so many increments from `start` on."""
    run, checkpoint, k = Run(scene), Checkpoint(), 0
    while not checkpoint.done:
        frame, checkpoint = run.next_frame(checkpoint)
        k += 1
        problem, state = run.stepper.problem, checkpoint.state
        near = state.v.size == problem.size and problem.contact.distance(problem.surface(state.v)) < scene.delta_0
        if k >= start and k % every == 0 and near:
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
        true = spectrum.growth(scene, frame, held)
        found = Judge(scene.damping).rightmost(problem, state.v).growth
        gamma = spectrum.friction(scene)
        assert (found > 1e-6) == (true > 1e-6) or abs(true) < 1e-5 * gamma
        if abs(true) < 0.05 * gamma:
            assert found == pytest.approx(true, abs=1e-6 * gamma)
        seen += 1
    assert seen >= 5


CELL = Scene(
    nodes=128, width=312.5, radius=10.0, u_x_max=12.0, delta_bar=1.0
)  # all mu are computed where waves may flutter


@pytest.mark.slow
def test_in_a_small_cell_waves_that_weak_damping_lets_grow_are_found():
    scene, found = CELL.changed(damping=0.2), []
    gamma = spectrum.friction(scene)
    for frame, problem, state in states(CELL, 12):  # of a run at critical damping: they rest there
        true = spectrum.growth(scene, frame)
        mode = Judge(0.2).rightmost(problem, state.v)
        assert mode.growth == pytest.approx(true, abs=1e-4 * gamma) or max(mode.growth, true) < -0.2 * gamma
        found.append(mode.growth)
    assert len(found) >= 5 and max(found) > 0.0


@pytest.mark.slow
def test_frames_that_may_flutter_are_marked_and_others_do_not_flutter():
    """By dense spectra of the same states under other damping; cells of that size are not searched for waves."""
    flutters = 0
    scene = Scene(nodes=160, width=390.6, u_x_max=9.0, delta_bar=2.0, phi_ratio=0.1, du_x=0.3)
    for frame in [*load_path(scene)][-20::5]:
        for damping in (0.2, 0.3, 0.5, 0.8):
            grows = spectrum.growth(frame.scene.changed(damping=damping), frame) > 1e-6
            assert not grows or damping < frame.safe_damping
            flutters += grows
    assert flutters > 0


def test_damping_that_lets_nearly_everything_flutter_is_refused_with_the_reason():
    with pytest.raises(SceneError, match=r"damping = 0\.1: allowed: 0\.2 \.\. 4 or inf .*flutter.*; give a number"):
        Scene(damping=0.1)


@pytest.mark.slow
def test_the_mode_is_one_of_the_whole_surface():
    _, problem, state = list(states(SOFT.changed(u_x_max=22.2), 20, 300))[-1]
    stability = Judge(1.0).rightmost(problem, state.v)
    assert stability.kind == "flutter" and stability.rests
    assert stability.x.shape == state.v.shape


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("du_x", [0.2, 0.1])
def test_a_soft_layer_slips_where_it_flutters_whatever_the_increment(du_x):
    events = [e for f in load_path(SOFT.changed(du_x=du_x, u_x_max=22.4)) for e in f.slips if f.stage == "shear"]
    assert events[0].kind == "flutter" and events[0].located
    assert events[0].load == pytest.approx(FLUTTER, abs=1e-6)


def test_waves_cannot_flutter_on_the_default():
    for frame in load_path(Scene(u_x_max=10.0)):
        assert frame.safe_damping < 0.5 and not frame.may_flutter


def test_stability_searches_reuse_the_previous_one_and_are_skipped_after_small_changes():
    *_, (_, problem, state) = states(Scene(u_x_max=9.0), 10)
    judge = Judge(1.0)
    begun = problem.evaluations
    known = judge.rightmost(problem, state.v)
    before = problem.evaluations
    near = replace(known, margin=0.2)  # as next to a fold, where a state may not go far without a look
    looked = judge.accept(problem, state.v + 0.25, near)
    assert looked.rests and 0 < problem.evaluations - before < before - begun
    before = problem.evaluations
    assert judge.accept(problem, state.v + 0.26, looked) is looked
    assert problem.evaluations == before


def test_stability_of_a_flat_uses_the_blocks_of_all_waves():
    scene = Scene(surface="flat", u_x_max=6.0, nodes=64, width=156.25)
    for frame, problem, state in states(scene, 30):
        assert problem.linearised(state.v).waves() is not None
        found = Judge(1.0).rightmost(problem, state.v).growth
        assert found == pytest.approx(spectrum.growth(scene, frame), abs=1e-12)


def test_growth_rates_solve_the_quadratic():
    assert rate(-1.0, 2.0) == pytest.approx(-1.0)
    assert rate(0.0, 2.0) == 0.0
    assert rate(3.0 + 1j, np.inf) == 3.0


def test_the_accuracy_report_says_where_waves_may_flutter():
    scene = Scene(damping=0.3)
    (sentence,) = flutter(scene, 0.4)
    assert "Use 0.4 or more" in sentence and flutter(scene, 0.3) == []
    report = SimpleNamespace(scene=scene, reference=scene, safe_damping=0.4, seconds=1.0, slips=1, quick=True)
    assert sentence in notes(report)


@pytest.mark.parametrize("damping", [2.0, 4.0])
def test_much_damping_costs_no_searches_along_a_branch(damping):
    """States of a branch do not depend on the damping, and above critical their growths differ by its scale only."""
    scene = Scene(u_x_max=10.0)
    spent = [
        sum(f.evaluations for f in load_path(scene.changed(damping=value)) if f.stage == "shear")
        for value in (1.0, damping)
    ]
    # a single search takes some 15 evaluations more or less, of about 600; a search in every increment doubles them
    assert spent[1] < 1.1 * spent[0]


@pytest.mark.filterwarnings("error")
def test_a_stiff_layer_without_friction_is_judged_without_a_warning_of_numpy():
    """A pair as good as growing has no depth: the doubt about it is infinite, and was an overflow."""
    pressed = {"delta_bar": 30.0, "du_x": 1.0, "du_z": 1.0, "u_x_max": 1.0}
    stiff = Scene(E=488700.0, phi_ratio=0.0, nu=0.4999, nodes=256, width=624.64, damping=0.5, **pressed)
    assert simulate(stiff, limit=4.0).frames
