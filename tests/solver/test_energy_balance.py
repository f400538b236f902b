"""Where the work of the top goes: stored, taken by the interface, released in slips."""

from itertools import pairwise
from math import inf

import numpy as np
import plain_gfmd
import pytest
from energy import balance_of, layer_energy
from plain_gfmd import Plain
from scipy.optimize import brentq, minimize_scalar

from solver import Scene, load_path, whole_surface

FLAT = Scene(surface="flat", phi_ratio=0.1, nodes=64, width=160.0, height=16.0, tolerance=1e-10, damping=inf)
PUNCH = Scene(nodes=128, width=320.0, radius=1.0, du_z=0.2, tolerance=1e-9)


def ends(frames):
    """{stage: index of its last frame}."""
    return {f.stage: k for k, f in enumerate(frames)}


def potential(scene, u):
    """Energy of one node's springs at dn = 0, GPa nm: minus the integral of T_x (at one gap there is one)."""
    dt = (np.arange(-20, 21) * scene.spacing - u) / scene.delta_t
    return -scene.phi_t * np.sum(np.exp(-(dt**2)))


def sawtooth(scene):
    """Work of one period of flat-on-flat sliding, nN: the fall of energy from the fold to the next rest.

    All nodes move alike: E(u, U) = (U - u)^2/(2 c) + potential(u) per area, c = h/G.
    """
    c = scene.height * scene.width / scene.shear_modulus

    def pull(u):
        return (potential(scene, u + 1e-5) - potential(scene, u - 1e-5)) / 2e-5

    top = minimize_scalar(lambda u: -(u + c * pull(u)), bounds=(0, scene.spacing / 2), method="bounded",
                          options={"xatol": 1e-10})  # fmt: skip
    fold, load = top.x, -top.fun
    rest = brentq(lambda u: u + c * pull(u) - load, scene.spacing / 2, scene.spacing + fold - 1e-6, xtol=1e-13)
    energy = [(load - u) ** 2 / (2.0 * c) + potential(scene, u) for u in (fold, rest)]
    return (energy[0] - energy[1]) * scene.width


def periods(scene, per_period, count=2):
    """(Frames of shear with so many increments to a period, index of the first of the last `count` periods)."""
    scene = scene.changed(du_x=scene.spacing / per_period / scene.delta_t)
    frames = [f for f in load_path(scene) if f.stage == "shear"]
    return scene, frames, len(frames) - 1 - count * per_period


def test_the_springs_energy_is_the_integral_of_their_traction():
    """What `sawtooth` rests on, against the solver's own law."""
    from solver.mechanics.cohesive_law import traction

    u = np.linspace(0.0, FLAT.spacing, 2001)
    T = traction(FLAT, u, np.zeros_like(u))[0]
    fall = -np.concatenate(([0.0], np.cumsum(0.5 * (T[1:] + T[:-1]) * np.diff(u))))
    # |dt| <= 5 delta_t: what lies outside is e^-25; the trapezoid leaves 1e-7
    assert fall == pytest.approx([potential(FLAT, x) - potential(FLAT, 0.0) for x in u], abs=1e-6 * FLAT.phi_t)


def test_dissipation_per_slip_is_the_area_of_the_sawtooth():
    """Flat on flat, against Prandtl-Tomlinson in closed form; the error falls as du^1.5, as F ends in a square root."""
    exact, off = sawtooth(FLAT.changed(u_x_max=30.0)), []
    for per_period in (25, 100):
        _, frames, first = periods(FLAT.changed(u_x_max=30.0), per_period)
        assert sum(len(f.slips) for f in frames[first + 1 :]) == 2
        work = balance_of(frames)
        off.append(abs((work.top[-1] - work.top[first]) / 2.0 / exact - 1.0))
    assert off[0] < 2e-3 and off[1] < off[0] / 7.0


