"""Pages that show results of many calls: Stick-slip, and Area laws."""

import numpy as np
import pytest
from visitor import order

from app.service import tasks
from solver.analysis.friction_laws import INDENTATIONS, critical_modulus, onset
from solver.presets import presets


def done(session, call_of=lambda call: True):
    """Do the tasks, as workers would."""
    for task in session.jobs.pool.tasks:
        if not task.done() and call_of(task.call):
            task.set_result(task.call[0](*task.call[1:]))


def of_kind(kind):
    return lambda call: call[0] is kind


def page_state(session):
    return session.pages.page.published


@pytest.mark.slow
def test_friction_of_flat_runs_lies_on_the_exact_curve(session):
    session.restore({"preset": "fig4a-blue"})
    order(session, "page", page="stickslip")
    done(session, of_kind(tasks.flat_friction))
    parts = session.pages.page.views["mean"].parts
    runs, exact = parts["runs"].data_source.data, parts["exact"].data_source.data
    assert len(runs["ratio"]) == 9
    expected = np.interp(np.log(runs["ratio"]), np.log(exact["ratio"]), exact["mean"])
    assert np.asarray(runs["mean"]) == pytest.approx(expected, abs=0.02)  # a run stops every 0.2 nm of the drop
    assert parts["low"].left == pytest.approx(
        critical_modulus(presets()["fig4a-blue"].scene) / (0.2 * np.sqrt(2 / np.e))
    )


def test_a_click_on_the_stick_slip_map_loads_that_flat_scene(session):
    order(session, "page", page="stickslip")
    order(session, "ask", E=200.0, phi_t=0.02)
    scene = session.scene
    assert (scene.surface, scene.E, scene.phi_ratio, scene.delta_bar) == ("flat", 200.0, 0.01, 0.0)
    assert session.preset == "fig4a-blue"


def test_legend_of_the_stick_slip_map_ends_at_its_largest_value(session):
    """Mean friction of a soft layer over tau_max falls as the lattice gets finer."""
    order(session, "page", page="stickslip")
    told = []
    for nodes in (512, 1024, 2048):
        session.change({"nodes": str(nodes)})
        told.append(float(session.pages.page.published["texts"]["stickslip-most"]))
        shown = session.pages.page.views["map"].parts["map"].glyph.color_mapper
        assert told[-1] == pytest.approx(shown.high, rel=0.05)
    assert told[0] > told[1] > told[2]


def test_area_laws_request_the_current_series_first_then_figure_8(session):
    session.change({"phi_ratio": "0.5"})
    order(session, "page", page="arealaws")
    asked = [scene for _, scene in session.pages.page.sweep.waiting]
    assert [scene.delta_bar for scene in asked[:10]] == [*INDENTATIONS, 1.0]
    assert {scene.phi_ratio for scene in asked[:10]} == {0.5}
    assert len(asked) == 40 and len({(s.phi_n, s.phi_ratio) for s in asked}) == 4


def test_area_laws_show_each_onset_when_it_is_computed(session):
    order(session, "page", page="arealaws")
    assert session.pages.page.views["runs"].figure.y_range.end == 1.0  # in thousandths, before anything is known
    task = next(t for t in session.jobs.pool.tasks if t.call[0] is tasks.onset_of and t.call[1].delta_bar == 0.1)
    done(session, lambda call: call[:2] == task.call[:2])  # slice by slice
    found = onset(task.call[1])
    data = session.pages.page.views["threshold"].parts["points0"].data_source.data
    assert (data["F"], data["A"]) == (pytest.approx([1000 * found.F_s]), pytest.approx([1000 * found.A_s]))
    row = page_state(session)["tables"]["arealaws-rows"][0]
    assert row[0] == "0.10" and float(row[3]) == pytest.approx(6693, rel=0.01)
    assert page_state(session)["busy"] == pytest.approx(1 / 30)
    order(session, "ask", what="cancel")
    assert page_state(session)["busy"] is None


def test_an_interface_is_added_once_and_replaces_the_oldest(session):
    order(session, "page", page="arealaws")
    for ratio in ("0.5", "0.4", "0.3"):
        order(session, "scene", phi_ratio=ratio)
        assert not page_state(session)["hidden"]["arealaws-add"]
        order(session, "ask", what="add")
        assert page_state(session)["hidden"]["arealaws-add"]
    names = [pick["label"] for _, pick, *_ in page_state(session)["tables"]["arealaws-series"]]
    assert len(session.pages.page.sweep.waiting) == 50  # nothing is computed any longer for the series that had to go
    assert len(names) == 5 and names[-1] == "φₙ = 2, φₜ/φₙ = 0.3" and names[0] == "φₙ = 2, φₜ/φₙ = 1"


def test_runs_of_the_stick_slip_page_can_be_cancelled(session):
    order(session, "page", page="stickslip")
    assert page_state(session)["busy"] == 0.0
    order(session, "ask", what="cancel")
    assert page_state(session)["busy"] is None
    assert all(task.cancelled() for task in session.jobs.pool.tasks if task.call[0] is tasks.flat_friction)
