"""The page "Area laws" in Python: Fig. 8 of the paper, and onsets found in slices."""

import asyncio
from functools import partial

import numpy as np
import panel as pn
import pytest
from visitor import in_slices

from app.features.area_laws import research as area_laws
from app.features.area_laws import tasks
from app.features.lab import base
from app.features.lab.tasks import tried
from app.service import worker
from solver import Scene
from solver.analysis.friction_laws import onset

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
pytestmark = pytest.mark.usefixtures("script")


def test_area_laws_shows_figure_8_of_the_paper_with_the_fitted_laws(monkeypatch):
    """An eighth as wide; tests/solver/test_statements.py has it whole."""
    cell = {"nodes": 128, "width": 312.5}
    monkeypatch.setattr(area_laws, "PAPER", [scene.changed(**cell) for scene in area_laws.PAPER])
    monkeypatch.setattr(area_laws, "DEPTHS", (area_laws.DEPTHS[0], *area_laws.DEPTHS[-4:]))
    page = area_laws.AreaLaws(Scene(**cell))
    assert isinstance(page.layout(), pn.viewable.Viewable)
    series = page.series()
    assert page.text == "" and all(list(runs) == list(area_laws.DEPTHS) for runs in series.values())
    for name, scene in zip(area_laws.NAMES[1:3], area_laws.PAPER, strict=False):
        runs = {depth: onset(scene.changed(delta_bar=depth)) for depth in area_laws.DEPTHS[-3:]}
        for depth, exact in runs.items():
            found = series[name][depth]
            assert (found.F_s, found.A_s) == pytest.approx((exact.F_s, exact.A_s), rel=1e-9)
    rows = page.quadratic_rows()
    assert len(rows) == len(area_laws.DEPTHS) and rows["ζ"].iloc[0] == "–"  # without contact


def test_a_run_without_an_equilibrium_is_named_and_the_others_are_shown(monkeypatch):
    page = area_laws.AreaLaws(SMALL)
    lost, shown = SMALL.changed(u_x_max=13.0), SMALL.changed(u_x_max=14.0)

    async def result(tried, task, scene, **how):
        if scene == lost:
            raise ValueError("no equilibrium; raise E")
        return "an onset"

    monkeypatch.setattr(base.jobs, "result", result)
    asyncio.run(page.run(tasks.onset_of, (lost, shown)))
    assert page.found == {shown: "an onset"} and page.text == f"{lost}: no equilibrium; raise E."


def test_scenes_are_computed_at_the_same_time_and_end_together_when_cancelled(monkeypatch):
    """They were computed one after another: one worker was busy, however many there are."""
    page, scenes = area_laws.AreaLaws(SMALL), [SMALL.changed(u_x_max=13.0 + k) for k in range(3)]
    computed, ended = [], []

    async def main():
        all_there = asyncio.Event()

        async def result(tried, task, scene, **how):
            computed.append(scene)
            if len(computed) == len(scenes):
                all_there.set()
            try:
                await asyncio.wait_for(all_there.wait(), 60)
                await asyncio.sleep(0 if scene != scenes[2] else 3600)
            finally:
                ended.append(scene)
            return "an onset"

        monkeypatch.setattr(base.jobs, "result", result)
        running = asyncio.ensure_future(page.run(tasks.onset_of, scenes))
        while page.share != 2 / 3:
            await asyncio.sleep(0)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    asyncio.run(main())
    assert computed == scenes and sorted(ended, key=scenes.index) == scenes


def test_charts_follow_results_and_one_without_data_has_a_range(monkeypatch):
    """Bokeh warns of axes whose range no curve determines."""
    page = area_laws.AreaLaws(SMALL)
    monkeypatch.setattr(page, "start", lambda: None)
    pane, *_ = page.layout().select(pn.pane.Bokeh)
    lines, marks = (part.data_source for part in pane.object.renderers)
    assert lines.data["alpha"][-1] == 0.0 and len(lines.data["x"][-1]) == 2
    run = onset(SMALL)
    page.found = {area_laws.series_of(page.scene).changed(delta_bar=0.2): run}
    assert lines.data["y"][2] == pytest.approx(1e3 * run.A) and lines.data["alpha"][-1] == 1.0
    assert marks.data["x"][1:] == pytest.approx([1e3 * run.F_s]) and marks.data["values"][1:] == ["δ̄ = 0.2"]


def test_a_flat_has_no_area_laws():
    page = area_laws.AreaLaws(SMALL.changed(surface="flat"))
    page.layout()
    assert "no edge that can peel" in page.text and not page.found


def test_sliced_search_for_the_onset_equals_the_whole_search(monkeypatch):
    monkeypatch.setattr(tasks, "SLICE", 0.0)  # one increment each
    scene = Scene(nodes=256, width=625.0, phi_ratio=0.3)
    found, count = in_slices(tasks.onset_of, scene)
    whole = onset(scene)
    assert count > 50 and found.F_s == pytest.approx(whole.F_s, rel=1e-6)
    assert np.allclose(found.U, whole.U, rtol=1e-6)


def test_a_search_that_runs_out_of_time_reports_where(monkeypatch):
    monkeypatch.setattr(tasks, "SLICE", 0.0)
    monkeypatch.setattr(worker, "SLOW", 0.0)
    failed = in_slices(partial(tried, tasks.onset_of), Scene())[0]
    assert failed.kind == "hang" and "no equilibrium within 0 s" in str(failed)  # which is not cached: see Jobs
