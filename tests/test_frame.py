"""Forces, contact area and edges from the tractions."""

import numpy as np
import pytest

from solver import Scene
from solver.frame import contact_area, forces

SCENE = Scene(nodes=100, width=250.0)


def test_area_interpolates_between_nodes():
    tz = 1.0 - (np.arange(100) - 50.3) ** 2 / 7.6**2  # changes sign at 50.3 -+ 7.6 nodes
    area, trailing, leading = contact_area(SCENE, np.array([0 * tz, tz]), 0)
    # linear interpolation of a parabola: off by the sagitta over one spacing
    assert area * 100 == pytest.approx(15.2, abs=0.04)
    assert (trailing / 2.5, leading / 2.5) == pytest.approx((42.7, 57.9), abs=0.02)


def test_area_moves_smoothly_while_nodes_come_and_go():
    areas = []
    for top in np.linspace(0.9, 1.1, 50):
        tz = top - (np.arange(100) - 50) ** 2 / 60.0
        areas.append(contact_area(SCENE, np.array([0 * tz, tz]), 0)[0])
    steps = np.diff(areas)
    assert steps.min() > 0 and steps.max() < 3 * steps.min()


def test_a_patch_gives_the_area_of_the_whole_surface():
    tz = np.zeros(100)
    tz[40:61] = 0.4 - (np.arange(21) - 10.2) ** 2 / 60
    whole = contact_area(SCENE, np.array([0 * tz, tz]), 0)
    assert contact_area(SCENE, np.array([0 * tz, tz])[:, 40:61], 40) == pytest.approx(whole)


def test_no_contact_and_full_contact():
    free = contact_area(SCENE, np.full((2, 100), -1.0), 0)
    full = contact_area(SCENE, np.full((2, 100), 1.0), 0)
    assert free[0] == 0.0 and np.isnan(free[1:]).all()
    assert full[0] == 1.0 and np.isnan(full[1:]).all()


def test_two_patches_add_up():
    tz = np.full(100, -1.0)
    tz[10:20] = tz[50:55] = 1.0
    area, trailing, leading = contact_area(SCENE, np.array([0 * tz, tz]), 0)
    assert area == pytest.approx(0.15)
    assert (trailing, leading) == pytest.approx((9.5 * 2.5, 54.5 * 2.5))


def test_attraction_is_negative_and_friction_opposes_the_pull():
    F_bar, L_bar = forces(SCENE, np.array([np.full(100, -0.7), np.full(100, -1.4)]))
    assert (F_bar, L_bar) == pytest.approx((0.01, -0.02))
