"""What Python users get: `simulate` and `sweep` give tables with units, plots and a summary for notebooks."""

import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from html import escape, unescape
from math import inf, nan
from time import thread_time
from types import SimpleNamespace

import holoviews
import numpy as np
import pandas as pd
import pytest
from exact_interior import inside

import solver
from solver import (
    Axis,
    Map,
    NotConverged,
    Scene,
    SceneError,
    explore_map,
    fit,
    load_path,
    plots,
    read_profile,
    simulate,
    skeleton_of,
    summarize,
    sweep,
)
from solver.executors import processes
from solver.files import report_of, write_npz
from solver.measured.measurement import Measurement
from solver.results import time_limit
from solver.text import counted, in_ascii

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
        assert [row["F (N/m)"], row["L (N/m)"], row["A (nm)"]] == pytest.approx(bars, rel=1e-12, abs=1e-6)  # round-off


def test_xarray_gets_the_curves_and_the_traction_over_position_with_the_parameters_that_differ(result, monkeypatch):
    """With a record in place of xarray: where that is installed, pyFFTW imports it, and pandas, on `import solver`."""
    monkeypatch.setitem(
        sys.modules, "xarray", SimpleNamespace(Dataset=lambda data, **more: SimpleNamespace(**data, **more))
    )
    data = result.to_xarray()
    assert data.F[0] == "increment" and list(data.F[1]) == result.table["F (N/m)"].tolist()
    assert [data.F[2], data.A[2], data.stage[2]] == [{"units": "N/m"}, {"units": "nm"}, {}]
    assert data.T_z[0] == ("increment", "x") and data.coords["x"][1].size == data.T_z[1].shape[1]
    assert list(data.T_z[1][-1]) == list(result.frames[-1].T[1]) and data.T_x[2] == {"units": "GPa"}
    assert list(data.T_x[1][-1]) == list(result.frames[-1].T[0])
    assert data.attrs == SMALL.differences()


def test_xarray_and_npz_count_x_from_the_middle_of_the_cell(result, monkeypatch, tmp_path):
    monkeypatch.setitem(
        sys.modules, "xarray", SimpleNamespace(Dataset=lambda data, **more: SimpleNamespace(**data, **more))
    )
    write_npz(tmp_path / "run.npz", SMALL, result.frames)
    with np.load(tmp_path / "run.npz") as held:
        for x, T in ((held["x"], held["T"][-1]), (result.to_xarray().coords["x"][1], result.frames[-1].T)):
            assert set(x) <= set(SMALL.x - 80.0) and abs(x[np.abs(T).sum(0)[: x.size].argmax()]) < 40.0


def test_slips_are_the_events_of_the_run(result):
    summary = summarize(result.frames)
    assert len(result.slips) == len(summary["events"]) > 1
    first = result.slips[result.slips["stage"] == "shear"].iloc[0]
    assert first[["U_s (nm)", "F_s (N/m)", "L_s (N/m)", "A_s (nm)"]].tolist() == list(result.first_slip)
    assert list(result.first_slip) == [summary[name] for name in ("U_s", "F_s", "L_s", "A_s")]
    event = next(event for frame in result.frames for event in frame.slips if event.stage == "shear")
    bars = [event.F_bar * 160.0 * 30.0, event.L_bar * 160.0 * 30.0, event.A_bar * 160.0]
    assert list(result.first_slip)[1:] == pytest.approx(bars, rel=1e-12)  # round-off


def test_a_run_without_a_slip_has_no_first_slip_and_no_pull_off():
    short = simulate(SMALL.changed(u_x_max=1.0))
    assert short.first_slip is None and short.pull_off is None


def test_a_misspelt_name_of_a_sweep_is_answered_by_the_one_meant():
    with pytest.raises(ValueError, match=r"; did you mean delta_bar\?$"):
        sweep(SMALL, deltabar=[0.1])


