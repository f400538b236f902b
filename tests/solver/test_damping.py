"""Slips below critical damping."""

from itertools import pairwise

import pytest
from helpers import same, stage
from spectrum import growth

from solver import Scene, advance, load_path

SMALL = Scene(nodes=128, width=320.0, radius=1.0, du_z=0.2, du_x=0.2)


def sites(scene, method="fast"):
    """By how many sites the contact moves in each slip of the shear: the largest displacement of a node."""
    shear = stage(list(load_path(scene, method)), "shear")
    moved = [(b.u[0] - a.u[0]).max() for a, b in pairwise(shear) if b.slip]
    return [round(float(m) / scene.spacing) for m in moved]


@pytest.mark.thorough
@pytest.mark.slow
def test_inertia_carries_one_slip_over_two_sites():
    scene = Scene(u_x_max=16.5)
    assert sites(scene) == [1, 1, 1]
    assert sites(scene.changed(damping=0.25)) == [2, 2]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_slip_with_inertia_is_one_slip():
    """Started too close to the end of the branch, the motion would fall back, and slip at the next increment."""
    shear = stage(list(load_path(Scene(u_x_max=13.0, hold="load", damping=0.25))), "shear")
    slips = [f.slips for f in shear if f.slip]
    assert [len(s) for s in slips] == [1, 1] and sites(Scene(u_x_max=13.0, hold="load", damping=0.25)) == [1, 1]
    assert slips[1][0].load - slips[0][0].load == pytest.approx(Scene().spacing, abs=1e-6)


@pytest.mark.slow
def test_at_critical_damping_the_reference_method_slips_as_the_fast_one():
    scene = SMALL.changed(u_x_max=5.0)
    fast, gfmd = (list(load_path(scene.changed(damping=1.0), method)) for method in ("fast", "gfmd"))
    assert any(f.slip for f in stage(fast, "shear"))
    assert all(same(a, b, 1e-6) for a, b in zip(fast, gfmd, strict=True))


@pytest.mark.slow
def test_below_critical_damping_branches_are_the_same_and_only_slips_differ():
    scene = SMALL.changed(u_x_max=3.0)
    for a, b in zip(load_path(scene), load_path(scene.changed(damping=0.2)), strict=True):
        assert same(a, b, 1e-6)


@pytest.mark.thorough
@pytest.mark.slow
def test_too_little_damping_is_named_in_the_message_unless_every_frame_is_an_equilibrium():
    """NP1 has no potential: with hardly any damping it may feed an oscillation for ever; then no frame is made up."""
    scene = Scene(u_x_max=3.0, delta_bar=1.0, damping=0.2, nodes=128, width=312.5)
    frames, checkpoint = [], None
    while checkpoint is None or not checkpoint.done:
        more, checkpoint = advance(scene, checkpoint)
        frames += more
    assert checkpoint.failure is None or "try a damping larger than 0.2" in checkpoint.failure
    assert all(growth(scene, f) < 1e-6 for f in frames[::5] + frames[-5:])
