"""The sdist holds what its tests and docs need."""

import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_sdist_holds_what_its_tests_and_docs_need(tmp_path):
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    build = [sys.executable, "-m", "build", "--sdist", "--outdir", tmp_path, "."]
    subprocess.run(build, cwd=ROOT, capture_output=True, timeout=300, check=True)
    (sdist,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    needed = {name for name in tracked if name.startswith(("tests/", "docs/", "solver/", "app/"))}
    needed |= {"constraints.txt", "constraints-3.12.txt", "CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff"}
    needed |= {"SECURITY.md", "pyproject.toml"}
    assert not needed - held
    assert not [name for name in held if name.endswith((".pyc", ".nbc", ".nbi"))]
