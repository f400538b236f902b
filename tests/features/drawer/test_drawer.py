"""The drawer, without a browser."""

from app.features.drawer.feature import drawer
from app.session.controls import NAMES
from solver.scene import PARAMETERS


def test_drawer_holds_every_parameter_without_a_slider_once():
    names = [name for group in drawer().values() for name in group]
    assert sorted([*names, *NAMES]) == sorted(PARAMETERS)
