"""The page "Stick-slip" in Python: figures of the paper from runs, and the map of mean friction."""

import numpy as np
import panel as pn
import pytest

from app.features.stick_slip import research as stick_slip
from solver import Scene, load_path
from solver.analysis.regimes import flat
from solver.presets import presets

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
pytestmark = pytest.mark.usefixtures("script")


def narrow(scene):
    """A flat on the same layer, an eighth as wide: its nodes are all alike."""
    return scene.changed(nodes=scene.nodes // 8, width=scene.width / 8, height=scene.height * 8)


def test_stick_slip_shows_figures_4_and_5_of_the_paper_from_runs(monkeypatch):
    monkeypatch.setattr(stick_slip, "PAPER", {label: narrow(scene) for label, scene in stick_slip.PAPER.items()})
    page = stick_slip.StickSlip(narrow(presets()["fig4a-blue"].scene))
    assert isinstance(page.layout(), pn.viewable.Viewable)
    drawn = {curve.label: (curve.x, curve.y) for curve in page.forces()}
    for name, label in stick_slip.FLATS.items():
        scene = narrow(flat(presets()[name].scene))
        frames = [frame for frame in load_path(scene) if frame.stage == "shear"]
        U, F = drawn[label]
        at = np.isin(U, [frame.U_x for frame in frames])
        # a run in slices agrees to the tolerance of its states
        assert F[at] == pytest.approx([1000 * frame.F_bar * scene.E / 70 for frame in frames], abs=1e-5)
    ratios, means = page.exact
    (of_runs,) = (curve for curve in page.means() if curve.label == "runs")
    assert len(of_runs.x) == 9
    expected = np.interp(np.log(of_runs.x), np.log(ratios), means)
    assert of_runs.y == pytest.approx(expected, abs=0.02)  # a run stops every 0.2 nm of the drop
    assert "stick, and slip first" in page.text


def test_a_click_on_the_map_shows_that_flat_scene_and_moves_the_sliders(monkeypatch):
    page = stick_slip.StickSlip(SMALL)
    monkeypatch.setattr(page, "start", lambda: None)
    page.go_to(np.log10(200.0), np.log10(0.02))
    scene = page.scene
    assert (scene.surface, scene.E, scene.phi_ratio, scene.delta_bar) == ("flat", 200.0, 0.01, 0.0)


def test_too_many_increments_are_refused_with_a_remedy():
    page = stick_slip.StickSlip(SMALL.changed(du_x=0.001))
    page.layout()
    assert page.text.startswith("du_x = 0.001") and "enlarge it" in page.text
