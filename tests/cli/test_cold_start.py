"""A first run compiles each kernel once: each compilation takes a tenth of a second or more."""

import json
import os
import pkgutil
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import solver

ROOT = Path(__file__).parents[2]
SCRIPT = """
import json, pkgutil
from importlib import import_module
from solver import Scene, continuation, load_path, mechanics, run

for values in (
    {},
    {"nodes": 128, "width": 312.5, "radius": 10.0},  # the patch becomes the whole cell
    {"surface": "flat", "nodes": 64, "width": 156.25},
    {"hold": "load", "delta_bar": 0.3},
):
    assert [*load_path(Scene(u_x_max=9.0, **values))]
packages = continuation, mechanics, run
modules = [import_module(f"{p.__name__}.{m.name}") for p in packages for m in pkgutil.iter_modules(p.__path__)]
kernels = {k for module in modules for k in vars(module).values() if hasattr(k, "nopython_signatures")}
print(json.dumps({k.py_func.__name__: len(k.nopython_signatures) for k in kernels}))
"""


def test_kernels_are_compiled_for_one_type_whatever_the_scene():
    """In a process of its own, as other tests may call kernels with other types."""
    run = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    types = json.loads(run.stdout)
    assert types["tractions"] == 1
    assert {name: count for name, count in types.items() if count > 1} == {}


def test_no_compiled_function_uses_one_of_another_file():
    """Numba keeps machine code by the file of the caller: a change of the other file alone would leave it as it was."""
    places = pkgutil.walk_packages(solver.__path__, "solver.")
    modules = [import_module(place.name) for place in places if not place.name.endswith("__main__")]
    kernels = {k for module in modules for k in vars(module).values() if hasattr(k, "nopython_signatures")}
    assert len(kernels) > 20
    for kernel in kernels:
        function, file = kernel.py_func, kernel.py_func.__code__.co_filename
        used = [function.__globals__.get(name) for name in function.__code__.co_names]
        assert {k.py_func.__code__.co_filename for k in used if hasattr(k, "nopython_signatures")} <= {file}, function


@pytest.mark.thorough
def test_a_new_worker_counts_the_kernels_it_compiles(tmp_path):
    script = "from app.service import worker; print([*worker.start_up()], worker.KERNELS)"
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=cold)
    counts, kernels = run.stdout.rsplit(" ", 1)
    assert json.loads(counts) == [*range(1, int(kernels) + 1)]


@pytest.mark.slow
def test_runs_of_compiled_and_of_loaded_code_are_equal_to_the_last_digit(tmp_path):
    """The first process compiles what the second one loads; kernels that called shared copies rounded otherwise."""
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "code")}
    command = [sys.executable, "-m", "solver", "run", "--set", "nodes=64", "width=160", "u_x_max=8", "--csv"]
    for name in "compiled", "loaded":
        subprocess.run([*command, tmp_path / name], capture_output=True, check=True, env=cold, cwd=ROOT)
    assert (tmp_path / "compiled").read_text() == (tmp_path / "loaded").read_text()


def test_a_run_without_a_writable_folder_computes_and_prints_one_sentence(tmp_path):
    """A file stands wherever Numba would make a folder, which stops the administrator, too."""
    blocked = tmp_path / "file"
    blocked.touch()
    here = tmp_path / "installed"
    shutil.copytree(Path(solver.__file__).parent, here / "solver", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in [here / "solver", *(path for path in (here / "solver").rglob("*") if path.is_dir())]:
        (folder / "__pycache__").touch()
    names = "HOME", "XDG_CACHE_HOME", "LOCALAPPDATA", "USERPROFILE", "NUMBA_CACHE_DIR"
    closed = os.environ | {name: str(blocked) for name in names} | {"PYTHONPATH": str(here), "NUMBA_OPT": "0"}
    command = [sys.executable, "-m", "solver", "run", "--set", "surface=flat", "nodes=16", "width=40", "u_x_max=1"]
    run = subprocess.run(command, capture_output=True, text=True, env=closed, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert run.stderr.count("NUMBA_CACHE_DIR") == 1 and "Traceback" not in run.stderr
