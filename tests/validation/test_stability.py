"""The stability atlas: its checks can fail, and a sample of its scenes passes."""

import ast
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import stability
import verdicts
from atlas import AXES, Case, cases, scene_fields
from helpers import outcomes_beside_a_hang, peculiar, until
from recheck import recheck
from spectrum import friction, growth

from app.service.caller import Lost
from solver import NotConverged, Scene, SceneError, load_path
from solver.mechanics.cohesive_law import traction

SMALL = Scene(nodes=64, width=160.0, radius=0.2, du_z=0.5, du_x=0.5, u_x_max=8.0)


@pytest.fixture(scope="module")
def frame():
    *_, last = load_path(SMALL)
    return last


@pytest.mark.slow
def test_the_atlas_has_2000_scenes_and_is_the_same_each_time():
    full, quick = cases(), cases(quick=True)
    assert len(full) >= 2000 and 180 <= len(quick) <= 260
    assert [case.values for case in cases()] == [case.values for case in full]
    assert {case.probed for case in full} >= {(name,) for name in AXES}
    assert {name for case in quick for name in case.probed} >= set(AXES)
    assert all(len(values) >= 4 for values in AXES.values())


def test_a_line_of_the_atlas_reproduces_its_scene():
    from solver import scene_from_text

    for case in cases(quick=True):
        pairs = dict(pair.split("=") for pair in case.line.split()[1:])
        try:
            scene = case.scene()
        except SceneError:
            continue
        assert scene_from_text(pairs) == scene


# Parameters outside their range, or impossible together
REFUSED_ALONE = {
    "nu": (0.5, 0.49999, -0.1),
    "E": (0.0, 1e7, float("nan"), float("inf")),
    "phi_ratio": (-1.0, 101.0),
    "delta_bar": (101.0, -1.5),
    "height": (0.0,),
    "radius": (0.0, float("inf")),
    "nodes": (3, 32768, 12.5),
    "spacing": (0.01, 50.0),
    "normal": (1e-3,),
    "step": (0.0, 100.0),
    "tolerance": (0.0, 1e-15),
    "surface": ("bumpy", "measured"),
}
REFUSED = (
    *({name: value} for name, values in REFUSED_ALONE.items() for value in values),
    {"du_x": 1e-3, "u_x_max": 1e4},
    {"surface": "wave", "amplitude": 1e3},
    {"surface": "wave", "waves": 100},
    {"surface": "rough", "cut_off": 1e-3},
    {"surface": "rough", "rms_slope": 1.0},
)


@pytest.mark.parametrize("point", REFUSED, ids=str)
def test_values_out_of_range_are_rejected(point):
    with pytest.raises(SceneError):
        Scene(**scene_fields(**point))


@pytest.mark.parametrize("name", ["extended", "recheck", "spectrum"])
def test_references_import_only_the_data_of_a_run_from_the_solver(name):
    tree = ast.parse((Path(__file__).parent / f"{name}.py").read_text(encoding="utf-8"))
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert {module for module in modules if module.startswith("solver")} == {"solver.scene", "solver.run.frame"}


def test_the_recheck_agrees_with_a_good_frame(frame):
    second = recheck(SMALL, frame)
    assert second.residual == pytest.approx(frame.residual, abs=second.floor)
    assert second.floor < 0.01 * SMALL.tolerance
    assert second.traction < 1e-13 and second.forces < 1e-13


