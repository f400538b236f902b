"""Flat on flat: all nodes move alike, and one scalar equation G/h (U_x - u) = -T(u) is the exact answer."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from solver import NotConverged, Scene, load_path, np1, uniform


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
    scene = Scene(surface="flat", tolerance=1e-11, **values)
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
        shear = [f for f in load_path(Scene(surface="flat", phi_ratio=0.1, E=E, u_x_max=18.0)) if f.stage == "shear"]
        k = next(i for i, f in enumerate(shear) if f.slip)
        drops.append((shear[k - 1].F_bar - shear[k].F_bar) * E)
    assert drops[1] > 1.8 * drops[0]


PRESSED = Scene(surface="flat", nodes=16, width=40.0, delta_bar=0.5, u_x_max=30.0, du_x=0.5)


def rest_of_flow(scene, u, U):
    """Where u' = U + C T(u) - u leads from u, (2,) nm: explicit steps so small that halving them changes nothing."""
    h, G, nu = scene.height * scene.width, scene.shear_modulus, scene.nu
    compliance = np.array([h / G, (1.0 - 2.0 * nu) * h / (2.0 * G * (1.0 - nu))])
    for _ in range(200_000):
        speed = U + compliance * np.array(np1.traction(scene, *u)) - u
        if np.abs(speed).max() < 1e-9:
            return u
        u = u + 2e-3 * speed
    raise AssertionError("the flow does not come to rest")


def test_slip_out_of_flutter_ends_where_the_overdamped_flow_comes_to_rest():
    """Under compression a pair of complex modes starts to grow before any fold, as NP1 has no potential."""
    shear = [f for f in load_path(PRESSED) if f.stage == "shear"]
    k = next(i for i, f in enumerate(shear) if f.slip)
    load = shear[k].U_slip
    assert load == pytest.approx(18.4734532, abs=1e-6)
    end = next(f for f in load_path(PRESSED.changed(u_x_max=load, du_x=load / 37)) if f.U_x == pytest.approx(load))
    u = end.u[:, 0] + np.array([uniform.NUDGE, -0.5 * uniform.NUDGE])  # of the way that the branch was moving
    rest = rest_of_flow(PRESSED, u, np.array([load, -PRESSED.delta]))
    # the frame is at 18.5 nm, the flow at the load of the slip: the layer moves on by less than it is sheared
    assert np.abs(shear[k].u[:, 0] - rest).max() < shear[k].U_x - load


def test_pressed_contact_slips_once_per_lattice_period_and_rests_stably():
    frames = list(load_path(PRESSED))
    folds = [event.load for f in frames if f.stage == "shear" for event in f.slips]
    assert np.diff(folds) == pytest.approx(PRESSED.spacing, abs=1e-6)  # loads of slips are sharp to round-off
    assert len(folds) == 5 and max(f.residual for f in frames) <= PRESSED.tolerance
    for frame in frames[-10:]:  # a disturbance of 1e-3 nm, within the range of every rest, dies out
        u, U = frame.u[:, 0], np.array([frame.U_x, -frame.delta])
        assert np.abs(rest_of_flow(PRESSED, u + 1e-3, U) - u).max() < 1e-8


@pytest.mark.parametrize(
    "values", [{"height": 0.016, "nodes": 1000, "du_x": 0.5}, {"u_x_max": 400.0, "du_x": 1.0}], ids=["thin", "far"]
)
def test_pressed_contact_comes_to_the_end_of_its_run(values):
    """Also at loads so large that the finest step of the load is below their round-off."""
    scene = Scene(surface="flat", delta_bar=0.5, **values)
    frames = list(load_path(scene))
    assert frames[-1].U_x == pytest.approx(scene.u_x_max)
    assert max(f.residual for f in frames) <= scene.tolerance
    loads = [slip.load for f in frames if f.stage == "shear" for slip in f.slips]
    assert np.diff(loads).min(initial=np.inf) > 0.5 * scene.spacing


def test_slip_that_leads_nowhere_is_reported(monkeypatch):
    """Made so: the slip rests where its branch has ended."""
    monkeypatch.setattr(uniform, "_slip", lambda *state: (True, 1))
    with pytest.raises(NotConverged, match=r"at U_x = 18.4735 nm: the branch that a slip led to ends at once; try"):
        list(load_path(PRESSED))
