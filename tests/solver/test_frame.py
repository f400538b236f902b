"""Forces, contact area and edges from the tractions."""

from types import SimpleNamespace

import numpy as np
import pytest

from solver import Scene, load_path, summarize, whole_surface
from solver.analysis.peeling import edges, peel_asymmetry
from solver.run.frame import contact_area, forces
from solver.run.summary import fields_of

SCENE = Scene(nodes=100, width=250.0)


def of_contact(T, first=0):
    """(A_bar, edges) of these tractions."""
    return contact_area(SCENE, T), edges(SimpleNamespace(scene=SCENE, T=T, first=first))


def test_area_interpolates_between_nodes():
    tz = 1.0 - (np.arange(100) - 50.3) ** 2 / 7.6**2  # changes sign at 50.3 -+ 7.6 nodes
    area, ((trailing, leading),) = of_contact(np.array([0 * tz, tz]))
    # linear interpolation of a parabola: off by the sagitta over one spacing
    assert area * 100 == pytest.approx(15.2, abs=0.04)
    assert (trailing / 2.5, leading / 2.5) == pytest.approx((42.7, 57.9), abs=0.02)


def test_area_moves_smoothly_while_nodes_come_and_go():
    areas = []
    for top in np.linspace(0.9, 1.1, 50):
        tz = top - (np.arange(100) - 50) ** 2 / 60.0
        areas.append(contact_area(SCENE, np.array([0 * tz, tz])))
    steps = np.diff(areas)
    assert steps.min() > 0 and steps.max() < 3 * steps.min()


def test_a_patch_gives_the_area_of_the_whole_surface():
    tz = np.zeros(100)
    tz[40:61] = 0.4 - (np.arange(21) - 10.2) ** 2 / 60
    T = np.array([0 * tz, tz])
    for whole, part in zip(of_contact(T), of_contact(T[:, 40:61], 40), strict=True):
        assert part == pytest.approx(whole)


def test_no_contact_and_full_contact():
    free, full = of_contact(np.full((2, 100), -1.0)), of_contact(np.full((2, 100), 1.0))
    assert free[0] == 0.0 and free[1].shape == (0, 2)
    assert full[0] == 1.0 and full[1].shape == (1, 2) and np.isnan(full[1]).all()


@pytest.mark.parametrize("tolerance", [1e-10, 1e-3])
def test_the_definition_of_contact_does_not_depend_on_the_tolerance(tolerance):
    T = np.array([np.zeros(100), 1e-4 * (1.0 - (np.arange(100) - 50) ** 2 / 60.0)])
    assert contact_area(SCENE.changed(tolerance=tolerance), T) == contact_area(SCENE, T) > 0.0


def test_areas_of_two_patches_add_up():
    tz = np.full(100, -1.0)
    tz[10:20] = tz[50:55] = 1.0
    area, found = of_contact(np.array([0 * tz, tz]))
    assert (area, len(found)) == (pytest.approx(0.15), 2)


def test_attraction_is_negative_and_friction_opposes_the_pull():
    F_bar, L_bar = forces(SCENE, np.array([np.full(100, -0.7), np.full(100, -1.4)]))
    assert (F_bar, L_bar) == pytest.approx((0.01, -0.02))


def test_edges_of_every_patch_come_in_order():
    tz = np.full(100, -1.0)
    tz[10:20] = tz[50:55] = 1.0
    _, found = of_contact(np.array([0 * tz, tz]))
    assert found == pytest.approx(2.5 * np.array([[9.5, 19.5], [49.5, 54.5]]))


@pytest.mark.parametrize("shift", [0, 45, 52, 80, 88, 95])
def test_a_contact_across_the_cell_boundary_is_one_patch_with_continuous_edges(shift):
    """Moved around the cell, two patches stay two, as long, and as far apart; only their order starts elsewhere."""
    tz = np.full(100, -1.0)
    tz[10:20] = tz[25:30] = 1.0
    T = np.array([0 * tz, np.roll(tz, shift)])
    area, found = of_contact(T)
    assert (area, len(found)) == (pytest.approx(0.15), 2)
    trailing, leading = found[0, 0], found[-1, 1]
    assert (found[:, 1] - found[:, 0]).sum() == pytest.approx(15 * 2.5)
    assert (np.diff(found.ravel()) > 0.0).all()
    if T[1, 0] > 0.0 and T[1, -1] > 0.0:  # across the ends: the order starts behind the widest gap
        assert (trailing, leading) == pytest.approx(((9.5 + shift) % 100 * 2.5, ((9.5 + shift) % 100 + 20) * 2.5))
    else:
        assert 0.0 <= trailing < leading <= 250.0


