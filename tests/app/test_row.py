"""Pictures of the preset row, which docs/row.py draws from runs of the solver."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from solver import load_path
from solver.presets import presets

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))
import row

NARROW = {"nodes": 256, "width": 625.0}
ROW = [preset for preset in presets().values() if preset.short]


def extent(svg, kind):
    """(largest height, lowest height, last place) of a path of a picture."""
    numbers = [int(number) for number in re.search(rf'class="{kind}" d="M([^"VZ]+)', svg)[1].replace("l", " ").split()]
    x, y = np.cumsum(numbers[::2]), np.cumsum(numbers[1::2])
    return y.max(), y.min(), x[-1]


def test_every_preset_of_the_row_has_exactly_one_picture():
    assert {path.stem for path in row.PLACE.iterdir()} == {preset.name for preset in ROW}


def test_row_pictures_contain_increments_and_branch_ends():
    scene = presets()["fig7-case2"].scene.changed(u_x_max=14.0, du_x=0.5, **NARROW)
    shear = [frame for frame in load_path(scene) if frame.stage == "shear"]
    slips = [slip for frame in shear for slip in frame.slips]
    expected = [(f.U_x, f.F_bar, f.A_bar) for f in shear] + [(s.load, s.F_bar, s.A_bar) for s in slips]
    assert slips and sorted(zip(*row.curves(scene), strict=True)) == sorted(expected)


def test_row_picture_of_an_unloading_shows_load_over_indentation():
    scene = presets()["unload"].scene.changed(du_z=0.5, tolerance=1e-6, **NARROW)
    unload = [(f.delta, f.L_bar, f.A_bar) for f in load_path(scene) if f.stage == "unload"]
    assert set(unload) <= set(zip(*row.curves(scene), strict=True))


def test_stored_row_picture_matches_the_solver():
    stored = (row.PLACE / "unload.svg").read_text(encoding="utf-8")
    drawn = row.picture(*row.curves(presets()["unload"].scene))
    assert extent(drawn, "force") == pytest.approx(extent(stored, "force"), abs=1)  # rounded on another machine
