"""The core needs no feature, and a feature only those that its docstring names: their tests pass without the others."""

import os
import subprocess
import sys

import pytest
from copied import NAMES, ROOT, copy_with, needed

FAST = "not slow and not browser and not thorough"
NONE_CHOSEN = 5  # the exit code of pytest where a folder has no such tests


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["", *NAMES])
def test_fast_tests_pass_in_a_copy_without_the_other_features(name):
    tests = f"tests/features/{name}" if name else "tests/app"
    if not (ROOT / tests).exists():
        pytest.skip("it has no tests")
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", FAST, tests]
    with copy_with(needed(name) if name else ()) as folder:
        environment = os.environ | {"PYTHONPATH": str(folder)}
        ran = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode in (0, NONE_CHOSEN), ran.stdout[-5000:]
