"""README and docs: short enough to read, every link leads somewhere, every block of code and every command runs.

The tutorials are executed by `python docs/build.py`, which `.ci/run` calls.
"""

import ast
import importlib.util
import inspect
import json
import re
import shlex
import subprocess
import sys
import threading
import tomllib
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from importlib.metadata import packages_distributions
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import solver
from solver.cli import parser
from solver.presets import presets

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = [page for page in PAGES if "_build" not in page.parts]
OPTIONAL = {"distributed", "SurfaceTopography", "afmformats", "xarray"}  # extras, and what `Result.to_xarray` needs
CODE = re.compile(r"^```(?P<kind>\S*)[^\n]*\n(?P<text>.*?)^```", re.M | re.S)


def names(page):
    return str(page.relative_to(ROOT))


def test_the_readme_is_one_page():
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120 and len(text.encode()) <= 8192
    prose = re.sub(r"\$\$.*?\$\$|\(https?:[^)]*\)|\([\w/.]+\)", "", CODE.sub("", text), flags=re.S)
    paragraphs = [" ".join(block.split()) for block in re.split(r"\n\s*\n|\n- |\n\|", prose)]
    longest = max(
        (sentence for block in paragraphs for sentence in re.split(r"[.?:;] ", block)), key=lambda s: len(s.split())
    )
    assert len(longest.split()) <= 30, longest


@pytest.mark.parametrize("page", PAGES, ids=names)
def test_every_link_inside_the_repository_leads_to_a_file(page):
    text = CODE.sub("", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        if not target.startswith("http"):
            assert (page.parent / target).is_file(), target


def test_what_the_readme_cites_was_measured_since_the_last_change_of_the_numerics():
    """`python docs/evidence.py NAME` measures it anew; solver.continuation.NUMERICS says when that is due."""
    cited = re.findall(r"docs/evidence\.md#([\w-]+)", README.read_text(encoding="utf-8"))
    code = "import sys; sys.path.insert(0, 'docs'); import json, evidence; from evidence import *"
    code += "; print(json.dumps({e.title.lower().replace(' ', '-'): stale(n, json.loads(STORE.read_text()))"
    code += " for n, e in COMMANDS.items()}))"
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300, check=True
    )
    old = json.loads(ran.stdout)
    assert cited and not [title for title in cited if old[title]]


@pytest.fixture(scope="module")
def evidence():
    """The module docs/evidence.py."""
    spec = importlib.util.spec_from_file_location("evidence", ROOT / "docs" / "evidence.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def result(evidence, name, commit):
    entry = evidence.COMMANDS[name]
    return {"command": evidence.line(entry), "commit": commit, "processor": "some processor", "date": "2026-11-29"} | {
        "output": f"figures of {name}", "numerics": evidence.NUMERICS,
    }  # fmt: skip


def test_a_stopped_measurement_of_all_entries_goes_on_where_it_was(evidence):
    names = [*evidence.COMMANDS]
    store = {name: result(evidence, name, "new") for name in names[:3]}
    store |= {name: result(evidence, name, "old") for name in names[3:]}
    assert evidence.left(store, "new") == names[3:]
    store[names[0]]["command"] += " --another"
    assert evidence.left(store, "new") == [names[0], *names[3:]]
    assert evidence.left({}, "new") == names


def test_entries_that_measure_time_run_alone_and_all_others_two_at_a_time(evidence, monkeypatch):
    running, beside = set(), {}
    both = threading.Barrier(2)

    def kept(name, store):
        running.add(name)
        if name in ("sensitivities", "held"):
            both.wait(60.0)  # for the other one: it would break in one stream
        beside[name] = set(running)
        running.remove(name)
        return name != "held"

    monkeypatch.setattr(evidence, "kept", kept)
    names = ["curves", "sensitivities", "held", "rests", "follow", "drag"]
    ended = evidence.measure(names, {})
    assert ended == {name: name != "held" for name in names}
    assert all(beside[name] == {name} for name in ("curves", "rests", "follow", "drag"))


def test_the_page_of_evidence_names_the_commit_once_and_again_only_where_another_was_measured(evidence):
    store = {name: result(evidence, name, "abc1234") for name in evidence.COMMANDS}
    text = evidence.page(store)
    assert text.count("abc1234") == 1 and all(f"figures of {name}\n" in text for name in store)
    store["box"] = result(evidence, "box", "def5678")
    text = evidence.page(store)
    assert (text.count("abc1234"), text.count("def5678")) == (1, 1)
    assert text.index("def5678") > text.index("### The slider box")


@pytest.mark.slow
def test_the_python_of_the_readme_prints_what_the_readme_shows(tmp_path, monkeypatch, capsys):
    """On a terminal of 80 columns; numbers to 1e-4, as the last digits differ between processors."""
    monkeypatch.chdir(tmp_path)
    blocks = list(CODE.finditer(README.read_text(encoding="utf-8")))
    (code,), (shown,) = ([b["text"] for b in blocks if b["kind"] == kind] for kind in ("python", "text"))
    with pd.option_context("display.width", 80, "display.max_columns", 0):
        exec(code, {})
    assert (tmp_path / "run.html").is_file() and (tmp_path / "curve.csv").is_file()
    printed, written = (text.split() for text in (capsys.readouterr().out, shown))
    assert max(map(len, shown.splitlines())) <= 80
    assert len(printed) == len(written)
    for ours, theirs in zip(printed, written, strict=True):
        with suppress(ValueError):
            ours, theirs = float(ours), pytest.approx(float(theirs), rel=1e-4)
        assert ours == theirs


FUNCTIONS = [name for name in solver.__all__ if inspect.isroutine(getattr(solver, name))]
CLASSES = [name for name in solver.__all__ if inspect.isclass(getattr(solver, name))]
CLASSES = [name for name in CLASSES if not issubclass(getattr(solver, name), Exception)]
# They raise no error of their own.
SAFE = {"summarize", "whole_surface", "work_of"}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_docstrings_of_exported_functions_name_parameters_result_and_errors(name):
    text = inspect.getdoc(getattr(solver, name))
    assert "\nParameters: " in text and re.search(r"\nReturns ", text)
    assert (" Raises " in text.replace("\n", " ")) != (name in SAFE)


@pytest.mark.slow
def test_examples_in_docstrings_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("profile.csv").write_text("x (nm),z (nm)\n" + "\n".join(f"{x},{np.sin(x / 10):.6f}" for x in range(300)))
    size = {"nodes": 128, "width": 312.5}  # the default, an eighth as wide
    table = solver.simulate(solver.Scene(**size, u_x_max=12.0, du_x=0.25, du_z=0.5)).table
    table[table["stage"] == "shear"][["U_x (nm)", "F (N/m)"]].to_csv("measured.csv", index=False)
    small = partial(solver.Scene, u_x_max=12.0, **size)
    names = {name: getattr(solver, name) for name in solver.__all__} | {"np": np, "Path": Path, "Scene": small}
    names["Axis"] = lambda name, low, high, count: solver.Axis(name, low, high, 2)
    names["explore_map"] = partial(solver.explore_map, executor=ThreadPoolExecutor(1))
    for name in FUNCTIONS + CLASSES:
        text = inspect.getdoc(getattr(solver, name))
        (example,) = re.findall(r"\nExample: (.*?)(?:\n\n|\Z)", text, re.S)
        for code in re.findall(r"`([^`]+)`", example):
            exec(code, names)


def imported(tree):
    """Top-level packages that a module imports, but for relative imports."""
    nodes = list(ast.walk(tree))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.level == 0]
    return {name.partition(".")[0] for name in names}


