"""Benches run on their smallest input and print their figure."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SMALLEST = {  # bench: (arguments, what it prints)
    "bench": (["--quick", "--scenes", "1"], "cost per increment grows as"),
    "boundary": (["--scenes", "1"], "no slip below and a slip above: 1 of 1"),
    "box": (["--every", "120"], "box over default"),
    "certify": (["--moves", "0", "--box", "1", "--rough", "0", "--wrong", "1"], "another E: refused 6 of 6"),
    "constants": (["--only", "MOVED", "--scenes", "1"], "differ x2 0"),
    "curves": (["--quick", "--set", "nodes=64", "width=160", "radius=1", "du_z=0.5", "du_x=0.2", "u_x_max=8"], "FIRE"),
    "figures": (["--processes", "1", "--repetitions", "1"], "Fig. 5, 120 moduli"),
    "damping": ([], "36 states"),
    "fit": (["--draws", "1", "--starts", "1", "--box", "1", "--sparse", "1", "--points", "100"], "reach the truth"),
    "follow": (["--scenes", "1"], "F, L and A all right"),
    "jumps": (["--scenes", "1"], "1 scenes"),
    "lab": (["--visits", "1", "--only", "accuracy"], "server"),
    "landings": (["--scenes", "1"], "1 scenes, 1 slips judged"),
    "map": (["--points", "2", "2", "--workers", "1", "--checks", "1"], "U_s off by"),
    "onset": (["--scenes", "1"], "1 scenes at du_x"),
    "others": (["--kinds", "nu 0.49", "--every", "15", "--length", "1"], f"{'nu 0.49':14}{1:8}"),
    "pair": ([".", "--only", "tiny", "--repeats", "1"], "    1.00\n"),  # a checkout takes as many evaluations as itself
    "rests": (["--scenes", "2", "--jobs", "1"], "slips located"),
    "sensitivities": (["--scenes", "1"], "derivatives"),
    "skeletons": (["--scenes", "1"], "error of F_s"),
    "slider_step": ([], "returns to a file already left"),
    "start": (["--repeats", "1"], ", 0 compiled\n"),  # whatever was compiled is kept
    "unstable": (["--scenes", "0"], "4 lead to the next branch, 0 of them elsewhere"),
    "visit": (["--visits", "1"], "largest contentful paint"),
}


@pytest.mark.slow
@pytest.mark.thorough
def test_extreme_scenes_end():
    """A layer of 0.7 GPa, and one of 4.4 GPa with phi_n = 14.6 N/m; `box.py --extreme` runs all 30."""
    command = [sys.executable, HERE / "box.py", "--extreme", "--every", "29", "--limit", "1200"]
    ended = subprocess.run(command, cwd=HERE.parents[1], capture_output=True, text=True)
    assert "not done: 0 of 2" in ended.stdout


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize("name", SMALLEST)
def test_a_bench_prints_its_figure(name):
    arguments, figure = SMALLEST[name]
    command = [sys.executable, HERE / f"{name}.py", *arguments]
    ended = subprocess.run(command, cwd=HERE.parents[1], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert figure in ended.stdout