def test_slips_and_sweeps_show_all_columns_on_80_characters(result):
    table = sweep(SMALL, delta_bar=[0.1, 0.2], phi_ratio=[0.5, 1.0])
    with pd.option_context("display.width", 80, "display.max_columns", 0):
        for shown in (repr(result.slips), repr(table)):
            assert all(name in shown for name in ("U_s (nm)", "F_s (N/m)", "L_s (N/m)", "A_s (nm)")), shown
            assert "..." not in shown and "e+" not in shown and max(map(len, shown.split("\n"))) <= 80


def test_the_friction_of_a_symmetric_approach_is_zero(result):
    assert (result.table["F (N/m)"][result.table["stage"] == "approach"] == 0.0).all()
    slips = simulate(Scene(u_x_max=0.2)).slips
    jumps = slips[slips["stage"] == "approach"]
    assert len(jumps) and (jumps["F_s (N/m)"] == 0.0).all() and (jumps["U_s (nm)"] == 0.0).all()


def test_slips_of_a_retraction_have_their_indentation():
    cycle = simulate(Scene(path="unload", du_z=0.5))
    off = cycle.slips[cycle.slips["stage"] == "unload"].iloc[-1]
    events = [event for frame in cycle.frames for event in frame.slips if event.stage == "unload"]
    assert (off["U_s (nm)"], off["delta_s (nm)"]) == (0.0, events[-1].load)
    assert off["kind"] == "pull-off" and cycle.table["L (N/m)"].min() <= off["L_s (N/m)"] < 0.0
    assert (cycle.slips["kind"] == "pull-off").sum() == 1
    assert list(cycle.pull_off) == [0.0, off["delta_s (nm)"], off["F_s (N/m)"], off["L_s (N/m)"]]
    numbers = summarize(cycle.frames)
    assert numbers["L_off"] == cycle.pull_off.L  # the parting load; the largest pull comes before, a fifth larger
    least = cycle.table["L (N/m)"].min()  # of unload and reload, whose states are equal to the tolerance
    assert numbers["L_min"] == pytest.approx(least, rel=1e-8) and least < 1.1 * numbers["L_off"] < 0.0
    oblique = simulate(SMALL.changed(path="points", points="0,-1; 0,0.1; 10,0.2"))
    last = oblique.slips.iloc[-1]
    assert last["delta_s (nm)"] == pytest.approx(1.0 + last["U_s (nm)"] * 0.1)  # 1 nm deeper in 10


def test_stress_is_that_of_the_increment_at_depth(result):
    at = result.stress(5.0, z=[0.0, 40.0])
    frame = min((f for f in result.frames if f.stage == "shear"), key=lambda f: abs(f.U_x - 5.0))
    exact = inside(SMALL, frame.first, frame.T, (frame.U_x, -frame.delta), SMALL.x, at.z).stress
    assert at.xx.shape == at.zz.shape == at.xz.shape == (2, 64) and list(at.x) == list(SMALL.x - 80.0)
    assert np.abs(np.array([at.xx, at.zz, at.xz]) - exact).max() < 1e-12 * np.abs(exact).max()
    assert np.abs(at.zz[0, frame.first :][: frame.T.shape[1]] + frame.T[1]).max() < 1e-12  # sigma_zz = -T_z at z = 0
    assert "64 nodes" in repr(at) and result.stress(5.0).z.size == 101
    with pytest.raises(ValueError, match=r"z = -1 .. -1: allowed: 0 .. 160 nm"):
        result.stress(5.0, z=-1.0)


def test_cautions_reach_python_html_and_json(tmp_path):
    soft = simulate(SMALL.changed(E=2.0, u_x_max=0.5))
    (sentence,) = (each for each in soft.cautions if each.startswith("The layer is soft"))
    soft.save(tmp_path / "soft.html")
    assert f"Caution: {in_ascii(sentence)}" in repr(soft)
    for text in (unescape(soft._repr_html_()), unescape((tmp_path / "soft.html").read_text("utf-8"))):
        assert f"Caution: {sentence}" in text
    assert sentence in report_of(soft.scene, soft.frames, "fast", 0.0, None)["cautions"]


