"""The circular punch against an independent solver's numbers; what the paper states is in test_statements.py."""

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
