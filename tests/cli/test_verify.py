"""`verify` repeats the run of a file: it reports "same" or what differs, and refuses other files."""

import json
import re

import numpy as np
import pytest

import solver.cli as cli
from solver import Profile, Scene, load_path
from solver.files import report_of, write_json

SMALL = ("--set", "nodes=64", "width=160", "radius=0.6", "delta_bar=0.1", "E=40", "u_x_max=8")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("verify")
    named = {kind: folder / f"run.{kind}" for kind in ("json", "npz")}
    assert cli.main(["run", *SMALL, *(str(x) for kind, file in named.items() for x in (f"--{kind}", file))]) == 0
    return named


@pytest.mark.parametrize("kind", ["json", "npz"])
def test_verify_finds_a_repeated_run_equal(files, capsys, kind):
    assert cli.main(["verify", str(files[kind])]) == 0
    out = capsys.readouterr().out
    assert "same: " in out and "version" in out and "residual" in out


def test_verify_leaves_out_a_retired_parameter_and_names_it(files, tmp_path, capsys):
    report = json.loads(files["json"].read_text())
    report["scene"]["window_n"] = 10.0
    (tmp_path / "old.json").write_text(json.dumps(report))
    assert cli.main(["verify", str(tmp_path / "old.json")]) == 0
    assert "window_n = 10.0: it has no effect since version 0.2" in capsys.readouterr().out


def test_verify_names_a_changed_number_and_its_size(files, tmp_path, capsys):
    report = json.loads(files["json"].read_text())
    report["F_s"] *= 1.001
    report["events"].pop()
    (tmp_path / "changed.json").write_text(json.dumps(report))
    assert cli.main(["verify", str(tmp_path / "changed.json")]) == 1
    out = capsys.readouterr().out
    assert "F_s " in out and "(1.0e-03)" in out and re.search(r"events: U_x +file \d+ values, here \d+\n", out)


def test_verify_finds_a_changed_field(files, tmp_path, capsys):
    with np.load(files["npz"]) as held:
        arrays = dict(held)
    arrays["T"][-1, 1] *= 1.01
    np.savez(tmp_path / "changed.npz", **arrays)
    assert cli.main(["verify", str(tmp_path / "changed.npz")]) == 1
    out = capsys.readouterr().out
    assert "  T " in out and "  u " not in out


def test_verify_allows_no_difference_above_1_per_cent_however_coarse_the_tolerance(tmp_path, capsys):
    """100 tolerances are five times this delta_n: A_0 times 3 was the same."""
    file, coarse = tmp_path / "run.json", ("tolerance=1e-3", "delta_n=0.02", "phi_n=0.001")
    assert cli.main(["run", *SMALL, *coarse, "--json", str(file)]) == 0
    assert cli.main(["verify", str(file)]) == 0
    report = json.loads(file.read_text())
    file.write_text(json.dumps(report | {"A_0": 3.0 * report["A_0"]}))
    assert cli.main(["verify", str(file)]) == 1
    assert "by more than 1e-02 of their largest\n  A_0 " in capsys.readouterr().out


SOFT = ("--set", "nodes=64", "width=160", "radius=0.2", "du_z=0.5", "du_x=0.5", "u_x_max=2", "E=1.5", "phi_n=2")


def test_verify_repeats_a_run_by_gfmd_without_the_limit_of_a_soft_layer_as_run_computes_it(tmp_path, monkeypatch):
    monkeypatch.setattr("solver.run.loadpath.SOFT_LIMIT", 0.02)
    file = str(tmp_path / "run.json")
    assert cli.main(["run", *SOFT, "--method", "gfmd", "--json", file]) == 0
    assert cli.main(["verify", file]) == 0


@pytest.mark.parametrize("kind", ["json", "npz"])
def test_a_run_that_was_cut_short_is_not_compared(files, tmp_path, capsys, kind):
    file = str(tmp_path / "run")
    assert cli.main(["run", *SMALL, "--limit", "0.001", f"--{kind}", file]) == 1
    assert cli.main(["verify", file]) == 2
    assert "outcome out of time; allowed: a run that was not cut short; run it again" in capsys.readouterr().err
    assert cli.main(["verify", str(files[kind]), "--limit", "0.001"]) == 1
    out, err = capsys.readouterr()
    assert err.startswith("not compared: ") and "differs" not in out


def test_verify_reads_the_measured_surface_of_a_file(tmp_path):
    x = np.linspace(0.0, 160.0, 128, endpoint=False)
    profile = Profile(160.0, 5.0 * np.exp(-(((x - 80.0) / 30.0) ** 2)))
    scene = Scene(surface="measured", measured=profile, nodes=64, width=160.0, u_x_max=2.0)
    frames = list(load_path(scene))
    write_json(tmp_path / "run.json", report_of(scene, frames, "fast", 0.0, None))
    assert cli.main(["verify", str(tmp_path / "run.json")]) == 0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "not a run"),
        ("{}", "not a run"),
        ('{"schema": 99}', "schema 99; allowed: 2; use the version that wrote it"),
        ('{"schema": 1}', "schema 1; allowed: 2; use the version that wrote it, or write it again"),
        ('{"schema": 2, "version": "0", "commit": null, "method": "fast", "scene": {"E": -1}}', "not a run"),
    ],
    ids=["empty", "no scene", "a later schema", "an earlier schema", "an invalid scene"],
)
def test_verify_rejects_other_files_in_one_line(tmp_path, capsys, content, words):
    (tmp_path / "file").write_text(content)
    assert cli.main(["verify", str(tmp_path / "file")]) == 2
    err = capsys.readouterr().err
    assert words in err and len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"method": "foo"}, "method foo; allowed: fast, gfmd; use the version that wrote it"),
        ({"scene": []}, "not a run"),
        ({"events": [1]}, "not a run"),
        ({"F_s": "large"}, "not a run"),
    ],
)
def test_verify_rejects_a_file_with_a_wrong_field_in_one_line(files, tmp_path, capsys, changed, words):
    (tmp_path / "file").write_text(json.dumps(json.loads(files["json"].read_text()) | changed))
    assert cli.main(["verify", str(tmp_path / "file")]) == 2
    err = capsys.readouterr().err
    assert words in err and len(err.splitlines()) == 1


def test_a_missing_file_is_named(tmp_path, capsys):
    assert cli.main(["verify", str(tmp_path / "none.json")]) == 2
    assert "none.json" in capsys.readouterr().err
