"""What Python users get: `simulate` and `sweep` give tables with units, plots and a summary for notebooks."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import solver
from solver import Axis, Map, Scene, explored, load_path, plots, simulate, summarize, sweep
from solver.text import counted

SMALL = Scene(nodes=64, width=160.0, radius=0.6, delta_bar=0.1, E=30.0, u_x_max=20.0)


@pytest.fixture(scope="module")
def result():
    return simulate(SMALL)


def test_the_table_holds_the_frames_in_nm_and_newton_per_metre(result):
    frames = list(load_path(SMALL))
    assert len(result.table) == len(frames) and result.failure is None
    for frame, (_, row) in zip(frames, result.table.iterrows(), strict=True):
        assert (row["stage"], row["U_x (nm)"], row["slip"]) == (frame.stage, frame.U_x, frame.slip)
        bars = [frame.F_bar * 160.0 * 30.0, frame.L_bar * 160.0 * 30.0, frame.A_bar * 160.0]
        assert [row["F (N/m)"], row["L (N/m)"], row["A (nm)"]] == pytest.approx(bars, rel=1e-12)  # round-off


def test_xarray_gets_the_curves_and_the_traction_over_position_with_the_parameters_that_differ(result, monkeypatch):
    """With a record in place of xarray: where that is installed, pyFFTW imports it, and pandas, on `import solver`."""
    monkeypatch.setitem(
        sys.modules, "xarray", SimpleNamespace(Dataset=lambda data, **more: SimpleNamespace(**data, **more))
    )
    data = result.to_xarray()
    assert data.F[0] == "increment" and list(data.F[1]) == result.table["F (N/m)"].tolist()
    assert data.T_z[0] == ("increment", "x") and data.coords["x"].size == data.T_z[1].shape[1]
    assert list(data.T_z[1][-1]) == list(result.frames[-1].T[1])
    assert data.attrs == SMALL.differences()


def test_slips_are_the_events_of_the_run(result):
    summary = summarize(SMALL, result.frames)
    assert len(result.slips) == len(summary["events"]) > 1
    first = result.slips[result.slips["stage"] == "shear"].iloc[0]
    assert first["load (nm)"] == summary["U_s"]
    assert first["F (N/m)"] == pytest.approx(summary["F_s"] * 160.0 * 30.0, rel=1e-12)  # round-off


def test_a_run_that_fails_keeps_what_it_has_and_names_a_remedy():
    lifted = simulate(SMALL.changed(hold="load", delta_bar=-0.1))
    assert "pulled off" in lifted.failure and "press harder" in lifted.failure
    assert len(lifted.table) > 0 and lifted.failure in lifted._repr_html_()
    assert "pulled off" in sweep(SMALL.changed(hold="load"), delta_bar=[-0.1])["outcome"][0]


def test_a_sweep_has_the_first_slip_of_every_combination_in_order():
    table = sweep(SMALL, delta_bar=[0.1, 0.2], phi_ratio=[1.0, 0.0])
    assert table[["delta_bar", "phi_ratio"]].values.tolist() == [[0.1, 1.0], [0.1, 0.0], [0.2, 1.0], [0.2, 0.0]]
    summary = summarize(SMALL, list(load_path(SMALL)))
    assert table["U_s (nm)"][0] == summary["U_s"] and table["outcome"][0] == "slips"
    assert table["A_0 (nm)"][0] == pytest.approx(summary["A_0"] * 160.0, rel=1e-12)
    assert np.isnan(table["U_s (nm)"][1]) and table["outcome"][1] == "no slip"


def test_a_sweep_in_processes_gives_the_same_numbers():
    alone, spread = (sweep(SMALL, delta_bar=[0.1, 0.2], workers=n) for n in (1, 2))
    assert alone.equals(spread)


def test_a_sweep_rejects_a_name_that_is_no_parameter():
    with pytest.raises(ValueError, match=r"stiffness is no parameter.*allowed: .*\bE\b"):
        sweep(SMALL, stiffness=[1.0])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"delta_bar": 0.2}, r"delta_bar = 0.2: allowed: a list of values; write delta_bar=\[0.2\]"),
        ({"surface": "flat"}, r"surface = 'flat': allowed: a list of values; write surface=\['flat'\]"),
    ],
)
def test_a_sweep_rejects_a_value_that_is_no_list(values, message):
    with pytest.raises(ValueError, match=message):
        sweep(SMALL, **values)


def test_the_plot_is_saved_as_html_and_other_suffixes_are_rejected(result, tmp_path):
    result.save(tmp_path / "run.html")
    assert "bokeh" in (tmp_path / "run.html").read_text(encoding="utf-8").lower()
    with pytest.raises(ValueError, match=r"\.html or \.png"):
        result.save(tmp_path / "run.pdf")


def test_a_result_prints_its_scene_in_a_few_lines(result):
    assert "delta_bar=0.1" in repr(result) and len(repr(result)) < 1000


def test_a_notebook_shows_what_differs_the_first_slip_and_a_curve(result):
    shown = result._repr_html_()
    assert f"{summarize(SMALL, result.frames)['slips']} slips" in shown
    assert "delta_bar = 0.1" in shown and "first slip at U_x = " in shown and "<polyline" in shown
    assert " N/m" in shown and " nm" in shown


def test_importing_the_solver_imports_no_web_stack():
    heavy = "{'panel', 'bokeh', 'holoviews', 'pandas', 'tornado', 'tqdm', 'prometheus_client'}"
    check = f"import sys, solver; print(sorted({heavy} & set(sys.modules)))"
    shown = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=120, check=True)
    assert shown.stdout.strip() == "[]"


def test_importing_the_solver_imports_no_analysis_until_it_is_asked_for():
    heavy = "'solver.analysis.fit', 'solver.analysis.sensitivities', 'solver.analysis.maps'"
    check = f"import sys, solver; before = {{{heavy}}} & set(sys.modules); solver.fit; "
    check += "print(sorted(before), 'solver.analysis.fit' in sys.modules)"
    shown = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=120, check=True)
    assert shown.stdout.strip() == "[] True"


@pytest.mark.parametrize("name", [*solver.LAZY, "simulate", "sweep"])
def test_entry_points_document_parameters_results_and_errors_by_an_example(name):
    text = getattr(solver, name).__doc__
    if name in ("Axis", "Map"):
        assert "Raises" in text
    else:
        assert all(word in text for word in ("Parameters: ", "Returns ", "Example: ")), text


def test_all_exports_are_offered_for_completion_and_to_the_reference():
    check = "import solver; print(set(solver.__all__) - set(dir(solver)))"  # nothing is imported yet
    shown = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=120, check=True)
    assert shown.stdout.strip() == "set()"


def test_an_unknown_name_of_the_solver_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'anneal'"):
        solver.anneal  # noqa: B018


def test_maps_of_the_exported_functions_are_tables_over_both_parameters():
    grid = Map(SMALL, Axis("delta_bar", 0.1, 0.2, 2), Axis("phi_ratio", 0.5, 1.0, 2))
    table = grid.table(explored(grid)).set_index(["delta_bar", "phi_ratio"])
    first = sweep(SMALL, delta_bar=[0.1, 0.2], phi_ratio=[0.5, 1.0]).set_index(["delta_bar", "phi_ratio"])
    for place, U_s in first["U_s (nm)"].items():
        assert table["U_s"][place] == pytest.approx(U_s, abs=1e-5)  # nm; ends of branches are located to 1e-6


@pytest.mark.parametrize(("count", "text"), [(0, "0 slips"), (1, "1 slip"), (2, "2 slips")])
def test_counts_of_one_use_the_singular(count, text):
    assert counted(count, "slip") == text


@pytest.mark.slow
def test_friction_over_load_plot_omits_runs_without_a_slip():
    """F_s does not vanish with L: at the default, adhesion alone holds."""
    from bokeh.models import HoverTool, Scatter
    from holoviews import render

    quick = Scene(nodes=256, width=625.0, du_x=0.5, u_x_max=14.0)
    table = sweep(quick, delta_bar=[0.0, 0.2], phi_ratio=[0.0, 1.0])
    figure = render(plots.friction_over_load(table), backend="bokeh")
    drawn = next(part for part in figure.renderers if isinstance(part.glyph, Scatter))
    slips = table[table["outcome"] == "slips"]
    assert 0 < len(slips) < len(table)
    data, glyph = drawn.data_source.data, drawn.glyph
    assert list(data[glyph.x]) == list(slips["L_s (N/m)"]) and list(data[glyph.y]) == list(slips["F_s (N/m)"])
    assert min(data[glyph.x]) < 0.0 < min(data[glyph.y])
    tips = str(next(tool for tool in figure.tools if isinstance(tool, HoverTool)).tooltips)
    assert "delta_bar" in tips and "phi_ratio" in tips
