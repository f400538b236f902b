"""The research pages in Python: each is a Viewable that computes, from a scene alone."""

import asyncio
from functools import partial

import numpy as np
import panel as pn
import pytest

from app.features.curve import feature as measured
from app.lab import accuracy, area_laws, base, fit, stick_slip
from app.service import tasks
from app.service.pool import pool
from solver import Scene, load_path
from solver.accuracy.compare import Point
from solver.analysis.friction_laws import onset
from solver.analysis.regimes import flat
from solver.presets import presets

SMALL = Scene(nodes=64, width=160.0, radius=0.6, u_x_max=12.0, du_x=0.2, du_z=0.5, E=30.0)
ROWS = "".join(f"{k},{k * 2.0}\n" for k in range(1, 20)).encode()


@pytest.fixture(scope="module", autouse=True)
def workers():
    """The pool that pages use; it ends with this file."""
    yield pool
    pool.close()


@pytest.fixture(autouse=True)
def no_running_loop():
    """Pages compute at once, as in a script. A browser of this process, which other tests share, leaves a loop running,
    for which Panel would leave them waiting.
    """
    running = asyncio._get_running_loop()
    asyncio._set_running_loop(None)
    yield
    asyncio._set_running_loop(running)


def text_of(viewable):
    return " ".join(str(pane.object) for pane in viewable.select(pn.pane.Str))


def test_accuracy_measures_a_scene_without_a_server():
    page = accuracy.Accuracy(SMALL)
    shown = page.layout()
    assert isinstance(shown, pn.viewable.Viewable) and not page.points  # a visit costs nothing
    page.start(page.measure)
    assert "Tolerance 1e-08 nm gives F, L and A to" in text_of(shown)


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


def test_a_fit_finds_the_parameters_of_example_data_and_gives_them_to_the_sliders(monkeypatch):
    monkeypatch.setattr(fit, "randrange", lambda most: 1)
    page = fit.Fit(SMALL)
    assert isinstance(page.layout(), pn.viewable.Viewable) and len(page.curve[0]) > 50
    page.start(page.example)
    assert "400 points" in page.text and page.truth.keys() == set(fit.FREE.values())
    page.start(page.fit)
    assert page.fitted.values["phi_ratio"] == pytest.approx(page.truth["phi_ratio"], rel=0.1)
    table = page.rows()
    assert list(table["parameter"]) == ["friction / adhesion φₜ/φₙ", "press depth δ/δ₀"]
    page.apply(None)
    assert page.scene.phi_ratio == float(f"{page.fitted.values['phi_ratio']:.5g}")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "line 1: "),
        (b"U_x,F\n1,2\n1,x\n", "line 3: F = 'x'"),
        (b"U_x (nm),F (mN)\n" + ROWS, "divide it by the width of the contact"),
        (b"\xff\xfe\x00", "line 1: "),
        (b"1" * 2_000_001, "2000001 bytes; allowed: 2000000"),
    ],
)
def test_an_unusable_file_is_reported_and_the_previous_measurement_stays(content, said):
    page = fit.Fit(SMALL)
    page.start(partial(page.read, b"U_x,F\n" + ROWS))
    assert "19 points" in page.text
    page.start(partial(page.read, content))
    assert said in page.text and page.measured.U_x.size == 19


def test_the_page_fit_reads_the_curve_over_the_run_of_the_experiment_or_asks_for_the_file(monkeypatch):
    monkeypatch.setitem(measured._kept, "key", (b"U_x,F\n" + ROWS, None, None))
    for key, said in (("key", "19 points"), ("gone", "Choose the file again")):
        page = fit.Fit(SMALL)
        page.key = key
        page.layout()
        assert said in page.text


def test_no_fit_starts_without_a_measurement_or_a_free_parameter():
    page = fit.Fit(SMALL)
    page.start(page.fit)
    assert page.text.startswith("There is no measurement")
    page.start(partial(page.read, b"U_x,F\n" + ROWS))
    page.free = []
    page.start(page.fit)
    assert page.text.startswith("No parameter is free")


def test_cancel_frees_the_worker():
    page = accuracy.Accuracy(Scene())

    async def cancelled():
        page.start(page.measure)
        while not page.points:
            await asyncio.sleep(0.05)
        page.cancel()
        while pool.in_flight:
            await asyncio.sleep(0.05)

    asyncio.run(asyncio.wait_for(cancelled(), 300.0))
    assert page.text == "Cancelled." and page.share is None


def test_too_many_increments_are_refused_with_a_remedy():
    page = stick_slip.StickSlip(SMALL.changed(du_x=0.001))
    page.layout()
    assert page.text.startswith("du_x = 0.001") and "enlarge it" in page.text


def test_the_cost_of_a_tolerance_is_relative_to_the_largest_one():
    points = [
        Point("tolerance", "fast", value, 0.1, count, error, error, error)
        for value, count, error in ((1e-3, 100, 1e-4), (1e-8, 150, 1e-9))
    ]
    said = accuracy.cost(points)
    assert "to 1e-09 for 150 force evaluations" in said and "1.5 times those at 0.001 nm" in said
    assert "No run at tolerance 1e-05" in accuracy.cost(points, 1e-5)


def test_stored_points_are_of_both_methods_and_reach_a_millionth():
    points = [Point(**row) for row in accuracy.STORED["points"]]
    assert {point.series for point in points} == {"fast", "gfmd"}
    for series in ("fast", "gfmd"):
        assert min(point.branch_error for point in points if point.series == series) < 1e-6
