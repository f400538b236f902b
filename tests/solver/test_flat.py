"""Flat on flat: all nodes move alike, and one scalar equation G/h (U_x - u) = -T(u) is the exact answer."""

from math import inf

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from spectrum import growth

from solver import Scene, load_path
from solver.mechanics.cohesive_law import tangent, traction
from solver.mechanics.layer import Modes


class OneNode:
    """Prandtl-Tomlinson: the load U_x under which a node rests at u, and where that has its maximum."""

    def __init__(self, scene):
        self.a, self.scene = scene.spacing, scene
        self.flexibility = scene.height * scene.width / scene.shear_modulus
        self.top = minimize_scalar(
            lambda u: -self.load(u), bounds=(0, self.a / 2), method="bounded", options={"xatol": 1e-12}
        )
        self.u_fold, self.fold = self.top.x, -self.top.fun

    def pull(self, u):
        dt = (np.arange(-20, 21) * self.a - u) / self.scene.delta_t
        return -2.0 * self.scene.phi_t / self.scene.delta_t * np.sum(dt * np.exp(-(dt**2)))

    def load(self, u):
        return u + self.pull(u) * self.flexibility

    def rest(self, U_x):
        """Where the node rests after as many slips as there were folds below U_x."""
        slips = max(0, int(np.ceil((U_x - self.fold) / self.a)))
        low = slips * self.a - (self.a / 2 if slips else 1e-9)
        # from the fold before, the node has moved on to the first rest behind it
        return brentq(lambda u: self.load(u) - U_x, low, slips * self.a + self.u_fold, xtol=1e-14)


@pytest.mark.parametrize("values", [{"phi_ratio": 0.1}, {"phi_ratio": 0.1, "E": 140.0}, {"phi_ratio": 0.05}])
def test_stick_slip_follows_one_node_folds_included(values):
    scene = Scene(surface="flat", tolerance=1e-11, damping=inf, **values)
    node = OneNode(scene)
    shear = [f for f in load_path(scene) if f.stage == "shear"]
    folds = [event.load for f in shear for event in f.slips]
    expected = np.arange(len(folds)) * scene.spacing + node.fold
    assert len(folds) == int(np.floor((scene.u_x_max - node.fold) / scene.spacing)) + 1
    assert folds == pytest.approx(expected, abs=1e-8)
    for frame in shear:
        u = node.rest(frame.U_x)
        assert np.abs(frame.u[0] - u).max() < 1e-8
        assert frame.F_bar == pytest.approx(node.pull(u) / scene.E, rel=1e-8, abs=1e-14)
        assert np.abs(frame.u[1]).max() < 1e-8


def test_weak_friction_slides_continuously():
    """Below max dT/du = G/h the load has no maximum: no slip, and the force returns to zero twice per period."""
    scene = Scene(surface="flat", phi_ratio=0.001, u_x_max=8.0)
    shear = [f for f in load_path(scene) if f.stage == "shear"]
    assert not any(f.slip for f in shear)
    force = np.array([f.F_bar for f in shear])
    assert np.count_nonzero(np.diff(np.sign(force[1:]))) >= 6
    assert force.mean() == pytest.approx(0.0, abs=0.1 * force.max())


def test_stiffer_layer_drops_more_force_at_a_slip():
    drops = []
    for E in (70.0, 140.0):
        scene = Scene(surface="flat", phi_ratio=0.1, E=E, u_x_max=18.0, damping=inf)
        shear = [f for f in load_path(scene) if f.stage == "shear"]
        k = next(i for i, f in enumerate(shear) if f.slip)
        drops.append((shear[k - 1].F_bar - shear[k].F_bar) * E)
    assert drops[1] > 1.8 * drops[0]


@pytest.mark.parametrize(
    "values", [{"height": 0.016, "nodes": 1000, "du_x": 0.5}, {"u_x_max": 400.0, "du_x": 1.0}], ids=["thin", "far"]
)
def test_a_pressed_flat_completes_its_run(values):
    """Also at loads so large that the finest step of the load is below their round-off."""
    scene = Scene(surface="flat", delta_bar=0.5, **values)
    frames = list(load_path(scene))
    assert frames[-1].U_x == pytest.approx(scene.u_x_max)
    assert max(f.residual for f in frames) <= scene.tolerance
    loads = [slip.load for f in frames if f.stage == "shear" for slip in f.slips]
    assert np.diff(loads).min(initial=np.inf) > 0.5 * scene.spacing


@pytest.mark.once(2)
@pytest.mark.parametrize("du_z", [0.1, 0.05])
@pytest.mark.parametrize(
    "values", [{"nodes": 128, "width": 312.5, "E": 5.0, "nu": 0.49, "phi_ratio": 0.0}, {"nu": 0.49}, {"height": 0.3}]
)
def test_waves_that_need_all_nodes_are_the_located_end_of_a_branch(values, du_z):
    """The uniform state is unstable where a 2 x 2 block of K - J is singular for some wave: known in closed form."""
    scene = Scene(surface="flat", u_x_max=0.0, du_z=du_z, **values)
    first = next(event for f in load_path(scene) for event in f.slips)
    assert (first.kind, first.located) == ("bifurcation", True)
    (k_xx, k_zz, k_c), C_zz = Modes.of(scene).stiffness, Modes.of(scene).compliance[1, 0]

    def margin(gap):
        J_xx, _, _, J_zz = tangent(scene, 0.0, gap)
        return (J_zz - k_zz + k_c**2 / (k_xx - J_xx)).max()

    gap = brentq(margin, 2.0 * scene.delta_n, 9.0 * scene.delta_n, xtol=1e-13)  # attraction is steepest at 2 delta_n
    assert first.load == pytest.approx(C_zz * traction(scene, 0.0, gap)[1] - gap, abs=1e-6)


def test_a_flat_that_flutters_in_a_wave_slips_there_and_lands_in_a_stable_state():
    """With little damping a wave flutters before any fold.

    The next slip is an image of the first: whole sites farther on, to the accuracy of a located end, 1e-6 nm.
    """
    scene = Scene(surface="flat", nodes=64, width=64 * 2.44, du_z=0.5, du_x=0.5, u_x_max=20.0, damping=0.2)
    frames = list(load_path(scene))
    first, second = [event for f in frames for event in f.slips]
    assert first.kind == second.kind == "flutter" and first.located and second.located
    sites = (second.load - first.load) / scene.spacing
    assert sites == pytest.approx(round(sites), abs=1e-6) and round(sites) >= 1
    assert max(growth(scene, f) for f in frames) < 0.0