def test_recheck_detects_wrong_displacements_tractions_and_forces(frame):
    """A nudged node, a scaled traction, a wrong force, a node left out: each must show."""
    u = frame.u.copy()
    u[0, u.shape[1] // 2] += 1e-6
    assert recheck(SMALL, replace(frame, u=u)).residual > 5e-7
    assert recheck(SMALL, replace(frame, T=frame.T * 1.001)).traction > 1e-5
    assert recheck(SMALL, replace(frame, F_bar=frame.F_bar * 1.01)).forces > 1e-5
    middle = frame.u.shape[1] // 2
    half = replace(frame, first=frame.first + middle, u=frame.u[:, middle:], T=frame.T[:, middle:])
    seen = recheck(SMALL, half)
    assert seen.residual > 1e-3


def test_a_saddle_is_unstable(frame):
    """Flat on flat, every node halfway between two sites: T = 0, an equilibrium at U_x = a/2, and unstable."""
    assert growth(SMALL, frame) < 0.0
    scene = Scene(surface="flat", nodes=16, width=40.0, height=20.0)
    u = np.array([np.full(16, 0.5 * scene.spacing), np.zeros(16)])
    top = replace(frame, first=0, u=u, T=np.ones((2, 16)), U_x=0.5 * scene.spacing, delta=0.0)
    # the uniform mode: lambda^2 + gamma lambda = dT/du - G/h
    h = 1e-4
    rise = (traction(scene, u[0, 0] + h, 0.0)[0] - traction(scene, u[0, 0] - h, 0.0)[0]) / (2 * h)
    mu, half = rise - scene.shear_modulus / (scene.height * scene.width), 0.5 * friction(scene)
    expected = np.sqrt(half**2 + mu) - half
    assert expected > 0.5
    assert growth(scene, top) == pytest.approx(expected, rel=1e-6)


def test_a_site_at_the_edge_of_the_window_passes_the_recheck():
    """At U_x = 15 a = 10 the next sites are just 5 delta_t away: exp(-25) of a spring, for either side or for none."""
    values = {"E": 541.8, "phi_ratio": 0.0, "delta_bar": -1.0, "nu": 0.4999, "height": 100.0, "radius": 0.1}
    grid = {"nodes": 8, "width": 80.0, "du_z": 1.0, "du_x": 1.0, "u_x_max": 20.0}
    assert verdicts.assess(Case(0, ("nodes",), values | grid))["verdict"] == "converged"


def assessed(monkeypatch, frames):
    """The verdict on a run that yields these frames, or raises them."""

    def run(scene, limit):
        for item in frames:
            if isinstance(item, Exception):
                raise item
            yield item, None

    monkeypatch.setattr(verdicts, "until", run)
    values = {name: getattr(SMALL, name) for name in ("nodes", "width", "radius", "du_z", "du_x", "u_x_max")}
    return verdicts.assess(Case(0, ("nodes",), values))


@pytest.mark.slow
def test_every_verdict_of_the_atlas_can_occur(monkeypatch, frame):
    u = frame.u.copy()
    u[1, 3] = np.nan
    shifted = replace(frame, u=frame.u + 1e-5)
    assert assessed(monkeypatch, [frame])["verdict"] == "converged"
    assert assessed(monkeypatch, [frame, NotConverged("try")])["verdict"] == "gave up"
    assert assessed(monkeypatch, [replace(frame, u=u)])["verdict"] == "non-finite"
    assert assessed(monkeypatch, [replace(frame, residual=1e-3)])["verdict"] == "wrong"
    assert assessed(monkeypatch, [shifted])["verdict"] == "wrong"
    assert assessed(monkeypatch, [frame, ZeroDivisionError("x")])["verdict"] == "error"
    assert assessed(monkeypatch, [frame, RuntimeWarning("overflow")])["verdict"] == "warning"
    assert verdicts.assess(Case(0, ("nu",), {"nu": 0.5}))["verdict"] == "refused"


@pytest.mark.thorough
@pytest.mark.slow
def test_a_crashing_or_hanging_call_costs_only_its_process():
    items = ["a", "die", "raise", "b", "hang", "c"]
    found = outcomes_beside_a_hang(peculiar, items, 2, hanging=items.index("hang"))
    assert [found[k] for k in (0, 3, 5)] == ["a", "b", "c"]
    assert [found[k].kind for k in (1, 2, 4)] == ["crash", "error", "hang"]
    assert all(isinstance(found[k], Lost) for k in (1, 2, 4))


KILLED = """
import sys, time
from helpers import outcomes, peculiar
for k, pid in outcomes(peculiar, ["pid", "hang"], 1, limit=300.0):
    print(pid, flush=True)
"""


@pytest.mark.thorough
@pytest.mark.slow
def test_processes_end_with_a_parent_that_is_killed():
    """The worker is busy for ten minutes when its parent dies; it is gone long before (`until` ends after five)."""
    here = os.path.join(os.path.dirname(__file__), "..", "shared")
    program = f"import sys; sys.path.insert(0, {here!r})\nif __name__ == '__main__':\n" + "".join(
        f"    {line}\n" for line in KILLED.strip().splitlines()
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as parent:
        worker = int(parent.stdout.readline())
        parent.kill()
    until(lambda: not alive(worker))


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    with open(f"/proc/{pid}/stat") as stat:
        return stat.read().split()[2] != "Z"


def sample():
    """Numbers of 40 scenes of the quick atlas, spread evenly, of at most 100 nodes: all of them take seconds."""
    small = [case.number for case in cases(quick=True) if case.values["nodes"] <= 100 and case.values["E"] > 0.5]
    return [small[k] for k in np.linspace(0, len(small) - 1, 40).round().astype(int)]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_sample_of_the_atlas_finds_nothing_wrong():
    chosen = sample()
    results = verdicts.atlas([case for case in cases(quick=True) if case.number in chosen], limit=900.0)
    assert [(r["set"], r["verdict"], r["reason"]) for r in results if r["verdict"] in verdicts.BAD] == []
    counts = stability.counted(results)
    assert counts["converged"] >= 0.9 * (len(results) - counts["refused"])
    assert counts["unstable"] == 0 and counts["spectra"] >= 100
    probed = stability.regions(results)
    assert sum(probed[name]["spectra"] > 0 for name in probed if name != "all") >= len(AXES)


@pytest.mark.slow
def test_the_script_prints_its_verdict_with_scenes_and_round_off(capsys):
    assert stability.main(["--quick", "--scenes", "0", "--jobs", "1"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("Verdict: nothing wrong. 1 scenes; 100.00% of the valid ones converged")
    assert "Scenes by extreme parameter" in shown and "Conditioning" in shown


def test_an_unstable_frame_is_counted_by_region_and_fails_the_report(frame):
    """The flat of `test_a_saddle_is_unstable`, passed off as a frame of a run."""
    scene = Scene(surface="flat", nodes=16, width=40.0, height=20.0)
    u = np.array([np.full(16, 0.5 * scene.spacing), np.zeros(16)])
    saddle = replace(frame, first=0, u=u, T=np.ones((2, 16)), U_x=0.5 * scene.spacing, delta=0.0, slips=())
    wrong, numbers = verdicts.stable(scene, [saddle])
    assert "unstable, disturbances grow" in wrong.reason
    results = [{"probed": ["nodes"], "set": "--set nodes=16"} | wrong._asdict() | numbers]
    counts = stability.regions(results)["nodes"]
    assert [counts[name] for name in ("unstable", "cautioned", "spectra")] == [1, 0, 1]
    assert stability.failed(results, [], []) and stability.report(results, [], []).startswith("Verdict: WRONG")
    vars(saddle)["safe_damping"] = 2.0 * scene.damping  # a frame that reports possible flutter itself
    wrong, numbers = verdicts.stable(scene, [saddle])
    assert wrong is None and (numbers["unstable"], numbers["cautioned"]) == (0, 1)


@pytest.mark.parametrize(
    ("values", "limit", "cause"),
    [
        ({"E": 0.02, "tolerance": 1e-5}, 1e-3, "the layer is too soft to begin"),
        ({}, 1e-3, "out of time"),
    ],
)
def test_a_scene_that_gives_up_is_named_by_its_cause(values, limit, cause):
    """Messages of runs, so that other words in them are noticed."""
    scene = SMALL.changed(**values)
    with pytest.raises(NotConverged) as failure:
        list(load_path(scene, limit=limit))
    gave_up = {"verdict": "gave up", "reason": str(failure.value), "number": 7, "set": "--set nodes=64", "probed": []}
    assert stability.causes([gave_up]) == [{"cause": cause, "scenes": 1, "numbers": [7]}]
    assert cause in stability.report([gave_up], [], [])


def test_a_number_outside_the_atlas_is_rejected(capsys):
    with pytest.raises(SystemExit) as ended:
        stability.main(["--quick", "--scenes", "100000"])
    assert ended.value.code == 2 and "--scenes 100000: allowed: 0 .. " in capsys.readouterr().err
