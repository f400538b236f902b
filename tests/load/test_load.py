"""Load tools run with the fewest visitors and print their figure."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SMALLEST = {  # tool and option: (arguments, what it prints)
    "load/classroom": (["--visitors", "1", "--seconds", "4"], "loop lag"),
    "load/hostile": (["--messages", "20", "--clients", "1", "--visitors", "1"], "visitors stuck             []"),
    "load/arrivals": (["--pages", "1", "--within", "1"], "errors                     []"),
    "load/random_user": (["--minutes", "0.1", "--seed", "3"], "errors                     []"),
    "load/random_user --touch": (["--minutes", "0.1", "--seed", "3"], "errors                     []"),
    "load/lesson": (["--students", "2", "--stops", "1"], "of one hostile student     [1]"),
    "bench/latency": (["--moves", "1"], "whole new curve"),
}


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize("name", SMALLEST)
def test_a_load_tool_starts_its_server_and_prints_its_figure(name):
    (tool, *option), (arguments, figure) = name.split(), SMALLEST[name]
    command = [sys.executable, ROOT / "tests" / f"{tool}.py", *option, *arguments]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert figure in ended.stdout
