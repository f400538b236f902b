"""The law of Xu & Needleman (q = 1, r = 0): it has a potential for phi_t = phi_n, and overclosure weakens its shear."""

from itertools import pairwise

import extended
import numpy as np
import pytest
from plain_gfmd import Plain, run
from spectrum import growth

from solver import CHOICES, Scene, load_path, simulate, whole_surface
from solver.mechanics import cohesive_law
from solver.mechanics.cohesive_law import tangent, traction
from solver.scene import LAWS

XN = Scene(law="xu-needleman")
SMALL = XN.changed(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, E=40.0, u_x_max=6.0)
U_X, GAP = np.meshgrid(np.linspace(-3.0, 3.0, 41), np.linspace(-2.0, 6.0, 41))


def test_tangent_is_symmetric_for_equal_works_of_separation_unlike_that_of_np1():
    """To round-off of the sums; delta_n and delta_t may differ."""
    for scene in (XN, XN.changed(delta_t=2.0, delta_n=0.7)):
        _, xz, zx, _ = tangent(scene, U_X, GAP)
        largest = np.abs(tangent(scene, U_X, GAP)).max()
        assert np.abs(xz - zx).max() < 1e-14 * largest
        _, xz, zx, _ = tangent(scene.changed(law="np1"), U_X, GAP)
        assert np.abs(xz - zx).max() > 1e-3 * largest


def test_work_of_the_potential_law_around_a_closed_path_vanishes():
    """By Gauss-Legendre quadrature on the sides of a rectangle, with a window beyond whose edge nothing is left."""
    wide = XN.changed(window_t=8.0)
    nodes, weights = np.polynomial.legendre.leggauss(60)

    def work(scene, start, end):
        middle, half = 0.5 * (end + start), 0.5 * (end - start)
        T = traction(scene, *(middle[:, None] + half[:, None] * nodes))
        return float((T * half[:, None] * weights).sum())

    corners = np.array([[0.1, -1.0], [1.1, -1.0], [1.1, 2.0], [0.1, 2.0], [0.1, -1.0]])
    around = {
        law: sum(work(wide.changed(law=law), *side) for side in pairwise(corners)) for law in ("np1", "xu-needleman")
    }
    assert abs(around["xu-needleman"]) < 1e-12 < 0.1 < abs(around["np1"])  # N/m


def test_shear_resistance_of_the_potential_law_changes_sign_below_minus_delta_n():
    """The reason why the paper takes NP1, whose resistance grows."""
    ahead = 0.5  # nm beyond a site
    gaps = np.array([0.0, -0.5, -0.9, -1.0, -1.5])
    resistance = -traction(XN, ahead, gaps)[0]
    assert (np.diff(resistance) < 0.0).all() and resistance[0] > 0.0 > resistance[-1]
    assert abs(resistance[3]) < 1e-14 * resistance[0]
    assert (np.diff(-traction(XN.changed(law="np1"), ahead, gaps)[0]) > 0.0).all()


@pytest.mark.parametrize("law", LAWS)
def test_the_kernels_agree_with_extended_precision(law):
    """Round-off of double precision, over the size of the springs."""
    scene = XN.changed(law=law)
    T, gross = extended.springs(scene, U_X.ravel(), GAP.ravel())
    assert (np.abs(traction(scene, U_X.ravel(), GAP.ravel()) - T) < 1e-13 * gross).all()
    J = extended.tangent(scene, U_X.ravel(), GAP.ravel())
    assert np.abs(tangent(scene, U_X.ravel(), GAP.ravel()).reshape(2, 2, -1) - J).max() < 1e-13 * np.abs(J).max()


# E (GPa), delta_bar and phi_ratio: soft and stiff, pulled and deep, slippery and strong
CORNERS = [
    *((40.0, 0.1, 1.0), (20.0, -0.1, 0.2), (20.0, 0.3, 2.0), (200.0, -0.1, 1.0)),
    *((200.0, 0.3, 0.2), (1000.0, -0.1, 2.0), (1000.0, 0.3, 1.0)),
]


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize(("E", "delta_bar", "phi_ratio"), CORNERS)
def test_a_run_with_the_potential_law_agrees_with_an_explicit_gfmd(E, delta_bar, phi_ratio):
    """F, L and A to 1e-5 of their largest: the GFMD comes to rest within its tolerance only.

    At the depth 0.3 some gaps are below -delta_n, where the start of the shear is unstable: the surface may leave it
    either way, until it has passed a site.
    """
    scene = SMALL.changed(E=E, delta_bar=delta_bar, phi_ratio=phi_ratio, du_x=0.5, du_z=0.5)
    start = scene.spacing if delta_bar == 0.3 else 0.0
    frames = [frame for frame in load_path(scene) if frame.stage == "shear" and frame.U_x >= start]
    plain = [record for record in run(scene) if record.stage == "shear" and record.load >= start]
    assert len(frames) == len(plain)
    for name in ("F_bar", "L_bar", "A_bar"):
        ours, theirs = (np.array([getattr(each, name) for each in one]) for one in (frames, plain))
        assert np.abs(ours - theirs).max() <= 1e-5 * np.abs(theirs).max()


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_run_with_every_law_agrees_with_an_explicit_gfmd(law):
    """As the run above."""
    scene = SMALL.changed(law=law, du_x=0.5, du_z=0.5)
    ours, theirs = (np.array([(one.F_bar, one.L_bar) for one in each(scene)]) for each in (load_path, run))
    assert np.abs(ours - theirs).max() <= 1e-5 * np.abs(theirs).max()


