"""What is installed: pinned versions, hashes of the image, and a workflow without foreign actions."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def name_of(requirement):
    return re.match(r"[\w.-]+", requirement)[0].lower().replace("-", "_")


def pinned(name):
    """Return {package: version} of a file of pinned versions."""
    lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
    pairs = [line.split(" ")[0].split("==") for line in lines if not line.startswith("#")]
    return {name_of(package): version for package, version in pairs}


def test_the_image_installs_every_dependency_in_the_pinned_version_with_a_hash():
    image, constraints = pinned("image.txt"), pinned("constraints.txt")
    assert {name_of(each) for each in PROJECT["dependencies"]} <= image.keys()
    assert {name: constraints.get(name) for name in image} == image  # else run .ci/image
    lines = (ROOT / "image.txt").read_text(encoding="utf-8").splitlines()[1:]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+( --hash=sha256:[0-9a-f]{64})+", line) for line in lines)


@pytest.mark.parametrize(("name", "line"), [("constraints.txt", "3.9"), ("constraints-3.12.txt", "3.10")])
def test_both_lines_of_bokeh_have_tried_versions_of_every_dependency(name, line):
    tried = pinned(name)
    assert {name_of(each) for each in PROJECT["dependencies"]} <= tried.keys()
    assert tried["bokeh"].startswith(line)


def test_the_lowest_versions_are_those_that_the_project_allows():
    command = [sys.executable, ROOT / ".ci" / "lowest"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert len(printed) == len(PROJECT["dependencies"])
    assert all(
        requirement.startswith(line.replace("==", ">="))
        for line, requirement in zip(printed, PROJECT["dependencies"], strict=True)
    )


def test_the_workflow_uses_no_action_and_has_no_permissions():
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert "uses:" not in text and "\npermissions: {}\n" in text
