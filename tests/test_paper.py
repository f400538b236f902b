"""What the paper states of the circular punch, with the reference numbers of an independent solver."""

import numpy as np
import pytest

from solver import Scene, load_path


def shear_frames(**values):
    return [f for f in load_path(Scene(**values)) if f.stage == "shear"]


def first_slip(shear):
    return next(i for i, f in enumerate(shear) if f.slip)


def nodes_in_contact(frame):
    return int((frame.T[1] > 0).sum())


# delta_bar, L_bar at U_x = 0, nodes in contact there, last U_x before the slip, F_bar there, nodes in contact there
TABLE = [
    (-0.3, -1.09e-3, 0, 6.8, 6.542e-4, 0),
    (-0.15, -8.52e-4, 39, 9.2, 9.261e-4, 0),
    (0.0, -5.09e-4, 81, 10.8, 1.114e-3, 69),
    (0.1, -2.42e-4, 103, 11.5, 1.214e-3, 92),
]


@pytest.mark.parametrize(("delta_bar", "L_0", "contact_0", "U_x", "F", "contact"), TABLE)
def test_reference_values_up_to_the_first_slip(delta_bar, L_0, contact_0, U_x, F, contact):
    shear = shear_frames(delta_bar=delta_bar, u_x_max=13.0)
    last = shear[first_slip(shear) - 1]
    assert shear[0].L_bar == pytest.approx(L_0, abs=0.5e-2 * 10 ** np.floor(np.log10(-L_0)))
    assert nodes_in_contact(shear[0]) == contact_0
    assert last.U_x == pytest.approx(U_x)
    assert last.F_bar == pytest.approx(F, abs=0.5e-3 * 10 ** np.floor(np.log10(F)))
    assert nodes_in_contact(last) == contact


def test_case_one_tension_detaches_at_a_finite_force_and_reattaches_in_part():
    shear = shear_frames(delta_bar=-0.15, u_x_max=12.0)
    k = first_slip(shear)
    assert shear[k - 1].A_bar == 0.0 and shear[k - 1].F_bar > 9e-4
    assert nodes_in_contact(shear[k]) == 25  # 0.0244 of 1024 nodes
    assert 0.5 < shear[k].A_bar / shear[0].A_bar < 0.75


def test_case_two_compression_reattaches_in_part():
    shear = shear_frames(delta_bar=0.4, u_x_max=14.0)
    k = first_slip(shear)
    assert shear[k - 1].A_bar > 0.9 * shear[0].A_bar
    assert shear[k - 1].A_bar < shear[k].A_bar < 0.99 * shear[0].A_bar


def test_case_three_low_friction_reattaches_in_full():
    shear = shear_frames(delta_bar=0.4, phi_ratio=0.1, u_x_max=6.0)
    k = first_slip(shear)
    assert shear[k - 1].A_bar < 0.96 * shear[0].A_bar
    # what is missing is a tenth of what is missing after a slip at high friction
    assert shear[k].A_bar == pytest.approx(shear[0].A_bar, rel=0.012)


@pytest.mark.parametrize(
    ("delta_bar", "U_x", "trailing", "leading", "asymmetry"),
    [(-0.15, 8.4, 13.2, 10.5, 0.11), (-0.1, 9.6, 10.3, 6.7, 0.21), (0.4, 10.8, 4.6, 1.2, 0.59)],
)
def test_peeling_is_nearly_symmetric_under_tension_and_one_sided_under_compression(
    delta_bar, U_x, trailing, leading, asymmetry
):
    scene = Scene(delta_bar=delta_bar, u_x_max=U_x)
    shear = [f for f in load_path(scene) if f.stage == "shear"]
    back = (shear[-1].trailing - shear[0].trailing) / scene.spacing
    front = (shear[0].leading - shear[-1].leading) / scene.spacing
    assert (back, front) == pytest.approx((trailing, leading), abs=0.1)
    assert (back - front) / (back + front) == pytest.approx(asymmetry, abs=0.01)


def test_area_shrinks_slips_and_recovers_again_and_again():
    shear = shear_frames(u_x_max=22.0)
    slips = [i for i, f in enumerate(shear) if f.slip]
    assert len(slips) >= 4
    for before, k in zip([0, *slips], slips, strict=False):
        areas = [f.A_bar for f in shear[before:k]]
        assert np.all(np.diff(areas) < 0)
        assert shear[k].A_bar > areas[-1]


def test_touching_surfaces_attract():
    assert shear_frames(delta_bar=0.0, u_x_max=0.0)[0].L_bar < 0 < shear_frames(delta_bar=0.25, u_x_max=0.0)[0].L_bar
