"""Each remedy that the message of a failed run names is followed, and works."""

import re
from time import thread_time

import numpy as np
import pytest

from solver import Scene, SceneError, advance, simulate
from solver.cautions import cautions
from solver.mechanics.surface import least_modulus, too_soft

SMALL = Scene(nodes=64, width=160.0, radius=0.6, du_x=0.5, du_z=0.5)
WAVE, FLAT = {"surface": "wave", "amplitude": 1.0}, {"surface": "flat", "width": 156.25}
KINDS = [{}, FLAT, WAVE, {"phi_n": 20.0}, {"nu": 0.3, "height": 0.2}]


@pytest.mark.once(2)
@pytest.mark.parametrize("values", KINDS, ids=str)
def test_surfaces_rest_apart_where_the_approach_begins_from_the_least_modulus_on(values):
    """At 0.6 of it the surface has fallen into contact: the formula is exact for a uniform gap and exp(u/delta_n)."""
    scene = SMALL.changed(**values)
    least = least_modulus(scene)
    assert least == pytest.approx(least_modulus(scene.changed(E=2.0)), rel=1e-9)
    apart, fallen = (
        advance(scene.changed(E=share * least, tolerance=1e-6), budget=0.0, limit=10.0)[0] for share in (1.0, 0.6)
    )
    assert apart[0].gap.min() > 9.0 * scene.delta_n
    assert not fallen or fallen[0].gap.min() < scene.delta_n


def test_a_layer_too_soft_to_begin_is_named_before_and_after_with_a_modulus_that_serves():
    soft = SMALL.changed(E=0.03, tolerance=1e-6)
    (said,) = (each for each in cautions(soft) if "where the approach begins" in each.lower())
    failed = simulate(soft, limit=0.05)
    assert not failed.frames and "draws so soft a layer into contact where the approach begins" in failed.failure
    for text in (said, failed.failure):
        E = float(re.search(r"use E=([\d.]+) or more", text, re.I)[1])
        assert simulate(soft.changed(E=E, delta_bar=-0.9, u_x_max=0.0)).failure is None


def test_a_drive_too_soft_to_begin_is_named_and_a_stiffer_one_serves():
    driven = SMALL.changed(drive_n=1e-3, tolerance=1e-6)
    assert too_soft(driven) == "use a larger drive_n, or a smaller phi_n"
    for remedied in (driven.changed(drive_n=10.0), driven.changed(phi_n=1e-3)):
        assert not too_soft(remedied) and simulate(remedied.changed(delta_bar=-0.9, u_x_max=0.0)).failure is None


def test_more_damping_serves_a_motion_that_does_not_come_to_rest():
    scene = Scene(
        delta_bar=0.41, u_x_max=20.0, damping=0.3, du_x=1.0, du_z=1.0, radius=1.95, phi_ratio=0.62, E=4.346, width=40.0,
        nodes=16,
    )  # fmt: skip
    failed = simulate(scene)
    if failed.failure:  # whether a flutter ends depends on the last digits
        assert failed.outcome == "restless" and "try a damping larger than 0.3" in failed.failure
    assert simulate(scene.changed(damping=1.0)).failure is None


@pytest.mark.parametrize("values", [{"drive_n": 1e-3}, {"E": 0.02, "nodes": 512}, {"phi_n": 900.0}], ids=str)
def test_the_least_tolerance_that_a_refusal_names_is_allowed(values):
    with pytest.raises(SceneError, match="by round-off") as refused:
        SMALL.changed(tolerance=1e-12, **values)
    least = float(re.search(r"allowed: ([\d.e-]+) \.\.", str(refused.value))[1])
    assert SMALL.changed(tolerance=least, **values).tolerance == least


@pytest.mark.slow
@pytest.mark.thorough
def test_extreme_scenes_end_with_an_outcome_and_a_remedy_within_their_limit():
    """60 scenes; an increment is interrupted between two force evaluations, or two searches for a mode."""
    rng, limit, seen = np.random.default_rng(66), 0.5, set()
    for _ in range(60):
        E, phi_ratio = np.exp(rng.uniform(*np.log([(0.02, 0.02), (2000.0, 30.0)]))).tolist()
        nodes, delta_bar = int(2.0 ** rng.uniform(6.0, 12.0)), float(rng.uniform(-0.6, 1.0))
        scene = Scene(
            E=E, phi_ratio=phi_ratio, nodes=nodes, width=2.44 * nodes, delta_bar=delta_bar, tolerance=1e-5
        )  # fmt: skip
        begun = thread_time()
        result = simulate(scene, limit=limit)
        assert thread_time() - begun < 4.0 * limit, scene
        assert result.outcome.reached or re.search(r"; (try|allow|the attraction)", result.failure), result.failure
        seen.add(result.outcome)
    assert {"finished", "out of time"} <= seen