def test_notes_on_a_profile_reach_python():
    x = np.linspace(0.0, 160.0, 129)
    rows = "\n".join(f"{a},{5.0 * np.exp(-(((a - 80.0) / 30.0) ** 2))}" for a in x)
    profile = read_profile(rows, unit="nm")
    scene = Scene(surface="measured", measured=profile, width=160.0, nodes=64, u_x_max=0.2)
    assert f"Profile: {profile.notes[0]}" in repr(simulate(scene))


def test_a_pull_off_under_a_held_load_is_an_end_with_its_place_and_force():
    lifted = simulate(SMALL.changed(hold="load", delta_bar=-0.1))
    assert (lifted.outcome, lifted.failure) == ("pulled off", None)
    last = lifted.frames[-1]
    assert lifted.pull_off == (last.U_x, last.delta, last.F, last.L) and last.L < 0.0
    assert len(lifted.table) > 0 and f"under the held load L = {last.L:.4g} N/m" in lifted._repr_html_()
    assert sweep(SMALL.changed(hold="load"), delta_bar=[-0.1])["outcome"][0] == "pulled off"


def test_a_run_beyond_its_limit_of_time_keeps_its_increments_and_gives_a_reason(result):
    early = simulate(result.scene.changed(u_x_max=1000.0), limit=0.2)
    assert early.outcome == "out of time" and early.frames and early.frames[-1].U_x < 1000.0
    assert "Not converged at " in early.failure and "takes more than 0.2 s of processor time" in early.failure
    assert early.failure.endswith("; allow more time by limit=, or try a larger E")
    assert simulate(result.scene, limit=60.0).failure is None  # the remedy
    approach = simulate(SMALL, load=0.01, limit=0.0)
    assert approach.outcome == "out of time" and not approach.frames


def test_a_run_whose_increments_take_half_of_the_memory_keeps_them_and_the_remedy_works(result, monkeypatch):
    frame = result.frames[0]
    monkeypatch.setattr("solver.results.ROOM", (len(result.frames) - 5) * (frame.u.nbytes + frame.T.nbytes))
    full = simulate(result.scene)
    assert full.outcome == "out of memory" and len(full.frames) == len(result.frames) - 4
    assert full.frames[-1].F == result.frames[len(full.frames) - 1].F
    assert (
        f"{len(full.frames)} increments of {frame.u.shape[1]} nodes" in full.failure and "larger du_x" in full.failure
    )
    assert simulate(result.scene.changed(du_x=2.0 * result.scene.du_x)).outcome == "finished"


def test_a_run_without_an_increment_says_why_it_has_nothing_to_show(tmp_path):
    empty = simulate(SMALL, limit=0.0)
    assert not empty.frames and len(empty.table) == len(empty.edges) == 0
    why = "^the run has no increment to show: Not converged .* takes more than 0 s .*; allow more time by limit="
    for show in (lambda: empty.stress(0.0), empty.plot, lambda: empty.save(tmp_path / "run.html")):
        with pytest.raises(ValueError, match=why):
            show()


def test_runs_of_layers_softer_than_the_adhesion_have_a_limit_of_time_within_a_minute():
    """phi_n/E is the stretch that adhesion can give a layer; delta_n its range."""
    assert time_limit(Scene()) == time_limit(Scene(E=10.0)) == inf
    soft = Scene(E=0.5), Scene(E=5.0, phi_n=10.0), Scene(E=2.5, phi_ratio=30.0, nodes=4096, width=10000.0)
    assert len({time_limit(scene) for scene in soft}) == 1 and time_limit(soft[0]) < 60.0
    assert time_limit(soft[0], 3.0) == 3.0 and time_limit(Scene(), 3.0) == 3.0


