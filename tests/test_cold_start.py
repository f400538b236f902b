"""A first run compiles each kernel once: each compilation takes a tenth of a second or more."""

import json
import subprocess
import sys

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
    assert types["window_sums"] == 1
    assert {name: count for name, count in types.items() if count > 1} == {}