def test_every_imported_package_is_declared():
    lines = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    declared = {re.match(r"[\w.-]+", line)[0].lower().replace("_", "-") for line in lines}
    found = packages_distributions()
    for path in [*ROOT.glob("solver/**/*.py"), *ROOT.glob("app/**/*.py")]:
        names = imported(ast.parse(path.read_text(encoding="utf-8")))
        for name in names - sys.stdlib_module_names - {"solver", "app"} - OPTIONAL:
            assert {found_in.lower().replace("_", "-") for found_in in found[name]} & declared, (path, name)


def commands(page):
    """Arguments of every `python -m solver ...` of a page, indented or quoted."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    for line in re.findall(r"(?:^    |`)python -m solver ([^`\n]+)", text, re.M):
        yield shlex.split(line.partition(" && ")[0])


@pytest.mark.parametrize("page", PAGES, ids=names)
def test_every_command_of_the_docs_is_accepted(page):
    for arguments in commands(page):
        if "--help" in arguments:
            continue
        known = parser().parse_args(arguments)
        assert getattr(known, "preset", None) in (None, *presets()), arguments


def test_every_tutorial_and_page_is_in_the_table_of_contents():
    listed = set(re.findall(r"^([\w/]+)$", (ROOT / "docs" / "index.md").read_text(encoding="utf-8"), re.M))
    pages = {str(page.relative_to(ROOT / "docs").with_suffix("")) for page in PAGES[1:]} - {"index"}
    assert listed == pages


def test_presets_that_the_docs_name_exist():
    named = {name for page in PAGES for name in re.findall(r"preset=([\w-]+)", page.read_text(encoding="utf-8"))}
    assert named and named <= set(presets())


def collected(*arguments):
    """The tests of a file that pytest would run."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "--collect-only",
        "-q",
        "-n",
        "0",
        "tests/solver/test_slip.py",
        *arguments,
    ]
    shown = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=True).stdout
    return {line for line in shown.splitlines() if "::" in line}


@pytest.mark.thorough
def test_a_named_file_runs_all_its_tests_and_a_choice_leaves_thorough_ones_out():
    thorough = collected("-m", "thorough")
    assert thorough and thorough <= collected()
    assert not thorough & collected("-m", "not slow")


def test_every_function_on_the_way_of_a_slider_step_exists():
    text = (ROOT / "docs" / "slider_step.md").read_text(encoding="utf-8")
    sources = [path for folder in ("app", "solver") for path in (ROOT / folder).rglob("*.*")]
    code = "\n".join(path.read_text(encoding="utf-8") for path in sources if path.suffix in (".py", ".js"))
    for quoted in re.findall(r"`([^`]+)`", text):
        if "/" in quoted or quoted.endswith((".py", ".js")):
            where = quoted.split(" ")[0]
            assert (ROOT / where).exists() or list((ROOT / "app").rglob(where)), quoted
        else:
            name = quoted.split(".")[-1]
            assert re.search(rf"\b(?:def|function|class|const) {name}\b|\b{name}[:=(]", code), quoted
