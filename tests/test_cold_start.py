"""A first run compiles each kernel once: compiling takes seconds, and doubles with every second type."""

import pkgutil
from importlib import import_module

from solver import Scene, continuation, load_path, mechanics, run

SCENES = [
    Scene(u_x_max=9.0),
    Scene(nodes=128, width=312.5, radius=10.0, u_x_max=9.0),  # the patch becomes the whole cell
    Scene(surface="flat", nodes=64, width=156.25, u_x_max=6.0),
    Scene(hold="load", delta_bar=0.3, u_x_max=9.0),
]
TWO = {"fill"}  # in single precision as a preconditioner, in double where iterative solves of a fold fail


def kernels():
    """{name: dispatcher} of all compiled functions of a run."""
    modules = [
        import_module(f"{p.__name__}.{m.name}")
        for p in (continuation, mechanics, run)
        for m in pkgutil.iter_modules(p.__path__)
    ]
    return {
        f"{k.__module__}.{name}": k for m in modules for name, k in vars(m).items() if hasattr(k, "nopython_signatures")
    }


def test_kernels_are_compiled_for_one_type_whatever_the_scene():
    for scene in SCENES:
        assert [*load_path(scene)]
    several = {name: k.nopython_signatures for name, k in kernels().items() if len(k.nopython_signatures) > 1}
    assert {name: types for name, types in several.items() if name.split(".")[-1] not in TWO} == {}
