"""Every preset against a reference at the tightest tolerance and a tenth of the steps, everything solved for."""

import numpy as np
import pytest

from solver import load_path
from solver.left_out import ALL
from solver.presets import presets

FINER = 10  # steps of the reference to one
# Which nodes are within the window depends on the steps taken: at 10 delta_n that moves the ends of a soft branch by
# 3e-4 nm, and the forces of a rough surface by 2e-5: compared at 20 delta_n, where the cut is 4e-8.
WINDOW = {"unload": 20.0, "rough": 20.0}
# Single summits let go on branches too short to be followed by arc length: their ends are known to a step only.
SLIPS_TO = {"rough": 1e-2}
# Below critical damping a slip's outcome is that of a motion which starts from where the fold was found: not compared.
NAMES = [name for name, known in presets().items() if known.scene.damping == 1.0]


def curves(frames):
    """{(stage, increment): (F_bar, L_bar, A_bar)} and the slips [(stage, load)] of a run."""
    values = {(f.stage, f.index): (f.F_bar, f.L_bar, f.A_bar) for f in frames}
    return values, [(f.stage, slip.load) for f in frames for slip in f.slips]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_fast_agrees_with_the_reference_before_the_first_slip_and_on_the_branch_after_every_slip(name):
    """To 1e-6 of the largest value up to the first slip in shear; after slips on the same branch, so to 1e-4."""
    scene = presets()[name].scene
    scene = scene.changed(window_n=WINDOW.get(name, scene.window_n))
    fine = scene.changed(du_x=scene.du_x / FINER, du_z=scene.du_z / FINER, tolerance=max(1e-12, 1.1 * scene.attainable))
    ours, slips = curves(list(load_path(scene)))
    reference, theirs = curves(list(load_path(fine, leave_out=ALL - {"translation"})))
    if name in SLIPS_TO:
        slips, theirs = ([slip for slip in found if slip[0] != "approach"] for found in (slips, theirs))
    assert [stage for stage, _ in slips] == [stage for stage, _ in theirs]
    assert [load for _, load in slips] == pytest.approx([load for _, load in theirs], abs=SLIPS_TO.get(name, 1e-4))
    common = [key for key in ours if (key[0], FINER * key[1]) in reference]
    assert len(common) >= 0.95 * len(ours)
    a = np.array([ours[key] for key in common])
    b = np.array([reference[key[0], FINER * key[1]] for key in common])
    error = np.abs(a - b) / np.maximum(np.abs(b).max(axis=0), 1e-12)
    first = next((load for stage, load in slips if stage == "shear"), np.inf)
    before = np.array(
        [stage == "approach" or (stage == "shear" and k * scene.du_x * scene.delta_t < first) for stage, k in common]
    )
    assert error[before].max() < 1e-6
    assert error.max() < 1e-4