@pytest.mark.parametrize("values", [{}, {"delta_bar": 0.2}, {"hold": "load", "delta_bar": 0.2}])
def test_work_of_the_top_over_a_sliding_period_equals_the_energy_released_in_slips(values):
    """The layer's energy repeats, so that W = R - S; and W is the area under the sawtooth of F."""
    scene, frames, first = periods(PUNCH.changed(u_x_max=14.0, **values), 25)
    assert sum(len(f.slips) for f in frames[first + 1 :]) == 2
    work = balance_of(frames)
    paid, stored, given, released = (
        series[-1] - series[first] for series in (work.top, work.stored, work.surface, work.released)
    )
    assert paid > 0.0 and released > 0.0
    assert abs(stored) < 1e-6 * paid
    # a residual of 1e-9 nm in u leaves 1e-9 nm times the force of work in every increment
    assert paid == pytest.approx(released - given, rel=1e-6)
    area = sum_of_sawteeth(frames[first:]) * scene.E * scene.width
    assert paid == pytest.approx(area, rel=1e-3)


def sum_of_sawteeth(frames):
    """Area under F over U_x by hand: straight lines between frames, broken at the loads of the slips."""
    points = []
    for frame in frames:
        points += [(e.load, e.F_bar, e.load, frame.F_bar) for e in frame.slips] if points else []
        points.append((frame.U_x, frame.F_bar, frame.U_x, frame.F_bar))
    return sum(0.5 * (b[0] - a[2]) * (a[3] + b[1]) for a, b in pairwise(points))


def dissipated(scene):
    """What friction takes from the motion through the first slip of the shear, nN, by the plain GFMD.

    gamma times the sum of u'^2 over its Verlet steps, gamma^2 u'^2/gamma where it is overdamped, node by node.
    """
    before, frame = None, None
    for frame in load_path(scene):
        if frame.stage == "shear" and frame.slip:
            break
        before = frame
    plain, lost = Plain(scene, 0.25, tolerance=1e-7), 0.0
    friction = 2.0 * scene.damping * np.sqrt(plain.k_min)
    stepped, step = plain_gfmd.move, plain._step

    def counted(modes, motion, spectrum, K, push, keep, U_x, U_z):
        nonlocal lost
        stepped(modes, motion, spectrum, K, push, keep, U_x, U_z)
        moved = np.fft.irfft(motion, plain.n, norm="forward")
        lost += friction * float(np.sum(moved**2)) / counted.step

    def known(K, steepest, fraction):
        found = step(K, steepest, fraction)
        counted.step = found[0]
        return found

    plain._step = known
    plain_gfmd.move = counted
    try:
        plain.rest(whole_surface(before), frame.slips[0].load + 1e-3, -scene.delta)
    finally:
        plain_gfmd.move = stepped
    return lost * scene.spacing


@pytest.mark.parametrize(
    ("scene", "least", "most"),
    [
        # at dn = 0 everywhere NP1 has a potential: nothing is lost. 2%: first-order sums on either side
        (FLAT.changed(u_x_max=100.0, damping=1.0), -0.02, 0.02),
        # gaps that change: around a closed path the tractions do work, here on the side of the motion
        (PUNCH.changed(u_x_max=14.0, delta_bar=0.2), 0.0, 0.1),
    ],
)
def test_dissipation_differs_from_the_work_of_the_top_only_by_the_work_of_the_law(scene, least, most):
    """NP1 has no energy, so that its tractions may do work along the closed path branch, slip, some sites on."""
    fine = scene.changed(du_x=scene.spacing / 50 / scene.delta_t)
    frames = [f for f in load_path(fine) if f.stage == "shear"]
    ends = [k for k, f in enumerate(frames) if f.slip]
    period = ends[2] - ends[1]
    work = balance_of(frames)
    paid = work.top[ends[1] + period - 1] - work.top[ends[1] - 1]
    assert least < dissipated(scene) / paid - 1.0 < most


