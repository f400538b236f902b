"""Named experiments: the app's file is valid, each of them runs, and the command line knows them."""

import importlib
import json
import re
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import solver.cli as cli
from solver import Scene, SceneError, load_path, skeleton_from, summarize
from solver.cautions import cautions
from solver.presets import WORDS, preset, presets, read
from solver.run.loadpath import Run

ROOT = Path(__file__).parents[2]
NAMES = tuple(presets())
EXPECTED = ["fig6", "fig4a-blue", "fig4a-red", "fig4a-green", "fig4b-weak", "fig4b-stiff"]
SHARED = ["fig6", "rough", "unload", "hold-load"]  # whose runs other tests here need, too
FOLLOWED = ["fig6", "rough", "hold-load", "soft-drive"]
SHEARED = [name for name in NAMES if preset(name).scene.path == "shear"]
EXPECTED += ["fig7-case1", "fig7-case2", "fig7-case3", "fig8-black", "fig8-red", "fig8-blue"]


def test_every_figure_has_its_presets():
    assert list(NAMES)[: len(EXPECTED)] == EXPECTED


@pytest.mark.parametrize("name", NAMES)
def test_preset_holds_only_what_differs_from_the_default(name):
    table = tomllib.loads((ROOT / "solver" / "presets.toml").read_text(encoding="utf-8"))[name]
    known = preset(name)
    assert known.scene.differences() == {key: value for key, value in table.items() if key not in WORDS}
    assert known.look.endswith(".") and known.look.count(". ") <= 1  # two short sentences fit beside the picture


def test_presets_differ_in_scene_and_title():
    assert (
        len({known.scene for known in presets().values()}) == len({p.title for p in presets().values()}) == len(NAMES)
    )


@cache
def run_of(name):
    """(its Frames, the Checkpoint at its end)."""
    frames, checkpoints = zip(*Run(preset(name).scene).frames(), strict=True)
    return list(frames), checkpoints[-1]


def frames_of(name):
    return run_of(name)[0]


@pytest.mark.once(len(SHARED))
@pytest.mark.slow
@pytest.mark.parametrize("name", [*SHARED, *(name for name in NAMES if name not in SHARED)])
def test_preset_runs(name):
    """To its end, and beyond the onset of sliding where there is one."""
    frames = frames_of(name)
    assert summarize(frames)["converged"]
    assert any(f.slip for f in frames if f.stage != "approach") is not name.startswith("fig4b")


@pytest.mark.once(len(FOLLOWED))
@pytest.mark.slow
@pytest.mark.parametrize("name", [*FOLLOWED, *(name for name in SHEARED if name not in FOLLOWED)])
def test_the_run_of_a_preset_that_only_shears_can_be_followed(name):
    """A slider would else show exact runs only: secant steps of a state near a fold led to the branch beyond it."""
    assert skeleton_from(preset(name).scene, run_of(name)[1]).branches


def drops(name, **changed):
    """[F_bar lost] at every slip in shear, 1e-3."""
    frames = load_path(preset(name).scene.changed(**changed)) if changed else frames_of(name)
    shear = [f for f in frames if f.stage == "shear"]
    return np.array([1e3 * (f.slips[0].F_bar - f.F_bar) for f in shear if f.slip])


@pytest.mark.thorough
@pytest.mark.slow
def test_inertia_doubles_the_drops_and_halves_their_number_as_its_preset_claims():
    with_, without = drops("inertia"), drops("inertia", damping=1.0)
    assert len(with_) == pytest.approx(len(without) / 2, abs=1)
    assert with_.mean() == pytest.approx(2.2 * without.mean(), rel=0.1)


@pytest.mark.slow
def test_patches_of_the_rough_preset_slip_one_after_another_as_it_claims():
    large = drops("rough") > 0.15
    assert np.all(large[2:] != large[1:-1])  # a small drop, a large one, and so on