def test_every_entry_takes_a_limit_of_processor_time():
    with pytest.raises(NotConverged, match="takes more than 0 s of processor time"):
        list(load_path(SMALL, limit=0.0))
    with pytest.raises(NotConverged, match="takes more than 0 s of processor time"):
        skeleton_of(SMALL, limit=0.0)
    assert "takes more than 0 s" in sweep(SMALL, delta_bar=[0.1], limit=0.0)["outcome"][0]
    grid = Map(SMALL, Axis("delta_bar", 0.0, 0.1, 2), Axis("E", 60.0, 70.0, 2))
    with ThreadPoolExecutor(1) as executor:
        assert all("takes more than 0 s" in point.reason for point in explore_map(grid, executor, limit=0.0))


@pytest.mark.parametrize("limit", [nan, -1.0, "5", True])
def test_every_entry_rejects_a_limit_that_is_no_time(limit):
    entries = (
        lambda: simulate(SMALL, limit=limit),
        lambda: list(load_path(SMALL, limit=limit)),
        lambda: skeleton_of(SMALL, limit=limit),
        lambda: sweep(SMALL, delta_bar=[0.1], limit=limit),
        lambda: fit(SMALL, Measurement.of(np.arange(30.0), {"F_bar": np.arange(30.0)}), ["E"], limit=limit),
    )
    for entry in entries:
        with pytest.raises(SceneError, match=r"^limit = .*: allowed: a number of seconds, 0 or more, or None; give"):
            entry()


def test_the_time_of_whoever_takes_the_frames_does_not_count():
    """The limit is five times what the run takes, and its consumer computes for ten times that between the frames."""
    begun = thread_time()
    count = len(list(load_path(SMALL)))
    spent = thread_time() - begun
    frames = 0
    for _ in load_path(SMALL, limit=5.0 * spent):
        frames, end = frames + 1, thread_time() + 10.0 * spent / count
        while thread_time() < end:
            pass
    assert frames == count


def test_a_sweep_has_the_first_slip_of_every_combination_in_order():
    table = sweep(SMALL, delta_bar=[0.1, 0.2], phi_ratio=[1.0, 0.0])
    assert table[["delta_bar", "phi_ratio"]].values.tolist() == [[0.1, 1.0], [0.1, 0.0], [0.2, 1.0], [0.2, 0.0]]
    summary = summarize(list(load_path(SMALL)))
    assert table["U_s (nm)"][0] == summary["U_s"] and table["outcome"][0] == "slips"
    assert table["A_s (nm)"][0] == summary["A_s"]
    assert np.isnan(table["U_s (nm)"][1]) and table["outcome"][1] == "no slip"


@pytest.mark.thorough
def test_a_sweep_in_processes_gives_the_same_numbers():
    with processes(2) as executor:
        alone, spread = (sweep(SMALL, place, delta_bar=[0.1, 0.2]) for place in (None, executor))
    assert alone.equals(spread)


def test_a_sweep_rejects_a_name_that_is_no_parameter():
    with pytest.raises(ValueError, match=r"^name = 'stiffness': allowed: .*\bE\b"):
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
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "bokeh" in page.lower() and not re.search(r"<(script|link)[^>]*(src|href)=\"http", page)
    assert f"<p>{escape(repr(SMALL))}, mixed-mode-contact {solver.__version__}</p>" in page
    with pytest.raises(ValueError, match=r"allowed: a name that ends in \.html, \.png, \.svg; rename it"):
        result.save(tmp_path / "run.pdf")


@pytest.mark.parametrize(("chosen", "names"), [("bokeh", ["run.png", "run.svg"]), ("matplotlib", ["run.html"])])
def test_pictures_have_scene_and_version_and_leave_the_backend_of_a_notebook_as_chosen(result, tmp_path, chosen, names):
    """The suffix needs the other backend; that of the notebook is the chosen one before and after."""
    with plots.drawn_with(chosen):
        for name in names:
            result.save(tmp_path / name)
            assert holoviews.Store.current_backend == chosen
            if name == "run.png":
                assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
            else:
                assert f"mixed-mode-contact {solver.__version__}" in (tmp_path / name).read_text(encoding="utf-8")