def test_references_reject_a_law_that_they_do_not_write(monkeypatch):
    """Otherwise they would compute NP1 in its place, and agree with nothing but themselves."""
    monkeypatch.setitem(LAWS, "third", "a law for this test")
    monkeypatch.setitem(cohesive_law.OPENING, "third", 0.5)
    scene = SMALL.changed(law="third")
    with pytest.raises(KeyError, match="third"):
        Plain(scene)
    with pytest.raises(KeyError, match="third"):
        extended.springs(scene, U_X.ravel(), GAP.ravel())


def test_every_law_has_its_factor():
    assert LAWS.keys() == cohesive_law.OPENING.keys()


def test_a_fold_under_the_other_law_is_found_before_a_frame_is_unstable():
    scene = XN.changed(
        surface="rough", rms_slope=0.006721, cut_off=0.2, seed=104, E=137.8, nu=0.3, height=0.9005, nodes=79,
        width=194.103, phi_n=0.2557, phi_ratio=1.279, delta_n=0.3809, delta_bar=1.366, damping=0.3, du_z=0.5,
        u_x_max=0.0,
    )  # fmt: skip
    frames = [frame for frame in load_path(scene) if frame.stage == "approach"]
    assert any(frame.slips for frame in frames)
    assert max(growth(scene, frame) for frame in frames if frame.T.any()) <= 1e-6


@pytest.mark.parametrize("tolerance", [1e-8, 1e-9])
def test_a_contact_that_may_tilt_either_way_moves_along_x_and_its_event_is_sensitive(tolerance):
    """In a symmetric approach below -delta_n, round-off decided the way, and with it the first slip of the shear.

    The plain GFMD, moved aside by 1e-3 nm, says where the way along x leads; to the other side it is the mirror image.
    """
    scene = XN.changed(nodes=512, width=1250.0, E=400.0, delta_bar=1.0, u_x_max=0.0, tolerance=tolerance)
    *_, last = frames = list(load_path(scene))
    (event,) = (event for frame in frames for event in frame.slips)
    assert (event.stage, event.kind, event.sensitive) == ("approach", "bifurcation", True)
    before = next(earlier for earlier, frame in pairwise(frames) if event in frame.slips)
    aside = whole_surface(before) + np.array([[1e-3], [0.0]])
    theirs = Plain(scene, tolerance=1e-6).rest(aside, 0.0, -last.delta).u
    assert theirs[0].mean() > 0.5  # nm: the premise
    assert np.abs(whole_surface(last) - theirs).max() < 1e-4


def test_no_state_of_the_potential_law_can_flutter():
    """With a symmetric tangent the safe damping vanishes, however weak the damping."""
    frames = simulate(SMALL.changed(damping=0.2, nodes=256, width=640.0, u_x_max=3.0)).frames
    assert max(frame.safe_damping for frame in frames[::10]) == 0.0
    assert not any(event.kind == "flutter" for frame in frames for event in frame.slips)


def random_scene(rng):
    """Any surface, stiffness, indentation and damping, with a potential: phi_ratio is 1."""
    nodes, damping = int(rng.integers(48, 160)), float(rng.choice([0.2, 0.5, 1.0]))
    surface = str(rng.choice([name for name in CHOICES["surface"] if name != "measured"]))
    E, phi_n, depth = 10 ** rng.uniform(1.2, 3.0), 10 ** rng.uniform(-0.3, 0.5), rng.uniform(-0.3, 0.6)
    path = {"u_x_max": 6.0, "du_x": 0.3, "du_z": 0.3, "damping": damping, "tolerance": 1e-7, "delta_bar": depth}
    layer = {"E": E, "nodes": nodes, "width": nodes * 2.44, "phi_n": phi_n}
    return XN.changed(surface=surface, radius=0.6, amplitude=2.0, cut_off=0.2, **path, **layer)


@pytest.mark.thorough
@pytest.mark.slow
def test_no_wave_flutters_in_random_scenes():
    """20 scenes, some underdamped: no end is a flutter, and no state needs any damping."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        for frame in load_path(random_scene(rng)):
            assert frame.safe_damping == 0.0
            assert all(event.kind != "flutter" for event in frame.slips), frame.scene