@pytest.mark.slow
def test_the_rough_preset_needs_no_caution():
    scene, frames = preset("rough").scene, frames_of("rough")
    damping, sensitive = max(f.safe_damping for f in frames), any(f.sensitive for f in frames)
    assert cautions(scene, safe_damping=damping, sensitive=sensitive) == []


@pytest.mark.slow
def test_the_punch_of_the_unloading_preset_lets_go_farther_up_than_it_jumps_in():
    slips = {f.stage: f.slips[0].load for f in frames_of("unload") if f.slip}
    assert slips["unload"] < slips["approach"] - 3.0 and slips["reload"] == pytest.approx(slips["approach"], abs=1e-4)


@pytest.mark.slow
def test_a_held_load_stays_and_the_punch_of_its_preset_rises_before_the_first_slip():
    shear = [f for f in frames_of("hold-load") if f.stage == "shear"]
    first = next(k for k, f in enumerate(shear) if f.slip)
    assert np.ptp([f.L_bar for f in shear]) < 1e-9 and shear[first - 1].delta < shear[0].delta - 0.2
    assert shear[first].delta > shear[first - 1].delta


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[a]\ntitle = 'A'\ngroup = 'G'\nlook = 'B.'\nEbar = 3", ("'a'", "'Ebar'")),
        ("[a]\ntitle = 'A'\ngroup = 'G'\nlook = 'B.'\nE = -3.0", ("'a'", "E", "E = -3.0", "0.01 .. 1e+06")),
        ("[a]\ntitle = 'A'\ngroup = 'G'\nlook = 'B.'\nE = 'soft'", ("'a'", "E", "soft", "0.01 .. 1e+06")),
        ("[a]\nlook = 'B.'", ("'a'", "'title'")),
        ("a = 3", ("'a'", "table")),
        ("[a", ("presets.toml", "correct the line")),
    ],
)
def test_bad_preset_is_refused_by_name_and_key(text, named):
    with pytest.raises(SceneError) as refused:
        read(text)
    assert all(word in str(refused.value) for word in named)


def test_run_starts_from_a_preset_and_takes_overrides(capsys, tmp_path):
    """Few nodes make it quick; what is not overridden comes from the preset."""
    small = ("--set", "nodes=64", "width=160", "delta_bar=0.3", "u_x_max=1")
    assert cli.main(["run", *small, "--preset", "fig7-case3", "--json", str(tmp_path / "j")]) == 0
    scene = Scene(**json.loads((tmp_path / "j").read_text())["scene"])
    assert scene == Scene(nodes=64, width=160.0, delta_bar=0.3, phi_ratio=0.1, u_x_max=1.0)


def test_run_with_an_unknown_preset_lists_the_names_in_one_line(capsys):
    assert cli.main(["run", "--preset", "fig9"]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert all(name in err for name in ("'fig9'", *NAMES))


def test_presets_are_listed_with_their_titles(capsys):
    assert cli.main(["presets"]) == 0
    out = capsys.readouterr().out
    assert all(line.startswith(name) for name, line in zip(NAMES, out.splitlines(), strict=True))
    assert all(known.title in out for known in presets().values())


def test_functions_named_in_presets_toml_exist():
    text = (ROOT / "solver" / "presets.toml").read_text(encoding="utf-8")
    names = re.findall(r"\b(solver(?:\.\w+)*)\.(\w+)", text)
    assert len(names) >= 3
    for module, name in names:
        assert hasattr(importlib.import_module(module), name), (module, name)


@pytest.fixture
def anew():
    """Presets are read once per process: read again within the test, and again after it."""
    presets.cache_clear()
    yield
    presets.cache_clear()


@pytest.mark.usefixtures("anew")
def test_a_broken_file_of_presets_is_reported_in_one_line(monkeypatch, capsys):
    monkeypatch.setattr("solver.presets.FILE", "scene.py")
    assert cli.main(["run", "--preset", "fig6"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "scene.py" in err