def test_a_picture_without_matplotlib_is_refused_with_what_to_install(result, tmp_path, monkeypatch):
    monkeypatch.setattr(plots, "find_spec", lambda name: None)
    remedy = r"\.png needs matplotlib: pip install mixed-mode-contact\[plots\], or write \.html"
    with pytest.raises(ImportError, match=remedy):
        result.save(tmp_path / "run.png")


def test_a_table_is_saved_as_csv(result, tmp_path):
    result.save(tmp_path / "run.csv")
    assert pd.read_csv(tmp_path / "run.csv").equals(result.table)


def test_plots_in_a_notebook_need_no_internet(monkeypatch):
    given = []
    monkeypatch.setattr("holoviews.Store.loaded_backends", lambda: [])
    monkeypatch.setattr("holoviews.extension", lambda *names, **options: given.append(options))
    plots._ready()
    assert given[0]["inline"] is True


def test_a_result_prints_what_a_notebook_shows(result):
    lines = str(result).split("\n")
    assert lines[0].startswith("Scene: delta_bar = 0.1, ") and lines[2].startswith("First slip at U_x = ")
    assert all(f"<p>{escape(line)}</p>" in result._repr_html_() for line in lines)


def test_a_frame_prints_its_place_and_forces(result):
    assert re.fullmatch(
        r"Frame\(shear \d+: U_x = 20 nm, delta = 1 nm, F = .* N/m, L = .* N/m, A = .* nm\)", repr(result.frames[-1])
    )


def test_a_notebook_shows_what_differs_the_first_slip_and_a_curve(result):
    shown = result._repr_html_()
    assert f"{summarize(result.frames)['slips']} slips" in shown
    assert "delta_bar = 0.1" in shown and "First slip at U_x = " in shown and "<polyline" in shown
    assert " N/m" in shown and " nm" in shown


def test_importing_the_solver_and_its_command_imports_no_web_stack_and_no_analysis_but_offers_all_exports():
    heavy = ["panel", "bokeh", "holoviews", "pandas", "tornado", "tqdm", "prometheus_client"]
    analysis = ["solver.measured", *(f"solver.analysis.{name}" for name in ("sensitivities", "maps"))]
    code = f"""
import sys, solver
print({{*{heavy + analysis}}} & {{*sys.modules}}, {{*solver.__all__}} - {{*dir(solver)}})
solver.fit
print("solver.measured.fit" in sys.modules)
import solver.cli
from solver.accuracy import measure, report
print({{*{heavy}}} & {{*sys.modules}})
"""
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert shown.stdout.split("\n")[:-1] == ["set() set()", "True", "set()"]


@pytest.mark.parametrize("name", [*solver.LAZY, "simulate", "sweep"])
def test_entry_points_document_parameters_results_and_errors_by_an_example(name):
    text = getattr(solver, name).__doc__
    if name in ("Axis", "Map"):
        assert "Raises" in text
    elif name in ("Boundary", "UnstableBranch"):  # results
        assert "Example: " in text
    else:
        assert all(word in text for word in ("Parameters: ", "Returns ", "Example: ")), text


def test_an_unknown_name_of_the_solver_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'anneal'"):
        solver.anneal  # noqa: B018


def test_maps_of_the_exported_functions_are_tables_over_both_parameters():
    grid = Map(SMALL, Axis("delta_bar", 0.1, 0.2, 2), Axis("phi_ratio", 0.5, 1.0, 2))
    table = grid.table(explore_map(grid)).set_index(["delta_bar", "phi_ratio"])
    first = sweep(SMALL, delta_bar=[0.1, 0.2], phi_ratio=[0.5, 1.0]).set_index(["delta_bar", "phi_ratio"])
    for place, U_s in first["U_s (nm)"].items():
        assert table["U_s"][place] == pytest.approx(U_s, abs=1e-5)  # nm; ends of branches are located to 1e-6


@pytest.mark.parametrize(("count", "text"), [(0, "0 slips"), (1, "1 slip"), (2, "2 slips")])
def test_counts_of_one_use_the_singular(count, text):
    assert counted(count, "slip") == text
