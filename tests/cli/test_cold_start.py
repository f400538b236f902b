"""A first run compiles each kernel once: each compilation takes a tenth of a second or more."""

import json
import os
import subprocess
import sys

import pytest

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
    assert types["_window_sums"] == 1
    assert {name: count for name, count in types.items() if count > 1} == {}


@pytest.mark.thorough
def test_a_new_worker_counts_the_kernels_it_compiles(tmp_path):
    script = "from app.service import worker; print([*worker.start_up()], worker.KERNELS)"
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=cold)
    counts, kernels = run.stdout.rsplit(" ", 1)
    assert json.loads(counts) == [*range(1, int(kernels) + 1)]
