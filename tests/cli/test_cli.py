"""The command line: exit codes, one-line errors, and what the files hold."""

import csv
import io
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pandas as pd
import pytest
from numba.core.event import install_listener

import solver.cli as cli
from solver import (
    LIMITS,
    NotConverged,
    Profile,
    Scene,
    SceneError,
    __version__,
    load_path,
    read_profile,
    simulate,
    sweep,
)
from solver.cli import run
from solver.cli.main import CLOSED_PIPE, CompilingNotice
from solver.cli.options import scene_of
from solver.cli.pairs import InputError
from solver.continuation.gfmd import Gfmd
from solver.files import SCHEMA
from solver.run.loadpath import METHODS
from solver.scene import CHOICES, PARAMETERS
from solver.text import in_ascii

ROOT = Path(__file__).parents[2]
SMALL = ("nodes=64", "width=160", "u_x_max=2")
SUBCOMMANDS = re.findall(r"^    (\w+)", cli.parser().format_help(), re.M)
HEADER = "stage,U_x (nm),delta (nm),U_x_top (nm),delta_top (nm),F (N/m),L (N/m),A (nm),residual (nm),evaluations,slip"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The three files of one small run that slips, from a real process, and that process."""
    folder = tmp_path_factory.mktemp("run")
    files = {kind: folder / f"out.{kind}" for kind in ("csv", "npz", "json")}
    options = [word for kind, file in files.items() for word in (f"--{kind}", file)]
    settings = ["--set", "nodes=64", "width=160", "--set", "u_x_max=8"]
    command = [sys.executable, "-m", "solver", "run", *settings, *options]
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    return SimpleNamespace(**files, process=process)


def rows(file):
    with open(file, newline="") as text:
        return list(csv.DictReader(text))


def sheared(file):
    """The rows after the approach."""
    return [row for row in rows(file) if row["stage"] != "approach"]


def wrote(err):
    """The files that a command reports on standard error; beside cautions on a small cell it may print nothing else."""
    lines = [line for line in err.splitlines() if not line.startswith("Caution: The ")]
    assert all(line.startswith("wrote ") for line in lines), err
    return [Path(line.removeprefix("wrote ")) for line in lines]


def strict(file):
    return json.loads(file.read_text(), parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))


@pytest.mark.slow
def test_a_run_succeeds_with_a_summary_and_names_the_files_it_wrote(written):
    """With a cold cache a line on compiling comes first; the punch is as wide as its cell, a caution says."""
    assert written.process.returncode == 0
    lines = written.process.stderr.splitlines()
    lines = [line for line in lines if not line.startswith(("Compiling", "Caution: The "))]
    assert lines == [f"wrote {file}" for file in (written.csv, written.npz, written.json)]
    shown, summary = written.process.stdout, json.loads(written.json.read_text())
    first = f"F = {summary['F_s']:.4g} N/m, A = {summary['A_s']:.4g} nm"
    assert f"first slip at U_x = {summary['U_s']:.2f} nm: {first}" in shown
    assert f"A_0 = {summary['A_0']:.4g} nm" in shown and "evaluations" in shown


def test_json_names_its_schema_and_what_computed_it(written):
    summary = json.loads(written.json.read_text())
    assert (summary["schema"], summary["version"]) == (SCHEMA, __version__)
    assert summary["commit"] is None or re.fullmatch(r"[0-9a-f]{7,}\+?", summary["commit"])


def test_csv_is_the_table_of_the_result(written):
    assert written.csv.read_text().split("\n")[0] == HEADER
    table = pd.read_csv(written.csv)
    assert table.equals(simulate(Scene(nodes=64, width=160.0, u_x_max=8.0)).table)
    assert table["U_x (nm)"][table["stage"] == "shear"].tolist() == [0.1 * k for k in range(81)]
    assert table["F (N/m)"][table["stage"] == "approach"].tolist() == 101 * [0.0]  # not what round-off leaves


def test_json_holds_scene_version_method_and_summary(written):
    report = strict(written.json)
    table = sheared(written.csv)
    assert Scene(**report["scene"]) == Scene(nodes=64, width=160.0, u_x_max=8.0)
    assert (report["version"], report["method"], report["converged"]) == (__version__, "fast", True)
    assert report["A_0"] == float(table[0]["A (nm)"])
    assert report["cautions"] == list(simulate(Scene(nodes=64, width=160.0, u_x_max=8.0)).cautions)
    assert report["slips"] >= sum(row["slip"] == "True" for row in table) > 0
    assert report["seconds"] > 0
    # The approach counts too.
    assert report["evaluations"] > sum(int(row["evaluations"]) for row in table)
    k = next(k for k, row in enumerate(table) if row["slip"] == "True")
    assert float(table[k - 1]["U_x (nm)"]) <= report["U_s"] <= float(table[k]["U_x (nm)"])
    # The force at the end of the branch, within what it changes by in the last part of an increment.
    assert report["F_s"] == pytest.approx(float(table[k - 1]["F (N/m)"]), rel=0.05)


def test_npz_holds_curves_and_fields_that_agree(written):
    scene = Scene(nodes=64, width=160.0, u_x_max=8.0)
    with np.load(written.npz) as data:
        frames, m = len(data["U_x"]), len(data["x"])
        assert frames == 81
        assert data["u"].shape == data["T"].shape == (frames, 2, m)
        for name in HEADER.split(","):
            array = data[name.split(" ")[0]].tolist()
            assert list(map(str, array)) == [row[name] for row in sheared(written.csv)]
        # Outside the patch nothing acts: the sums over it are the forces, up to what counts as zero.
        for k, name in enumerate("FL"):
            expected = (2 * k - 1) * data["T"][:, k].sum(1) * scene.spacing
            assert np.allclose(expected, data[name], rtol=1e-10, atol=1e-6)
        assert np.allclose(np.diff(data["x"]), scene.spacing)
        assert abs(data["x"][np.abs(data["T"]).sum((0, 1)).argmax()]) < scene.width / 4  # from the middle of the cell


def test_the_summary_of_a_run_does_not_depend_on_the_files_that_are_written(call, tmp_path):
    """Its waves may flutter, which only the fields of its frames show."""
    settings = ["nodes=192", "width=480", "radius=1", "damping=0.3", "phi_ratio=0.5", "du_x=0.5", "u_x_max=8"]
    summaries = []
    for more in ([], ["--npz", str(tmp_path / "b.npz")]):
        file = tmp_path / f"{len(more)}.json"
        _, _, err = call("run", "--set", *settings, "--json", str(file), *more)
        assert "Damping 0.3 is low for this contact" in err
        summaries.append({name: value for name, value in strict(file).items() if name != "seconds"})
    assert summaries[0] == summaries[1] and summaries[0]["safe_damping"] > 0.3 and summaries[0]["may_flutter"] > 0


@pytest.mark.parametrize("method", ["fast", "gfmd"])
def test_a_run_that_never_slips_has_nulls_and_no_nan(call, tmp_path, method):
    code, out, _ = call("run", "--method", method, "--set", *SMALL, "--json", tmp_path / "j")
    report = strict(tmp_path / "j")
    assert (code, report["method"], report["slips"]) == (0, method, 0)
    assert report["U_s"] is report["F_s"] is report["A_s"] is None
    assert "0 slips" in out


@pytest.mark.parametrize(
    ("settings", "last"),
    [
        (("path=points", "points=0,-1;0,.1;10,.2"), "2 slips; first slip at U_x = 4.54 nm: F = 77.56 N/m"),
        (("path=points", "points=0,-1;0,.1;-10,.1"), "slips; first slip at U_x = -"),
        (("path=points", "points=0,-1;0,.2;0,.1"), "0 slips; largest pull L = "),
        (("path=points", "points=0,-1;0,.2;0,.3"), "0 slips; the contact sticks or slides smoothly"),
        (("path=points", "points=0,-1;0,-.9;0,.3", "E=5"), "1 slip; none along U_x"),
        (
            ("delta_bar=-.1", "hold=load", "width=312.5", "nodes=128", "radius=20"),
            "0 slips; pulled off at U_x = 2.2 nm, delta = ",
        ),
    ],
)
def test_the_last_line_names_the_first_slip_of_any_stage_or_why_there_is_none(call, settings, last):
    given = {"nodes": "64", "width": "160", "radius": "0.6", "u_x_max": "10"} | dict(
        setting.split("=") for setting in settings
    )
    _, out, _ = call("run", "--set", *map("=".join, given.items()))
    assert last in out.splitlines()[-1]


def test_infinite_damping_is_read_and_written_as_text(call, tmp_path):
    code, *_ = call("run", "--set", "nodes=64", "width=160", "u_x_max=1", "damping=inf", "--json", tmp_path / "j")
    assert code == 0 and strict(tmp_path / "j")["scene"]["damping"] == "inf"


@pytest.mark.slow
def test_every_end_of_a_branch_is_an_event_with_its_kind_and_load(call, tmp_path):
    call("run", "--set", "du_x=0.5", "u_x_max=12", "--json", tmp_path / "j")
    events = strict(tmp_path / "j")["events"]
    assert {e["stage"] for e in events} == {"approach", "shear"}
    assert all(e["kind"] == "fold" and e["located"] is True and e["sensitive"] is False for e in events)
    assert all(("delta" if e["stage"] == "approach" else "U_x") in e and e["F"] is not None for e in events)
    assert next(e["F"] for e in events if e["stage"] == "approach") == 0.0


def test_a_decimal_comma_and_a_unit_are_read_and_the_comma_is_reported(call, tmp_path):
    small = "nodes=64", "width=0.16 µm", "u_x_max=0", "delta_bar=−0,5"
    code, out, err = call("run", "--set", *small, "--json", tmp_path / "j")
    scene = strict(tmp_path / "j")["scene"]
    assert (code, scene["width"], scene["delta_bar"]) == (0, 160.0, -0.5) and wrote(err) == [tmp_path / "j"]
    assert "decimal point, -0.5" in out and "µm" not in out


def test_without_shear_the_csv_has_one_row(call, tmp_path):
    code, *_ = call("run", "--set", "nodes=64", "width=160", "u_x_max=0", "--csv", tmp_path / "c")
    assert code == 0
    assert [row["U_x (nm)"] for row in sheared(tmp_path / "c")] == ["0.0"]


@pytest.mark.parametrize("name", LIMITS)
def test_beyond_a_limit_one_line_names_parameter_value_and_range(call, name):
    low, high = LIMITS[name][:2]
    for value in (low - 1, high * 2):
        code, out, err = call("run", "--set", f"{name}={value}")
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert re.search(rf"{name} = {re.escape(f'{float(value)!r}')}.*{re.escape(f'{low:g} .. {high:g}')}", err)


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("delta_bar=nan", ("delta_bar", "nan", "-1 .. 100")),
        ("delta_bar=deep", ("delta_bar", "deep", "-1 .. 100")),
        ("delta_bar=", ("delta_bar", "''", "-1 .. 100")),
        ("nodes=1e9", ("nodes", "1000000000", "4 .. 16384")),
        ("nodes=" + "9" * 400, ("nodes", "inf", "4 .. 16384")),
        ("nodes=64.5", ("nodes", "64.5", "4 .. 16384")),
        ("nodes=16", ("nodes", "16", "nm must lie within")),
        ("surface=bumpy", ("surface", "bumpy", "circular, flat, wave, rough, measured")),
        ("surface=measured", ("surface", "measured", "profile=FILE")),
        ("measured=file.csv", ("measured", "allowed", "surface")),
        ("waves=1.5", ("waves", "1.5", "a whole number")),
        ("seed=one", ("seed", "one", "0 .. 999999")),
        ("Ebar=3", ("Ebar", "allowed", "delta_bar")),
        ("foo", ("foo", "NAME=VALUE", "delta_bar")),
        ("=3", ("''", "allowed", "delta_bar")),
    ],
)
def test_bad_settings_give_one_line_and_exit_code_two(call, setting, named):
    code, out, err = call("run", "--set", setting)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert all(word in err for word in named)


@pytest.mark.parametrize(
    "arguments", [("run", "--method", "magic"), ("run", "--st"), ("walk",), (), ("accuracy", "--slips", "0")]
)
def test_bad_arguments_give_one_line_and_exit_code_two(call, arguments):
    code, out, err = call(*arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)


@pytest.mark.parametrize("option", ["--csv", "--npz", "--json"])
def test_a_file_that_cannot_be_written_is_refused_before_the_run(call, tmp_path, monkeypatch, option):
    monkeypatch.setattr(run, "load_path", lambda *_, **__: pytest.fail("ran"))
    for file in (tmp_path / "missing" / "file", tmp_path):
        code, _, err = call("run", option, file)
        assert (code, err.count("\n")) == (2, 1)
        assert option in err
        assert str(file) in err


def test_a_measured_profile_is_read_reported_and_written(call, tmp_path):
    file = tmp_path / "hills.csv"
    file.write_text("x (nm),z (nm)\n" + "".join(f"{x},{np.cos(2 * np.pi * x / 160)}\n" for x in range(161)))
    settings = (f"profile={file}", "nodes=64", "du_z=0.5", "du_x=0.5", "u_x_max=2")
    code, out, err = call("run", "--set", *settings, "--json", tmp_path / "j")
    assert code == 0 and wrote(err) == [tmp_path / "j"]
    assert out.count("profile: ") == 3 and "one period of 160 nm" in out
    scene = strict(tmp_path / "j")["scene"]
    again = Scene(**scene | {"measured": Profile(**scene["measured"])})
    assert again == Scene(
        surface="measured", measured=read_profile(file), width=160.0, nodes=64, du_z=0.5, du_x=0.5, u_x_max=2.0
    )
    assert call("run", "--set", settings[0], *settings[2:], "width=80", "nodes=32")[0] == 0


def test_the_unit_of_a_profile_that_names_none_is_given_beside_the_file(call, tmp_path):
    file = tmp_path / "hills.csv"
    file.write_text("".join(f"{x / 1000},{np.cos(2 * np.pi * x / 160) / 1000}\n" for x in range(161)))
    pairs = [f"profile={file}", "nodes=64"]
    with pytest.raises(InputError, match=r"x has no unit; .*; add --units x=... z=...$"):
        scene_of(pairs)
    for units in ({"": "um"}, {"x": "um", "z": "um"}):
        assert scene_of(pairs, None, {"units": units}).width == pytest.approx(160.0)
    with pytest.raises(InputError, match=r"^--units: used with profile=FILE or --measured FILE"):
        scene_of([], None, {"units": {"": "um"}})


@pytest.mark.parametrize(
    ("kind", "option", "words"),
    [
        ("curve", "--cut-off 5", "--cut-off: used with profile=FILE; name a file, or leave it out"),
        ("curve", "--line row3", "--line: used with profile=FILE; name a file"),
        ("curve", "--columns x=1", "columns has 'x'; allowed: U_x, "),
        *(("profile", f"--{name}", "used with --measured FILE; name a file") for name in ("kind a", "speed 3")),
        *(("profile", f"--{name}", "used with --measured FILE") for name in ("sign F=-1", "deflection 4")),
        ("profile", "--columns F=2", "columns has 'F'; allowed: x, z"),
    ],
)
def test_options_of_one_kind_of_file_are_refused_where_only_another_is_read(call, tmp_path, kind, option, words):
    file = tmp_path / "file.csv"
    file.write_text("".join(["U_x (nm),F (N/m)\n" if kind == "curve" else "x (nm),z (nm)\n", "0,0\n1,1\n2,1\n3,0\n"]))
    given = ("--measured", file) if kind == "curve" else ("--set", f"profile={file}")
    code, _, err = call("run", *given, *option.split())
    assert code == 2 and words in err and err.count("\n") == 1


def followed(err, **dots):
    """The options that a refusal names, their dots filled in."""
    words = shlex.split(err.rsplit("; add ", 1)[1])
    return [
        f"{word[:-3]}{dots[word.partition('=')[0].lstrip('-')]}" if word.endswith("...") else word for word in words
    ]


def test_a_refused_profile_is_read_with_the_options_that_the_refusal_names(call, tmp_path):
    file = tmp_path / "steep.csv"
    rows = "".join(f"{x},{x / 1e3},{(20 * np.sin(x / 9) + x % 5) / 1e3}\n" for x in range(400))
    file.write_text(f"Nr,Weg (um),Höhe (um)\n{rows}", encoding="utf-8")
    small = ("run", "--set", f"profile={file}", "nodes=64", "du_z=0.5", "du_x=0.5", "u_x_max=0.5")
    code, _, err = call(*small)
    assert code == 2 and "2 'Weg' (um) 0 .. 0.399" in err
    options = followed(err, x="Weg", z="Höhe")
    code, _, err = call(*small, *options)
    assert code == 2 and "--cut-off" in err and "cut_off" not in err
    code, out, _ = call(*small, *followed(err))
    assert code == 0 and "A Gaussian filter" in out


def test_heights_alone_are_read_by_the_options_that_their_refusal_names(call, tmp_path):
    file = tmp_path / "z.csv"
    file.write_text("Height (nm)\n" + "".join(f"{4.0 * np.cos(0.1 * np.pi * k):.6g}\n" for k in range(129)))
    words = ("run", "--set", f"profile={file}", "nodes=128", "du_z=0.5", "du_x=0.5", "u_x_max=0.5")
    code, _, err = call(*words)
    assert code == 2 and "one column; needed: two columns: x, z in nm, or take none for x" in err
    assert err.rstrip().endswith("; add --columns x=none z=Height --units x=... z=nm")
    code, out, _ = call(*words, "--columns", "x=none", "z=Height", "--units", "x=5 nm", "z=nm")
    assert code == 0 and "x is read as 5 nm" in out


def test_a_measured_curve_is_compared_once_the_options_that_its_refusal_names_are_given(call, tmp_path):
    file = tmp_path / "press.csv"
    result = simulate(Scene(nodes=64, width=160.0, radius=0.6, path="unload", du_z=0.5, delta_bar=0.3))
    rows = "".join(f"{frame.delta / 1e3:.9g},{-1e-3 * frame.L:.9g}\n" for frame in result.frames)
    file.write_text(f"Displacement (um),Force (N)\n{rows}")
    small = ("run", "--set", "nodes=64", "width=160", "radius=0.6", "path=unload", "du_z=0.5", "delta_bar=0.3")
    code, _, err = call(*small, "--measured", file)
    assert code == 2 and err.startswith(f"--measured {file}: a displacement and a force")
    code, _, err = call(*small, "--measured", file, "--kind", "load")
    assert code == 2 and "--sign L=..." in err and "sign=" not in err
    code, out, _ = call(*small, "--measured", file, "--kind", "load", "--sign", "L=-1")
    assert code == 0 and "N/m apart (rms)" in out
    code, _, err = call(*small, "--measured", file, "--kind", "load", "--columns", "q=3")
    assert code == 2 and "columns has 'q'; allowed: U_x, delta" in err
    code, _, err = call(*small, "--measured", file, "--kind", "load", "--units", "L=N/m")
    assert code == 2 and "--units L = 'N/m', but the file names N; leave it out" in err


def test_a_refusal_says_what_1_of_a_unit_is_in_an_option(call, tmp_path):
    file = tmp_path / "volts.csv"
    file.write_text("x (nm),z (V)\n" + "".join(f"{k},{np.cos(0.1 * np.pi * k):.6g}\n" for k in range(41)))
    code, _, err = call("run", "--set", f"profile={file}", "nodes=64", "--units", "nm")
    assert code == 2 and "say what 1 V is, as --units z='10 nm'" in err and "units=" not in err


def test_a_profile_replaces_the_surface_of_a_preset_but_not_one_that_is_named(tmp_path):
    file = tmp_path / "hills.csv"
    file.write_text("x (nm),z (nm)\n" + "".join(f"{x},{np.cos(2 * np.pi * x / 160)}\n" for x in range(161)))
    small = [f"profile={file}", "width=160", "nodes=64"]
    scene = scene_of(small, "rough")
    assert scene.surface == "measured" and scene.measured == read_profile(file)
    assert scene_of([*small, "surface=measured"]).surface == "measured"
    with pytest.raises(
        SceneError, match="surface = 'wave': allowed with profile=FILE: measured; leave one of them out"
    ):
        scene_of([*small, "surface=wave"])


@pytest.mark.parametrize(
    ("text", "reason"), [("x (nm),z (nm)\n1,2\n1,3\n", "line 3: x = 1 after 1"), (None, "is not a file")]
)
def test_a_bad_profile_gives_one_line_and_exit_code_two(call, tmp_path, text, reason):
    file = tmp_path / "bad.csv"
    if text is not None:
        file.write_text(text)
    code, out, err = call("run", "--set", f"profile={file}")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"profile = {str(file)!r}: ") and reason in err


def test_bad_input_leaves_files_as_they_are(call, tmp_path):
    kept = tmp_path / "kept.csv"
    kept.write_text("mine")
    assert call("run", "--csv", kept, "--json", tmp_path / "new", "--npz", tmp_path / "no" / "x")[0] == 2
    assert kept.read_text() == "mine"
    assert not (tmp_path / "new").exists()


@pytest.fixture
def cut_short(monkeypatch):
    """cut_short(error, frames): every load path ends with `error` after that many frames; the warm-up is left alone."""

    def cut(error, count):
        def failing(scene, method, limit=0.0):
            for k, frame in enumerate(load_path(scene, method=method)):
                if k == count and scene not in run.WARM_UP:
                    raise error
                yield frame

        monkeypatch.setattr(run, "load_path", failing)

    return cut


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "cp437"])
def test_units_keep_their_names_in_an_encoding_without_their_letters(encoding):
    command, settings = [sys.executable, "-m", "solver", "parameters"], os.environ | {"PYTHONIOENCODING": encoding}
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, env=settings, check=True).stdout.decode(encoding)
    assert "?" not in listed
    lines = dict(line.split(" ", 1) for line in listed.splitlines() if line[0] != " ")
    assert in_ascii(lines["du_x"]).strip() == "0.001 .. 1 delta_t, default 0.1"


def test_a_soft_layer_is_named_before_its_run_which_ends_by_the_limit(call):
    soft = ("run", "--set", "nodes=64", "width=160", "E=0.5")
    code, _, err = call(*soft, "--limit", "0.01")
    assert code == 1 and "takes more than 0.01 s of processor time" in err and "So soft a layer" not in err
    code, _, err = call(*soft, "u_x_max=0", "delta_bar=-1")
    assert "So soft a layer may take long. The run ends after 50 s of processor time: --limit allows more." in err


@pytest.mark.parametrize("method", METHODS)
def test_a_run_by_any_method_ends_at_a_limit_of_zero(call, method):
    code, _, err = call("run", "--method", method, "--limit", "0", "--set", *SMALL)
    assert code == 1 and "takes more than 0 s of processor time" in err


def test_a_failure_to_converge_exits_with_one_names_the_load_and_writes_the_frames_before(call, tmp_path, cut_short):
    message = "Not converged at U_x = 0.5: residual 2e-5; try a smaller du_x"
    cut_short(NotConverged(message), 101 + 5)
    code, _, err = call(
        "run", "--set", *SMALL, "--csv", tmp_path / "c", "--npz", tmp_path / "n", "--json", tmp_path / "j"
    )
    assert code == 1 and err.splitlines()[-1] == message and err.count("wrote ") == 3
    assert [float(row["U_x (nm)"]) for row in sheared(tmp_path / "c")] == [0.1 * k for k in range(5)]
    report = strict(tmp_path / "j")
    assert report["converged"] is False
    assert report["failure"] == message
    assert report["evaluations"] > 0


def test_a_pull_off_under_a_held_load_is_a_result(call, tmp_path):
    settings = "nodes=128", "width=320", "radius=1", "du_z=0.2", "du_x=0.2", "hold=load", "delta_bar=-0.1"
    code, out, err = call("run", "--set", *settings, "--json", tmp_path / "j")
    report = strict(tmp_path / "j")
    assert code == 0 and ", converged, " in out and "pulled off at U_x = " in out and "Not conv" not in err
    assert report["outcome"] == "pulled off" and report["converged"] is True and report["failure"] is None


def test_a_failure_of_the_solver_names_the_load_and_a_remedy(call, monkeypatch):
    hasty = dict(METHODS) | {"gfmd": partial(Gfmd, budget=100)}
    monkeypatch.setattr("solver.run.loadpath.METHODS", hasty)
    code, _, err = call("run", "--method", "gfmd", "--set", *SMALL)
    assert (code, err.count("\n")) == (1, 1)
    assert re.search("(delta|U_x) = .* nm: residual .* try ", err)


@pytest.mark.parametrize("count", [0, 50])
def test_no_convergence_in_the_approach_still_writes_files(call, tmp_path, cut_short, count):
    cut_short(NotConverged("Not converged at delta = -5"), count)
    code, *_ = call("run", "--set", *SMALL, "--csv", tmp_path / "c", "--npz", tmp_path / "n", "--json", tmp_path / "j")
    assert code == 1
    assert (tmp_path / "c").read_text().startswith(HEADER + "\n") and len(rows(tmp_path / "c")) == count
    assert strict(tmp_path / "j")["converged"] is False
    with np.load(tmp_path / "n") as data:
        assert len(data["U_x"]) == 0


def test_a_held_load_that_is_not_found_in_time_still_writes_files(call, tmp_path):
    files = [f"--{kind}={tmp_path / kind}" for kind in ("csv", "npz", "json")]
    code, _, err = call("run", "--set", *SMALL, "--load", "10", "--limit", "0", *files)
    report = strict(tmp_path / "json")
    assert code == 1 and err.count("wrote ") == 3 and err.splitlines()[-1] == report["failure"]
    assert report["outcome"] == "out of time" and report["events"] == []


def test_an_interrupt_keeps_the_frames_computed_and_is_named_as_the_outcome(call, tmp_path, cut_short):
    cut_short(KeyboardInterrupt(), 101 + 5)
    code, _, err = call("run", "--set", *SMALL, "--csv", tmp_path / "c", "--json", tmp_path / "j")
    assert code == 130
    report = strict(tmp_path / "j")
    assert report["outcome"] == "interrupted" and report["converged"] is False and "Interrupted" in report["failure"]
    assert "shear increment 4" in err
    assert len(sheared(tmp_path / "c")) == 5


def test_a_residual_above_tolerance_is_never_reported_as_converged(call, tmp_path, monkeypatch):
    def sloppy(scene, method, limit=0.0):
        for frame in load_path(scene, method=method):
            if frame.stage == "shear" and frame.index == 3:
                frame = replace(frame, residual=2e-5)
            yield frame

    monkeypatch.setattr(run, "load_path", sloppy)
    code, out, _ = call("run", "--set", *SMALL, "--json", tmp_path / "j")
    assert code == 1 and "NOT converged" in out
    assert strict(tmp_path / "j")["converged"] is False


def test_progress_is_drawn_on_a_terminal_only(call, monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    for stream, drawn in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        assert call("run", "--set", *SMALL)[0] == 0
        assert (" increments" in stream.getvalue()) is drawn
        assert "increments" not in stream.getvalue().split("\r")[-1]  # it is wiped


def test_parameters_lists_every_parameter_with_its_range_in_100_columns(call):
    code, out, _ = call("parameters")
    assert code == 0 and max(map(len, out.splitlines())) <= 100
    for name, parameter in PARAMETERS.items():
        assert re.search(rf"^{name} +{re.escape(parameter.span)}, default ", out, re.M), name
    assert all(f" {word}: " in out for words in CHOICES.values() for word in words)


@pytest.mark.parametrize("name", sorted(SUBCOMMANDS))
def test_the_help_of_a_command_fits_100_columns_and_a_screen(call, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "100")
    code, out, _ = call(name, "--help")
    assert code == 0 and max(map(len, out.splitlines())) <= 100 and len(out.splitlines()) <= 45


@pytest.mark.parametrize(
    ("setting", "meant"),
    [("e=70", "E"), ("delta_baar=1", "delta_bar"), ("surfce=flat", "surface"), ("u_max=3", "u_x_max")],
)
def test_an_unknown_parameter_is_answered_with_the_most_similar_one(call, setting, meant):
    code, _, err = call("run", "--set", setting)
    assert code == 2 and err.endswith(f"; did you mean {meant}?\n")


@pytest.mark.parametrize(
    "arguments",
    [
        ("run",),
        ("sweep", "--over", "E=60,70"),
        ("accuracy",),
    ],
)
def test_every_command_that_computes_a_scene_knows_the_presets(call, arguments):
    code, _, err = call(*arguments, "--preset", "fig9")
    assert code == 2 and err.startswith("preset = 'fig9': allowed: fig6, ")


def test_sweep_prints_and_writes_the_first_slip_of_every_combination(call, tmp_path):
    over = ("--over", "phi_ratio=0.5,1", "E=0.05 TPa,70")
    code, out, _ = call("sweep", *over, "--set", *SMALL[:2], "u_x_max=8", "--csv", tmp_path / "sweep.csv")
    written = rows(tmp_path / "sweep.csv")
    scene = Scene(nodes=64, width=160.0, u_x_max=8.0)
    table = sweep(scene, phi_ratio=[0.5, 1.0], E=[50.0, 70.0])
    assert code == 0 and len(out.splitlines()) == 5 and len(written) == 4
    assert list(written[0]) == list(table.columns)
    assert [float(row["U_s (nm)"]) for row in written] == table["U_s (nm)"].tolist()


def test_a_combination_of_a_sweep_that_pulls_off_is_a_result(call):
    small = "nodes=64", "width=160", "radius=0.2", "du_z=0.5", "du_x=0.5", "u_x_max=10", "phi_ratio=0.5", "hold=load"
    code, out, _ = call("sweep", "--set", *small, "--over", "delta_bar=-0.2,0")
    assert code == 0 and "pulled off" in out


@pytest.mark.parametrize(
    ("over", "words"),
    [
        ("phi_rati=1", "did you mean phi_ratio?"),
        ("phi_ratio", "give NAME=VALUE,VALUE,..."),
        ("E=1,x", "E = 'x'"),
    ],
)
def test_sweep_names_a_wrong_parameter_or_value_in_one_line(call, over, words):
    code, _, err = call("sweep", "--over", over)
    assert code == 2 and err.count("\n") == 1 and words in err


def test_a_sweep_of_points_and_of_whole_numbers_prints_them_as_given(call):
    points = "0,-1; 0,0.2; 1,0.2"
    small = "nodes=64", "width=160", "path=points", "du_z=0.5", "du_x=0.5"
    code, out, _ = call("sweep", "--set", *small, "--over", f"points={points}", "nodes=64,128")
    assert code == 0 and out.count(points) == 2 and re.search(r" 64 .*\n.* 128 ", out)


@pytest.mark.parametrize("option", ["--set E=50 E=70", "--set E=50 --set E=70", "--over E=50 --over E=70"])
def test_a_parameter_that_is_given_twice_is_refused(call, option):
    code, _, err = call(*("sweep --over nu=0.4 --set" if "--set" in option else "sweep").split()[:3], *option.split())
    assert code == 2 and "E=70: E = 50 is given as well; leave one of them out" in err


@pytest.mark.parametrize("given", ["--csv o --json o", "--npz o --json ./o", "--measured o --csv o"])
def test_a_file_that_is_named_twice_is_refused(call, tmp_path, monkeypatch, given):
    monkeypatch.chdir(tmp_path)
    code, _, err = call("run", *given.split())
    assert code == 2 and re.search(r"--\w+ (\./)?o: the file of --\w+; name another one", err)


def test_a_closed_output_pipe_leaves_no_traceback():
    """`parameters | head -n 0`: the pipe is closed before anything is written to it."""
    command = [sys.executable, "-m", "solver", "parameters"]
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "wb") as closed:
        process = subprocess.run(command, cwd=ROOT, stdout=closed, stderr=subprocess.PIPE, text=True, timeout=120)
    assert (process.stderr, process.returncode) == ("", CLOSED_PIPE)


def test_compiling_is_reported_once_and_only_where_something_is_compiled(capsys):
    @numba.njit
    def double(x):
        return x + x

    with install_listener("numba:compile", CompilingNotice()):
        double(1)
        first = capsys.readouterr()
        double(1)  # compiled already
        double(1.0)  # another type: compiled again
    assert (first.out, first.err.count("\n")) == ("", 1) and "Compiling" in first.err
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("called", ["python -m solver", "mixed-mode-contact"])
def test_help_and_errors_use_the_name_by_which_the_command_was_called(call, monkeypatch, called):
    monkeypatch.setattr(
        sys, "argv", ["bin/mixed-mode-contact" if called == "mixed-mode-contact" else "solver/__main__.py"]
    )
    _, out, _ = call("--help")
    assert out.startswith(f"usage: {called} ")
    assert len(SUBCOMMANDS) > 5 and all(f"    {name}" in out for name in SUBCOMMANDS)
    code, _, err = call("walk")
    assert code == 2 and err.startswith(f"{called}: ") and f"see {called} --help" in err
    _, out, _ = call("run", "--help")
    assert f"`{called} parameters` and `{called} presets`" in " ".join(out.split())


def test_the_console_script_is_the_command_line(monkeypatch, capsys):
    name, place = next(iter(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"].items()))
    module, function = place.split(":")
    monkeypatch.setattr(sys, "argv", [name, "presets"])
    assert getattr(import_module(module), function)() == 0
    assert "fig6" in capsys.readouterr().out


def test_ci_runs_exactly_the_test_command_of_the_readme():
    shown = subprocess.run([ROOT / ".ci" / "run", "--print"], capture_output=True, text=True, timeout=60, check=True)
    environment = "python3 -m venv .venv && . .venv/bin/activate"
    assert shown.stdout == f'{environment} && pip install -e ".[test]" && pytest\n'
    assert f"- test: `{shown.stdout.strip()}`\n" in (ROOT / "README.md").read_text(encoding="utf-8")