def test_energy_of_a_jump_to_the_held_load_counts_as_released():
    """A saddle under the held load: the surfaces jump into contact at U_x = 0, and energy is lost there."""
    scene = Scene(hold="load", delta_bar=-0.5, u_x_max=1.0, nodes=512, width=1250.0, radius=5.0)
    frames = list(load_path(scene))
    jump = next(k for k, frame in enumerate(frames) if frame.stage == "shear")
    work, before = balance_of(frames), frames[jump - 1]
    assert frames[jump].slip and abs(frames[jump].delta - before.delta) > scene.delta_n  # the premise
    assert work.surface[jump] == work.surface[jump - 1]
    assert work.released[jump] != work.released[jump - 1]
    # between all other frames the two accounts of the work agree to the residual, as they do without a jump
    assert np.abs(work.defect).max() < 1e-6 * np.abs(work.top).max()


@pytest.mark.parametrize("values", [{}, {"hold": "load", "delta_bar": 0.2}])
def test_two_energy_balances_agree_over_a_friction_loop(values):
    """The state repeats, so the layer stores nothing: what the top does is what slips release and springs give back."""
    scene = PUNCH.changed(path="loop", u_x_max=8.0, du_x=0.2, **values)
    frames = list(load_path(scene))
    work, end = balance_of(frames), ends(frames)
    loop = [
        series[end["forth"]] - series[end["shear"]] for series in (work.top, work.stored, work.surface, work.released)
    ]
    top, stored, surface, released = loop
    slips = sum(len(f.slips) for f in frames[end["shear"] + 1 :])
    assert top > 0.0 and slips >= 4
    assert abs(stored) < 1e-6 * top and top == pytest.approx(released - surface, rel=1e-6)


def test_energy_is_conserved_between_slips_up_to_the_residual():
    """W = E - S without slips: F and L, E and S are told by different sums, and agree as C is symmetric."""
    for values in ({}, {"hold": "load"}, {"path": "unload"}, {"path": "loop", "du_x": 0.7}):
        scene = PUNCH.changed(u_x_max=8.0, **values)
        work = balance_of(list(load_path(scene)))
        assert np.abs(work.defect).max() < 1e-6 * np.abs(work.top).max()


@pytest.mark.slow
def test_smooth_sliding_dissipates_nothing():
    """Flat on flat below Prandtl-Tomlinson's boundary: the force returns to zero, and so does the work, each period."""
    scene = FLAT.changed(phi_ratio=0.001, path="loop", u_x_max=10.0, du_x=FLAT.spacing / 50)
    frames = list(load_path(scene))
    end = ends(frames)
    assert not any(f.slip for f in frames[end["approach"] + 1 :])
    work = balance_of(frames)
    most = scene.phi_t * scene.width  # all springs stretched to the full
    assert abs(work.top[end["forth"]] - work.top[end["shear"]]) < 1e-9 * most
    start = end["approach"] + 1
    assert np.abs(work.top[start : end["shear"] : 50] - work.top[start]).max() < 1e-6 * most
    assert np.ptp(work.top[start : end["shear"]]) > 1e-2 * most


def test_elastic_energy_of_the_flat_is_that_of_a_sheared_block():
    """1/2 F (U - u) for all nodes alike."""
    frame = [f for f in load_path(FLAT.changed(u_x_max=3.0)) if f.stage == "shear"][-1]
    F = frame.F_bar * FLAT.E * FLAT.width
    assert layer_energy(frame) == pytest.approx(0.5 * F * (frame.U_x - frame.u[0, 0]), rel=1e-9)


@pytest.mark.parametrize("delta_bar", [-0.5, -0.4])
def test_dead_weight_does_work_in_the_jump_to_a_held_load(delta_bar):
    """The dead weight does work over the whole jump of delta, which no trapezoid of U_x shows."""
    scene = Scene(hold="load", delta_bar=delta_bar, u_x_max=0.5)
    frames = list(load_path(scene))
    k = next(k for k, f in enumerate(frames) if f.stage == "shear")
    assert [event.kind for event in frames[k].slips] == ["control"]
    work, way = balance_of(frames), frames[k].delta - frames[k - 1].delta
    assert work.top[k] - work.top[k - 1] == pytest.approx(frames[k].L * way, rel=1e-6)
    assert abs(np.diff(work.defect[k - 1 : k + 1])) < 1e-9 * abs(work.top[k])
