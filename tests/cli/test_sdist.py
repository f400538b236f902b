"""The sdist holds what its tests, docs and Dockerfile need."""

import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
REPOSITORY = ".gitignore", ".pre-commit-config.yaml"  # of no use outside of it


@pytest.mark.slow
def test_the_sdist_holds_what_its_tests_docs_and_dockerfile_need(tmp_path):
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    for name in tracked:  # a copy, as an earlier build leaves a list beside the sources that the next one adds to
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    build = [sys.executable, "-m", "build", "--sdist", "--outdir", tmp_path, "."]
    subprocess.run(build, cwd=tmp_path, capture_output=True, timeout=300, check=True)
    (sdist,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    needed = {name for name in tracked if not name.startswith(REPOSITORY)}
    assert not needed - held
    assert not [name for name in held if name.endswith((".pyc", ".nbc", ".nbi"))]