def test_peel_asymmetry_is_the_difference_over_all_that_the_edges_moved():
    def frame(*patches):
        tz = np.full(100, -1.0)
        for low, high in patches:
            tz[low:high] = 1.0
        return SimpleNamespace(scene=SCENE, T=np.array([0 * tz, tz]), first=0)

    before = frame((10, 20), (50, 60))
    assert peel_asymmetry(before, frame((13, 20), (51, 60))) == pytest.approx(1.0)
    assert peel_asymmetry(before, frame((13, 19), (53, 59))) == pytest.approx(0.5)
    assert peel_asymmetry(before, frame((10, 17), (50, 60))) == pytest.approx(-1.0)
    assert np.isnan(peel_asymmetry(before, before))
    assert np.isnan(peel_asymmetry(before, frame((10, 20))))  # a patch has gone


def tent(*patches):
    """A frame whose T_z is positive between the edges (in nodes) of each patch, and crosses zero linearly there."""
    away = [np.abs((np.arange(100) - 0.5 * (a + b) + 50.0) % 100.0 - 50.0) - 0.5 * (b - a) for a, b in patches]
    tz = -np.clip(np.min(away, axis=0), -1.0, 1.0)
    return SimpleNamespace(scene=SCENE, T=np.array([0 * tz, tz]), first=0)


@pytest.mark.parametrize(("leading", "told"), [(98.8, (1.8 - 0.6) / (1.8 + 0.6)), (100.4, 1.0)])
def test_peel_asymmetry_follows_a_patch_across_the_ends_of_the_cell(leading, told):
    """The third patch grows across: the edges then come in another order, but belong to the same patches.

    Where the leading edges moved outward on the whole, all that has let go is behind.
    """
    before, after = tent((10, 20), (40, 50), (85, 98.6)), tent((10.4, 19.6), (40.4, 49.6), (86, leading))
    # least, what counts as repulsion, moves edges by 1e-8 of a spacing
    assert peel_asymmetry(before, after) == pytest.approx(told, abs=1e-6)
    for shift in range(0, 100, 7):
        moved = [SimpleNamespace(scene=SCENE, T=np.roll(f.T, shift, axis=1), first=0) for f in (before, after)]
        assert peel_asymmetry(*moved) == pytest.approx(told, abs=1e-6)


def test_peel_asymmetry_of_an_edge_that_moves_by_more_than_half_the_cell():
    assert peel_asymmetry(tent((5, 95)), tent((75, 85))) == pytest.approx((70 - 10) / (70 + 10), abs=1e-6)


@pytest.mark.parametrize(
    "after",
    [
        [(10.5, 19.5), (70, 80)],  # one has gone, another come
        [(21, 30), (40, 50)],
        [(10, 14), (16, 20)],  # one has parted, one gone
        [(10, 50), (70, 80)],  # two have met, one come
        [(10, 14), (16, 20), (40, 50)],
    ],
)
def test_peel_asymmetry_is_none_unless_every_patch_has_one_partner(after):
    assert np.isnan(peel_asymmetry(tent((10, 20), (40, 50)), tent(*after)))
    assert np.isnan(peel_asymmetry(tent(*after), tent((10, 20), (40, 50))))


def test_peel_asymmetry_is_none_without_edges():
    free, full = (SimpleNamespace(scene=SCENE, T=np.full((2, 100), value), first=0) for value in (-1.0, 1.0))
    for other in (free, full, tent((10, 20))):
        assert np.isnan(peel_asymmetry(full, other)) and np.isnan(peel_asymmetry(free, other))


def test_frames_compare_and_hash_by_identity_and_print_in_a_line():
    """As `in`, sets and an interactive session need it: arrays have no truth value, and a printed frame took 23 kB."""
    first, second = list(load_path(Scene(surface="flat", phi_ratio=0.1, u_x_max=0.0, du_z=1.0)))[:2]
    assert first == first and first != second and first in [second, first] and len({first, second, first}) == 2
    assert repr(first).startswith("Frame(approach 0: U_x = 0 nm, delta = -10 nm, F = ") and len(repr(first)) < 400
    assert " N/m, A = " in repr(first) and "array" not in repr(first)


def test_frames_are_described_with_their_own_scene():
    """What reads frames takes no scene beside them, which might be another one."""
    scene = Scene(nodes=64, width=160.0, u_x_max=2.0, du_x=0.5, du_z=0.5)
    *_, last = frames = list(load_path(scene))
    assert whole_surface(last).shape == (2, 64) and fields_of(frames)["x"].shape == fields_of(frames)["u"].shape[2:]
    assert summarize(frames)["converged"] and not summarize(frames[:-1])["converged"] and not summarize([])["converged"]
    with pytest.raises(TypeError):
        summarize(scene.changed(u_x_max=1.0), frames)
